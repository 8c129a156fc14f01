"""The pretension sweep: which F_p closes the loop best (Figs. 4 to 6, and 17 for a finger)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import floor
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from musclewire.errors import CallerError, RecordingError, nearest_hint
from musclewire.experiment._open_loop import SlowSine, characterize
from musclewire.experiment._run import OnSample, file_in
from musclewire.experiment._run_warnings import instrument_warnings
from musclewire.identify import LoopGaps, extrapolation_warnings, loop_gaps, reached_in, whole_section_m2
from musclewire.parameters import ValidityLimits, exceeds
from musclewire.rigs import HasStage, Rig, ability
from musclewire.signals import QUANTITIES, MetadataValue, Recording, RunFacts

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# The paper's Fig. 6 spans force ratios from about a quarter to two thirds of the allowed force.
FORCE_RATIOS = (0.20, 0.65)
DEFAULT_POINTS = 8
# A stage set below that range carries something softer than a bias spring: the sweep then goes around its setting.
SETTING_RATIOS = (0.25, 2.0)
# Where the vendor's stress ends the range, it begins at most at this fraction of that pretension.
MIN_OF_LARGEST = 0.35
# A setting at the vendor's stress in motion is added to the default ones if none is as near to it [N over the limit].
NEAR_LIMIT = 0.02
COLOURS = {"strain": "#1f6f8b", "force": "#c8553d", "displacement": "#1f6f8b"}


@dataclass(frozen=True)
class PretensionRow:
    """One setting of the linear stage and the loop it gave.

    Parameters
    ----------
    pretension_n
        Setting [N].
    strain_gap_pct
        Gap of strain, of its largest value [%] (Eq. 2).
    force_gap_pct
        Gap of force [%]; None without a load cell or without a spring.
    displacement_gap_pct
        Gap of displacement [%] (Eq. 9); None without its instrument.
    stroke_pct
        Strain from cold to hot [%].
    recording
        The loop.
    no_force_gap
        Why there is no gap of force; "" if there is one.
    largest_force_n
        Largest pull of the wire in the loop [N]; the pretension without a load cell, None if the rig does not state its
        wire.
    within_limit
        Whether that is within the stress that the wire's vendor names for many cycles; True if no limit is known.
    """

    pretension_n: float
    strain_gap_pct: float
    force_gap_pct: float | None
    displacement_gap_pct: float | None
    stroke_pct: float
    recording: Recording
    no_force_gap: str = ""
    largest_force_n: float | None = None
    within_limit: bool = True

    def gap_pct(self, quantity: str) -> float | None:
        """Return the gap of strain, force or displacement; None if there is none in the recording."""
        gaps = {
            "strain": self.strain_gap_pct,
            "force": self.force_gap_pct,
            "displacement": self.displacement_gap_pct,
        }
        return gaps[quantity]


@dataclass(frozen=True)
class PretensionSweep:
    """All settings of a sweep; ``best`` is the one with the smallest gap of the quantity to be sensed.

    Parameters
    ----------
    rows
        The settings that gave a loop, with their gaps, in their order.
    failures
        A sentence for each setting that gave none.
    quantity
        The quantity whose gap decides: "strain", "displacement" or "force".
    warnings
        A sentence for each setting at which the wire pulled harder than it may, and what the recommended setting and
        those of the lowest and the highest stress exceed.
    limit_n
        Pull [N] under which the wire has the stress that its vendor names for many cycles; None if the rig does not
        state it.
    largest_n
        Largest pretension [N] at which the wire would not pull harder than that while it contracts, from the loop
        nearest to it; 0 if none is left, None without a limit.
    """

    rows: tuple[PretensionRow, ...]
    failures: tuple[str, ...]
    quantity: str = "strain"
    warnings: tuple[str, ...] = ()
    limit_n: float | None = None
    largest_n: float | None = None

    @property
    def best(self) -> PretensionRow | None:
        """The setting with the smallest gap of those whose wire is within its vendor's stress; None if none is."""
        return smallest_gap([row for row in self.rows if row.within_limit], self.quantity)

    @property
    def advice(self) -> str:
        """What helps where the vendor's stress leaves no setting, or not that of the smallest gap; "" if it does."""
        best, smallest = self.best, smallest_gap(self.rows, self.quantity)
        if smallest is None or smallest is best or self.limit_n is None:
            return ""
        limit = f"the {self.limit_n:.2f} N of its vendor's stress for many cycles"
        if best is None:
            least = min(self.rows, key=lambda row: row.largest_force_n or 0.0)
            return (
                f"no pretension of these is within the wire's limit: at {least.pretension_n:.2f} N it pulls with up to "
                f"{least.largest_force_n:.2f} N in motion, above {limit}: take a softer spring, a dead weight of up to "
                f"{self.limit_n:.2f} N, or a thicker wire"
            )
        return (
            f"a smaller gap, {smallest.gap_pct(self.quantity):.2f} %, is at {smallest.pretension_n:.2f} N, but there "
            f"the wire pulls with up to {smallest.largest_force_n:.2f} N in motion, above {limit}. A softer spring "
            f"with more pretension comes nearer to it, a dead weight of up to {self.limit_n:.2f} N nearest; or keep "
            "this setting and follow each branch, as the estimator 'filter' does, the closed loop's own"
        )

    def plot(self, axes: Axes | None = None, *, style: str = "screen") -> Axes:
        """Plot the gaps against pretension, that of the sweep's quantity first.

        Parameters
        ----------
        axes
            Axes to draw on; those of a new figure by default.
        style
            Size and fonts of the new figure, as in ``Recording.plot``; axes that are given keep their own.

        Returns
        -------
        The axes; ``sweep.plot().figure.savefig("gaps.pdf")`` writes their figure.

        Raises
        ------
        CallerError
            For an unknown style; the message suggests the nearest.
        """
        from musclewire.figures import axes_to_draw_on

        with axes_to_draw_on(axes, style) as here:
            for quantity in dict.fromkeys((self.quantity, "force")):
                shown = [(row.pretension_n, gap) for row in self.rows if (gap := row.gap_pct(quantity)) is not None]
                line = "o-" if quantity == self.quantity else "s--"
                if shown:
                    here.plot(*zip(*shown, strict=True), line, color=COLOURS[quantity], label=f"{quantity} gap")
            self._mark_best(here)
            here.set(xlabel="pretension $F_p$ [N]", ylabel="hysteresis gap [% of maximum]")
            here.set_ylim(0.0, 1.2 * here.get_ylim()[1])  # room above all gaps for the legend
            here.legend(frameon=False, loc="upper left", ncols=2)
            return here

    def _mark_best(self, axes: Axes) -> None:
        if self.best is None:
            return
        best_n = self.best.pretension_n
        axes.axvline(best_n, ymax=0.85, color="0.7", linewidth=1.0, zorder=0)
        right = best_n > 0.5 * sum(axes.get_xlim())
        at: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "xytext": (-4 if right else 4, 0),
                              "textcoords": "offset points", "ha": "right" if right else "left"}  # fmt: skip
        # At the foot, where no gap is.
        axes.annotate(f"best {best_n:.2f} N", (best_n, 0.03), color="0.35", **at)


