"""Every printed number of the paper compared with ours: checks, the runs they need, and the verdict."""

from musclewire.experiment.reproduce.loops import Loop
from musclewire.experiment.reproduce.paper_checks import PaperCheck, ReproductionRow, judged, selected
from musclewire.experiment.reproduce.reproduction import Reproduction, all_checks, reproduce
from musclewire.experiment.reproduce.runs import Runs

__all__ = [
    "PaperCheck",
    "Loop",
    "Reproduction",
    "ReproductionRow",
    "Runs",
    "all_checks",
    "judged",
    "reproduce",
    "selected",
]
