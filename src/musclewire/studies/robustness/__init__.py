"""The benchmark of estimators and controllers under disturbance: ``musclewire robustness``."""

from musclewire.studies.robustness.benchmark import Robustness, Selection, robustness
from musclewire.studies.robustness.population import held_out_seeds, tuning_seeds
from musclewire.studies.robustness.store import BenchmarkRun, runs_of

__all__ = ["BenchmarkRun", "Robustness", "Selection", "held_out_seeds", "robustness", "runs_of", "tuning_seeds"]