def smallest_gap(rows: Sequence[PretensionRow], quantity: str) -> PretensionRow | None:
    """Return the row with the smallest gap of a quantity; None without rows."""
    gaps = [row.gap_pct(quantity) for row in rows]
    return rows[int(np.argmin([np.inf if gap is None else gap for gap in gaps]))] if rows else None


def limit_n_of(facts: Mapping[str, MetadataValue]) -> float | None:
    """Return the pull [N] that loads the wire by its vendor's stress for many cycles; None if unknown."""
    stress_pa, section = ValidityLimits.stated_in(facts).working_stress_pa, whole_section_m2(RunFacts(facts))
    return None if stress_pa is None or section is None else stress_pa * section


def largest_in_motion_n(rows: Sequence[PretensionRow], limit_n: float | None) -> float | None:
    """Return the largest pretension [N] within a limit of the pull in motion, None if unknown.

    What a load adds while the wire contracts hardly depends on the pretension: the nearest loop shows it.
    """
    pulls = [(row.pretension_n, row.largest_force_n) for row in rows if row.largest_force_n is not None]
    if limit_n is None or not pulls:
        return None
    pretension_n, force_n = min(pulls, key=lambda pull: abs(pull[1] - limit_n))
    return max(floor(100.0 * (pretension_n + limit_n - force_n)) / 100.0, 0.0)


