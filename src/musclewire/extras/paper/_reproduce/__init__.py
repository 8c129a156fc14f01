"""Every printed number of the paper compared with ours: checks, the runs they need, and the verdict over seeds."""

from musclewire.extras.paper._reproduce.all_checks import all_checks
from musclewire.extras.paper._reproduce.loops import SlowSineLoop
from musclewire.extras.paper._reproduce.paper_checks import PaperCheck, SeedResult, measured, selected
from musclewire.extras.paper._reproduce.reproduction import DEFAULT_SEEDS, Reproduction, reproduce
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.extras.paper._reproduce.verdicts import OriginCount, ReproductionRow, counts_by_origin, row_of_check

__all__ = [
    "DEFAULT_SEEDS",
    "SlowSineLoop",
    "SeedResult",
    "OriginCount",
    "PaperCheck",
    "Reproduction",
    "ReproductionRow",
    "RunCache",
    "all_checks",
    "counts_by_origin",
    "row_of_check",
    "measured",
    "reproduce",
    "selected",
]
