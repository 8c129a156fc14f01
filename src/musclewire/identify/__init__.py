"""From recordings to models: strain and resistance of a recorded wire, and the fit of one to the other."""

from musclewire.identify.sensing_model import EstimateReport, estimate, fit

__all__ = ["EstimateReport", "estimate", "fit"]
