"""The bars of the benchmark, from their data file, checked by schema."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files

from pydantic import Field

from musclewire.extras.studies._robustness.settings import StrictTable
from musclewire.parameters import validated

FILE = "bars.toml"


class RowBar(StrictTable):
    """The bar of one kind of condition.

    Parameters
    ----------
    bar
        Its name, as conditions have it.
    polynomial_prototype_pct
        What the polynomial reached in the study of prototypes [%]; None if it was not run there.
    max_pct
        Largest error [%]; None for a row that is only reported.
    segmented_max_pct
        The same for wires in segments, where it differs.
    honest
        Whether intervals and validity are judged.
    """

    bar: str
    polynomial_prototype_pct: float | None = None
    max_pct: float | None = Field(default=None, gt=0.0)
    segmented_max_pct: float | None = Field(default=None, gt=0.0)
    honest: bool = True


class HonestBars(StrictTable):
    """Bars of intervals and validity, as fractions."""

    coverage_low: float
    coverage_high: float
    beyond_5_share: float
    valid_undisturbed: float
    valid_changed: float
    valid_before_b: float


class FlagBars(StrictTable):
    """Bars of flags."""

    in_time_fraction: float
    false_per_hour: float


class StaircaseBars(StrictTable):
    """Bars of the closed loop on the paper's staircase [%]."""

    first_pct: float
    other_pct: float
    mean_pct: float
    disturbed_mean_pct: float
    load_less_mean_pct: float
    after_home_mean_pct: float


class TemperatureBars(StrictTable):
    """Limits of the true temperature: mean over the length [K], and the hottest segment above it [K]."""

    limit_k: float
    hottest_above_k: float


class RobustnessBars(StrictTable):
    """The whole file."""

    default_estimator: str
    default_without_wire_file: str
    default_controller: str
    baseline_estimator: str
    baseline_fraction: float
    worst_wire_ratio: float
    gap_without_allowance_pct: float
    row: tuple[RowBar, ...]
    honest: HonestBars
    flags: FlagBars
    staircase: StaircaseBars
    temperature: TemperatureBars

    def bar_named(self, name: str) -> RowBar:
        """Return the bar of a kind of condition; one without a table is only reported."""
        return next((item for item in self.row if item.bar == name), RowBar(bar=name))

    def allowance(self, gap_pct: float) -> float:
        """Return by how much the bar of a wire is multiplied for the gap of its slow loop [%]."""
        return max(1.0, gap_pct / self.gap_without_allowance_pct)


@cache
def bars() -> RobustnessBars:
    """Return the bars that ship with musclewire."""
    text = (files("musclewire.extras.studies._robustness") / "data" / FILE).read_text("utf-8")
    return validated(RobustnessBars, tomllib.loads(text), f"robustness: {FILE}")