def default_pretensions_n(rig: Rig) -> list[float]:
    """Return eight rising settings [N], rounded to 0.01 N: from 0.20 to 0.65 of the wire's allowed force.

    They end at the vendor's stress for many cycles (``working_stress`` of the alloy) in the cold wire where that is
    less, and begin at no more than 0.35 of it. A rig whose stage is set below that range is swept from a quarter of its
    setting to twice it. Raises CallerError if the rig does not state maximum_force_n.
    """
    stated = rig.metadata()
    allowed, setting = (stated.get(name) for name in ("maximum_force_n", "pretension_n"))
    if not isinstance(allowed, float):
        raise CallerError("this rig does not state maximum_force_n: give the pretensions to try")
    low, high = (ratio * allowed for ratio in FORCE_RATIOS)
    if isinstance(setting, float) and 0.0 < setting < low:
        low, high = (ratio * setting for ratio in SETTING_RATIOS)
    largest = limit_n_of(stated)
    if largest is not None and high > largest:
        low, high = min(low, MIN_OF_LARGEST * largest), largest
    settings = [round(float(force), 2) for force in np.linspace(low, high, DEFAULT_POINTS)]
    return settings if largest is None else [min(force, floor(100.0 * largest) / 100.0) for force in settings]


def pretension_sweep(
    rig: Rig,
    pretensions_n: Sequence[float] | None = None,
    *,
    quantity: str = "strain",
    folder: str | Path | None = None,
    on_setting: Callable[[float], None] | None = None,
    on_sample: OnSample | None = None,
    **sine: Unpack[SlowSine],
) -> PretensionSweep:
    """Find the pretension with the smallest hysteresis gap: characterize the wire at each and compare the gaps.

    A setting whose loop cannot be used (slack, or no transformation left at high stress) is kept as a failure with its
    reason.

    Parameters
    ----------
    rig
        The rig, open, with a stage that software can move.
    pretensions_n
        Settings [N]; if None, eight from 0.20 to 0.65 of the wire's allowed force, the paper's span, none of which
        loads the cold wire above the vendor's stress for many cycles, and one where the wire in motion reaches it.
    quantity
        Quantity whose gap decides: "strain", "displacement" or "force".
    folder
        Folder into which each setting is recorded as it runs, replacing an earlier sweep; nothing is written if None.
    on_setting
        Called with each pretension [N] once it is set.
    on_sample
        Called with every recorded row, numbers by column name; it may raise to stop the run.
    **sine
        amplitude_v, period_s and cycles of :func:`characterize`.

    Returns
    -------
    All settings with their gaps, the failures and the warnings.

    Raises
    ------
    CallerError
        For a rig without a stage that software can move, or an unknown quantity.
    RecordingError
        If no setting gives a loop, or none has an instrument for the quantity.

    References
    ----------
    Lan and Fan 2010, Figs. 4 to 6, and Fig. 17 for a finger.
    """
    stage = checked_stage(rig, quantity)
    limit_n = limit_n_of(rig.metadata())
    rows: list[PretensionRow] = []
    failures: list[str] = []
    warnings: list[str] = []

    def try_setting(pretension: float) -> None:
        stage.set_pretension(pretension)
        if on_setting is not None:
            on_setting(pretension)
        path = None if folder is None else file_in(folder, f"pretension-{pretension:.2f}N.h5")
        recording = characterize(rig, path=path, overwrite=True, on_sample=on_sample, minor_loop=False, **sine)
        warnings.extend(f"pretension {pretension:g} N: {warning}" for warning in instrument_warnings(recording))
        try:
            rows.append(row_of(float(pretension), loop_gaps(recording), recording))
        except RecordingError as error:
            failures.append(f"{pretension} N: {error}")

    for pretension in default_pretensions_n(rig) if pretensions_n is None else pretensions_n:
        try_setting(pretension)
    largest_n = largest_in_motion_n(rows, limit_n)
    if pretensions_n is None and at_limit_is_missing(rows, quantity, largest_n, limit_n):
        try_setting(largest_n or 0.0)
        rows.sort(key=lambda row: row.pretension_n)
    check_rows(rows, failures, quantity)
    warnings += warnings_of_settings(rows, quantity)
    return PretensionSweep(tuple(rows), tuple(failures), quantity, tuple(warnings), limit_n, largest_n)


