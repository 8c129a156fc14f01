"""From recordings to models: what a recording says about a wire's strain and resistance, and the fit of both."""

from musclewire.identify.sensing_model import EstimateReport, estimate, fit

__all__ = ["EstimateReport", "estimate", "fit"]
