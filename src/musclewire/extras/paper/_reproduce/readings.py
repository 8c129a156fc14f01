"""The other reading of Eq. 7 for Tables 2 and 3: from the first target on, reported and not judged."""

from __future__ import annotations

from functools import partial
from typing import Literal

import numpy as np

from musclewire.experiment import APPROACH_S, ControlMetrics, determined
from musclewire.extras.paper._reproduce.paper_checks import PREDICTED_OR_LISTED, PaperCheck
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.parameters import read_published

__all__ = ["AFTER_APPROACH", "from_first_target_checks"]

Table = Literal["table2", "table3"]
# What the judged rows add to their reason.
AFTER_APPROACH = (
    f"mae_approached: the first step counts after an approach of {APPROACH_S:g} s at its target; the paper does not "
    "say how its wire came there, and mae_from_first_target is the other reading"
)
FROM_FIRST_TARGET = (
    "Eq. 7 with the first step counted from the moment its target is first asked for, the wire coming from rest; its "
    f"first second is left out as in every step. In the judged rows the wire has {APPROACH_S:g} s more to come there. "
    "All other steps are those of the judged rows"
)
TARGETS = {"table2": "desired_strain_pct", "table3": "desired_displacement_mm"}


def from_first_target_checks(table: Table) -> list[PaperCheck]:
    """Return the errors of a table from the first target on, which count for no bar: first step, largest and mean."""
    printed = read_published("lan_fan_2010")[table]
    errors = [*printed["mae_rise_pct"], *printed["mae_return_pct"]]
    rows = (
        (f"first_pct[{printed[TARGETS[table]][0]:.1f}]", errors[0], first_mae_pct),
        ("largest_pct", max(errors), largest_mae_pct),
        ("mean_pct", round(float(np.mean(errors)), 3), mean_mae_pct),
    )
    return [
        PaperCheck(f"{table}.mae_from_first_target_{name}", paper, "% of target", 0.0, FROM_FIRST_TARGET,
            "printed", partial(measure, table=table), "reported", origin=PREDICTED_OR_LISTED)
        for name, paper, measure in rows
    ]  # fmt: skip


def metrics_of(runs: RunCache, table: Table) -> ControlMetrics:
    """Return the errors of a table's staircase."""
    return runs.control_run.metrics if table == "table2" else runs.finger.control_run.metrics


def first_mae_pct(runs: RunCache, *, table: Table) -> float:
    """Return the MAE of the first step from the first target on [% of target]."""
    return determined(metrics_of(runs, table).steps[0].mae_pct, "the error of the first step")


def largest_mae_pct(runs: RunCache, *, table: Table) -> float:
    """Return the largest MAE from the first target on [% of target]."""
    return determined(metrics_of(runs, table).mae_max_pct, "the largest error")


def mean_mae_pct(runs: RunCache, *, table: Table) -> float:
    """Return the mean of the MAE from the first target on [% of target]."""
    return determined(metrics_of(runs, table).mae_mean_pct, "the mean error")