def at_limit_is_missing(
    rows: Sequence[PretensionRow], quantity: str, largest_n: float | None, limit_n: float | None
) -> bool:
    """Return whether a setting at the vendor's stress in motion may be better than all that are within it."""
    if not largest_n or not limit_n or all(row.within_limit for row in rows):
        return False
    within = [row for row in rows if row.within_limit]
    if any(abs(row.pretension_n - largest_n) < NEAR_LIMIT * limit_n for row in within):
        return False
    best, tightest = smallest_gap(within, quantity), max(within, key=lambda row: row.pretension_n, default=None)
    return best is tightest


def warnings_of_settings(rows: Sequence[PretensionRow], quantity: str) -> list[str]:
    """Return what the recommended setting exceeds of its alloy's limits, then the lowest and the highest setting."""
    best = smallest_gap([row for row in rows if row.within_limit], quantity)
    by_force = sorted(rows, key=lambda row: row.pretension_n)
    named = [] if best is None else [(best, f"best, {best.pretension_n:g} N")]
    named += [(row, f"pretension {row.pretension_n:g} N") for row in (by_force[-1], by_force[0]) if row is not best]
    said = [f"{name}: {text}" for row, name in named for text in extrapolation_warnings(row.recording)]
    return list(dict.fromkeys(said))


def checked_stage(rig: Rig, quantity: str) -> HasStage:
    """Return the stage of a rig. Raises CallerError for a rig without one, or an unknown quantity."""
    if quantity not in QUANTITIES:
        raise CallerError(f"there is no quantity '{quantity}'{nearest_hint(quantity, QUANTITIES)}")
    stage = ability(rig, HasStage)
    if stage is None:
        raise CallerError(
            "the stage of this rig is moved by hand: set each pretension, run 'musclewire characterize', and "
            "compare the gaps that 'musclewire fit' prints"
        )
    return stage


def check_rows(rows: Sequence[PretensionRow], failures: Sequence[str], quantity: str) -> None:
    """Raise RecordingError if no setting gave a loop, or none an instrument for the quantity."""
    if not rows:
        raise RecordingError(f"no pretension gave a usable loop; the last: {failures[-1] if failures else 'none'}")
    if all(row.gap_pct(quantity) is None for row in rows):
        if quantity == "force" and rows[0].no_force_gap:
            raise RecordingError(f"there is no gap of force, {rows[0].no_force_gap}: sweep for another quantity")
        raise RecordingError(f"this rig has no instrument for {quantity}: sweep for another quantity")


def row_of(pretension_n: float, gaps: LoopGaps, recording: Recording) -> PretensionRow:
    """Return one setting's row, in percent."""
    reached, limits = reached_in(recording), ValidityLimits.stated_in(recording.metadata)
    largest_pa, section = reached.largest_stress_pa, reached.section_m2
    return PretensionRow(
        pretension_n=pretension_n,
        strain_gap_pct=100.0 * gaps.strain_gap,
        force_gap_pct=None if gaps.force_gap is None else 100.0 * gaps.force_gap,
        displacement_gap_pct=None if gaps.displacement_gap is None else 100.0 * gaps.displacement_gap,
        stroke_pct=100.0 * gaps.segments.strain_max,
        recording=recording,
        no_force_gap=gaps.no_force_gap,
        largest_force_n=None if largest_pa is None or section is None else largest_pa * section,
        within_limit=not exceeds(largest_pa, limits.working_stress_pa),
    )
