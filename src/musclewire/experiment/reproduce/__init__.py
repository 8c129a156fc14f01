"""Every printed number of the paper compared with ours: checks, the runs they need, and the verdict over seeds."""

from musclewire.experiment.reproduce.all_checks import all_checks
from musclewire.experiment.reproduce.loops import Loop
from musclewire.experiment.reproduce.paper_checks import Measured, PaperCheck, measured, selected
from musclewire.experiment.reproduce.reproduction import DEFAULT_SEEDS, Reproduction, reproduce
from musclewire.experiment.reproduce.runs import Runs
from musclewire.experiment.reproduce.verdicts import OriginCount, ReproductionRow, counts_by_origin, judged

__all__ = [
    "DEFAULT_SEEDS",
    "Loop",
    "Measured",
    "OriginCount",
    "PaperCheck",
    "Reproduction",
    "ReproductionRow",
    "Runs",
    "all_checks",
    "counts_by_origin",
    "judged",
    "measured",
    "reproduce",
    "selected",
]
