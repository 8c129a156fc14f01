"""Functional mock-up units (FMI 2.0, co-simulation) of a wire on its load and of a controller."""

from musclewire.extras.interfaces._fmu.export import FMI_VERSION, Fmu, export_fmu, is_model

__all__ = ["FMI_VERSION", "Fmu", "export_fmu", "is_model"]
