"""The benchmark of estimators and controllers under disturbance: ``musclewire robustness``."""

from musclewire.extras.studies._robustness.benchmark import Robustness, Selection, robustness
from musclewire.extras.studies._robustness.population import held_out_seeds, tuning_seeds
from musclewire.extras.studies._robustness.store import BenchmarkRun, runs_of

__all__ = ["BenchmarkRun", "Robustness", "Selection", "held_out_seeds", "robustness", "runs_of", "tuning_seeds"]
