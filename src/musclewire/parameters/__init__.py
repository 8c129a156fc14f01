"""Wires, alloys, rigs and published results as data files: each number with unit, source and kind."""

from musclewire.parameters.library import load_alloy, load_bench, load_wire, names
from musclewire.parameters.parameter_groups import Alloy, Bench, Parameter, Wire

__all__ = ["Alloy", "Parameter", "Bench", "Wire", "load_alloy", "load_bench", "load_wire", "names"]
