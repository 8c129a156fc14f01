"""From a recorded sweep at a known load to the model of today, or to the reason why it stays; with its figure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from musclewire.errors import CallerError, FitRejectedError, RecordingError, argument
from musclewire.identify._home.overlay import Overlay, overlay_of
from musclewire.identify._home.warming import HeatCourse, SeenPoints, course_of, seen_points
from musclewire.identify._use_of_model import SAME_LOAD_FRACTION
from musclewire.sensing import DRIFT_FRACTION, SHOWN_AS, HomeMove, SensingModel, with_resistances
from musclewire.signals import Recording
from musclewire.wire import HeatBalance

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# Error of the resistance found at B, as a fraction of it.
SAME_AIR_FRACTION = 3.2e-4  # if the air is that of the loop
AIR_FRACTION_PER_K = 1e-4  # per kelvin of the air's change [1/K]: martensite differs a little in warmer air
# Standard deviations of a change from which on it is corrected.
CERTAIN_STDS = 2.0
# Standard deviations within which C has not moved, of a wire whose B has not.
KEPT_STDS = 4.0
# [1/K] by which martensite's resistivity rises, as a fraction (Churchill and Shaw, SMASIS2009-48968).
MARTENSITE_PER_K = 0.5e-3
SHIFT_FRACTION = 0.5  # of the change of resistance by a shift of the transformation, to which that change is known
# A factor of the resistance moves C by the ratio of the resistances at C and B of what it moves B, and an offset by as
# much; a load moves it by 0.2 to 0.6 of it, or back. A change is ageing if its ratio is that near to both, and known.
RATIO_TOLERANCE = 0.17
RATIO_STD = 0.25  # of the change at B: the largest standard deviation of that at C
# Resistance of one wire changes by less than this in its life, joints and leads included (0.5 ohm of 17); more is
# another wire.
MAX_CHANGE = 0.06
# No wire's transformation moves further [K], with air, load and alloy together; more is another flow of air, or another
# length or shunt than was stated.
MAX_WARMER_K = 25.0
# A sweep that shows less did not heat the wire far enough:
MIN_FALL = 0.85  # of the fall of resistance in the loop
MIN_COVERED = 0.93  # of the points of the loop
# A curve that fits worse than this fraction of its span has another shape.
MAX_MISFIT = 0.04
MAX_AIR_CHANGE_K = 60.0  # [K] from the air of the characterization: more is a wrong unit
ZERO_CELSIUS_K = 273.15
# Standard deviations of what is known before the sweep:
AIR_STD_K = 8.0  # [K] of the change of the air without a thermometer
MEASURED_STD_K = 0.5  # [K] of it with one
LOSS_FRACTION = 0.03  # of the heat loss
SHAPE_STD_K = 1.5  # [K] of the shift by comparing two curves; chosen: a larger one doubts true changes


@dataclass(frozen=True)
class Homing:
    """What a home move found, and the model that follows."""

    model: SensingModel  # the model of today; the same curve if nothing was corrected
    home: HomeMove  # what was found; it is also in the model
    # Change of the resistance at B [ohm] since the model was made, and its standard deviation [ohm].
    resistance_max_moved_ohm: float
    resistance_max_moved_std_ohm: float
    # The same at C [ohm].
    resistance_min_moved_ohm: float
    resistance_min_moved_std_ohm: float
    # By how much warmer than before the wire transforms, judged by its power: by the transformation temperatures, the
    # load, the loss to the air and, without a thermometer, the air's temperature together.
    warming_moved_k: float
    misfit_ohm: float  # root mean square of what the corrected curve leaves of the sweep
    seen: SeenPoints  # which points the sweep shows
    # What was not seen, what cannot be separated, and why nothing was corrected, a sentence each.
    notes: tuple[str, ...]


def homed_model(
    model: SensingModel,
    recording: Recording,
    *,
    load_n: float | None = None,
    ambient_k: float | None = None,
    cycles: float | None = None,
) -> Homing:
    """Return the model of today from a recorded home sweep: pure, and driven by nobody.

    ``load_n`` is given if it is known to be that of the characterization; otherwise what has changed must show in B and
    C. ``ambient_k`` is measured, by default by the recording's own thermometer, and compared with what the model
    states. Raises CallerError for a model without the power of its loop, another load than the model's, or air of an
    impossible temperature, RecordingError for a sweep that is incomplete or began warm, and FitRejectedError for one
    that a changed load explains as well as a changed wire, and for one of another shape, another wire, or numbers that
    no wire has.
    """
    assumed_n = require_load(model, load_n)
    before = loop_of(model)
    sweep, heat = course_of(recording), HeatBalance.stated_in(recording.facts)
    seen = seen_points(sweep)
    b_ohm = require_complete(model, seen)
    air = SweepAirTemperature.from_recording(model, recording, ambient_k)
    span_ohm = model.resistance_max_ohm - model.resistance_min_ohm
    found = overlay_of(before, sweep, heat, span_ohm, (model.resistance_max_ohm, b_ohm))
    require_one_wire(model, found)
    moved = WireChange.from_overlay(model, found, b_ohm, air)
    moved.require_explained(load_is_known=load_n is not None)
    home = home_move(model, recording, found, moved)
    home = replace(home, load_n=assumed_n, ambient_k=air.measured_k, cycles=cycles)
    return Homing(
        model=replace(with_resistances(model, *scale_and_offset(model, moved)) if moved.corrects else model, home=home),
        home=home,
        resistance_max_moved_ohm=moved.at_b_ohm,
        resistance_max_moved_std_ohm=moved.std_at_b_ohm,
        resistance_min_moved_ohm=moved.at_c_ohm,
        resistance_min_moved_std_ohm=moved.std_at_c_ohm,
        warming_moved_k=moved.warming_k,
        misfit_ohm=found.misfit_ohm,
        seen=seen,
        notes=notes_on(seen, moved, air),
    )


class SweepAirTemperature(NamedTuple):
    """The air's temperature in the sweep, and its change since the characterization [K], None if unknown."""

    measured_k: float | None
    change_k: float | None

    @classmethod
    def from_recording(cls, model: SensingModel, recording: Recording, ambient_k: float | None) -> SweepAirTemperature:
        """Return what is known: the measured temperature, or the mean of the recording's own thermometer."""
        column = recording.columns.get("ambient_temperature_k")
        if ambient_k is None and column is not None and np.isfinite(column).any():
            ambient_k = float(np.nanmean(column))
        before_k = model.wire.get("ambient_temperature_k")
        if ambient_k is None or not isinstance(before_k, int | float):
            return cls(ambient_k, None)
        if not abs(ambient_k - before_k) < MAX_AIR_CHANGE_K:
            now, then = (f"{kelvins - ZERO_CELSIUS_K:.4g} degC" for kelvins in (ambient_k, before_k))
            raise CallerError(
                f"air of {now}, and of {then} at the characterization: give the temperature of the air around the "
                "wire, with its unit ('22 degC')"
            )
        return cls(ambient_k, ambient_k - before_k)


class WireChange(NamedTuple):
    """What a sweep says about the wire as a whole."""

    warming_k: float  # by how much warmer it transforms, a known change of the air taken off
    warming_std_k: float
    at_b_ohm: float  # change at B
    std_at_b_ohm: float
    at_c_ohm: float  # change at C
    std_at_c_ohm: float
    by_shift_ohm: float  # change at B that so much warmer martensite makes
    ratio_of_a_factor: float  # change at C over that at B, if it were a factor of the resistance
    largest_ohm: float  # largest change of one wire

    @classmethod
    def from_overlay(cls, model: SensingModel, found: Overlay, b_ohm: float, air: SweepAirTemperature) -> WireChange:
        """Return it from how the loop's fall lies over that of the sweep, which begins at ``b_ohm``."""
        low_ohm, high_ohm = model.resistance_min_ohm, model.resistance_max_ohm
        span_ohm = high_ohm - low_ohm
        warming_k = found.warmer_k + (air.change_k or 0.0)
        air_k, air_std_k = (AIR_STD_K, AIR_STD_K) if air.change_k is None else (abs(air.change_k), MEASURED_STD_K)
        std_at_b_ohm = hypot(SAME_AIR_FRACTION, AIR_FRACTION_PER_K * air_k) * high_ohm
        return cls(
            warming_k=warming_k,
            warming_std_k=hypot(SHAPE_STD_K, LOSS_FRACTION * found.middle_k, air_std_k),
            at_b_ohm=b_ohm - high_ohm,
            std_at_b_ohm=std_at_b_ohm,
            at_c_ohm=b_ohm - high_ohm - (found.scale - 1.0) * span_ohm,
            std_at_c_ohm=found.scale_std * span_ohm,
            by_shift_ohm=MARTENSITE_PER_K * high_ohm * warming_k,
            ratio_of_a_factor=low_ohm / high_ohm,
            largest_ohm=MAX_CHANGE * high_ohm,
        )

    @property
    def certain(self) -> bool:
        """Whether B has moved."""
        return abs(self.at_b_ohm) > CERTAIN_STDS * self.std_at_b_ohm

    @property
    def shifted(self) -> bool:
        """Whether a shift of the transformation is all there is to it, under which the curve holds."""
        left_ohm = abs(self.at_b_ohm - self.by_shift_ohm)
        return self.certain and left_ohm < hypot(self.std_at_b_ohm, SHIFT_FRACTION * self.by_shift_ohm)

    @property
    def of_resistance(self) -> bool:
        """Whether C has moved as it does with a factor or an offset of the resistance, and with no load."""
        ratio = self.at_c_ohm / self.at_b_ohm
        away = max(self.ratio_of_a_factor - ratio, ratio - 1.0)
        return away < RATIO_TOLERANCE and self.std_at_c_ohm < RATIO_STD * abs(self.at_b_ohm)

    @property
    def corrects(self) -> bool:
        """Whether the curve is to be moved."""
        return self.certain and (self.of_resistance or not self.shifted)

    def require_explained(self, *, load_is_known: bool) -> None:
        """Raise FitRejectedError for what a wire's own drift does not explain: another wire, or another load."""
        if abs(self.warming_k) > MAX_WARMER_K:
            raise FitRejectedError(
                f"by its power the wire transforms {self.warming_k:+.0f} K away, and no wire's transformation moves by "
                f"more than {MAX_WARMER_K:g} K: the air around it moves more or less than at the characterization, or "
                "length, diameter or shunt are stated wrongly"
            )
        if abs(self.at_b_ohm) > self.largest_ohm:
            raise FitRejectedError(
                f"the resistance at B moved by {self.at_b_ohm:+.3g} ohm, more than {100 * MAX_CHANGE:g} %: this is "
                "another wire, or a bad contact"
            )
        moved = (
            f"the resistance moved by {self.at_b_ohm:+.3g} +- {self.std_at_b_ohm:.2g} ohm at B and by "
            f"{self.at_c_ohm:+.3g} +- {self.std_at_c_ohm:.2g} ohm at C"
        )
        if not self.certain and abs(self.at_c_ohm) > KEPT_STDS * self.std_at_c_ohm:
            raise FitRejectedError(f"{moved}, which no ageing and no load does: characterize again")
        if not self.certain or self.of_resistance or (load_is_known and self.shifted):
            return
        if load_is_known:
            raise FitRejectedError(
                f"{moved}, which is not what age, leads or a shift of the transformation do: set the load of the "
                "characterization, or characterize again"
            )
        raise FitRejectedError(
            f"{moved}; where the resistance has changed C moves by {self.ratio_of_a_factor:.2g} to 1 times as much as "
            "B, so that this is another load, or a shifted transformation: if the load is that of the characterization "
            "say so (" + argument("load_n") + "), or set it, or characterize again"
        )


def loop_of(model: SensingModel) -> HeatCourse:
    """Return the loop that a model was fitted to. Raises CallerError if the model does not contain its power."""
    if not model.slow_loop:
        raise CallerError(
            "this model does not contain the power of its loop, with which a home move compares: fit it again, to a "
            "recording with wire_voltage_v"
        )
    time_s, power_w, resistance_ohm = (np.array(column) for column in zip(*model.slow_loop, strict=True))
    return HeatCourse(time_s, power_w, resistance_ohm)


def require_load(model: SensingModel, load_n: float | None) -> float | None:
    """Return the force of the cold wire [N]. Raises CallerError for another one than at the characterization."""
    before = model.wire.get("pretension_n")
    if not isinstance(before, int | float):
        return load_n
    if load_n is not None and abs(load_n - before) > SAME_LOAD_FRACTION * before:
        raise CallerError(
            f"the load is {load_n:g} N and was {before:g} N at the characterization: its effect on the resistance "
            "cannot be separated from ageing; make the home move at the same load, or characterize again at this one"
        )
    return float(before)


def require_complete(model: SensingModel, seen: SeenPoints) -> float:
    """Return the resistance at B [ohm]. Raises RecordingError for a sweep that began warm or was not heated enough."""
    if seen.heating_b_ohm is None:
        raise RecordingError(
            "the sweep began above point B (no rise of the resistance before its fall): let the wire cool first"
        )
    span_ohm = model.resistance_max_ohm - model.resistance_min_ohm
    fell = (seen.heating_b_ohm - seen.lowest_ohm) / span_ohm
    if fell < MIN_FALL:
        raise incomplete_sweep(f"the resistance fell by {100 * fell:.0f} % of the loop's {span_ohm:.3g} ohm", MIN_FALL)
    return seen.heating_b_ohm


def incomplete_sweep(shown: str, needed: float) -> RecordingError:
    """Return the error of a sweep that ended before the loop's hottest point."""
    return RecordingError(
        f"the sweep is not complete: {shown}, {100 * needed:.0f} % are needed; a draught, colder air, a larger load or "
        "the drive's limit keep a wire from transforming"
    )


def require_one_wire(model: SensingModel, found: Overlay) -> None:
    """Raise RecordingError for a sweep that ends before the loop, and FitRejectedError for one of another shape."""
    if found.covered < MIN_COVERED:
        raise incomplete_sweep(f"it passed {100 * found.covered:.0f} % of what the loop shows", MIN_COVERED)
    span_ohm = model.resistance_max_ohm - model.resistance_min_ohm
    if found.misfit_ohm > MAX_MISFIT * span_ohm:
        raise FitRejectedError(
            f"the sweep has another shape than the loop, by {100 * found.misfit_ohm / span_ohm:.1f} % of its fall "
            f"({100 * MAX_MISFIT:g} % are allowed): another load or another wire; characterize again"
        )


def home_move(model: SensingModel, recording: Recording, found: Overlay, moved: WireChange) -> HomeMove:
    """Return what the model's file keeps, counted from the characterization."""
    low_ohm, high_ohm = model.resistance_min_ohm, model.resistance_max_ohm
    span_ohm = high_ohm - low_ohm
    scale, offset_ohm = scale_and_offset(model, moved) if moved.corrects else (1.0, 0.0)
    scale_std = hypot(moved.std_at_c_ohm, moved.std_at_b_ohm) / span_ohm
    before = model.home
    was = (1.0, 0.0) if before is None else (before.resistance_scale, before.resistance_offset_ohm)
    return HomeMove(
        time=recording.facts.text_or_none("start_time") or "",
        moves=1 if before is None else before.moves + 1,
        cycles=None,
        load_n=None,
        ambient_k=None,
        corrected=moved.corrects,
        resistance_scale=scale * was[0],
        resistance_scale_std=scale_std,
        resistance_offset_ohm=scale * was[1] + offset_ohm,
        resistance_offset_std_ohm=hypot(moved.std_at_b_ohm, high_ohm * scale_std),
        transformation_shift_k=moved.warming_k,
        transformation_shift_std_k=moved.warming_std_k,
        convection_ratio=found.stretch,
        convection_ratio_std=hypot(found.stretch_std, LOSS_FRACTION),
        drift_resistance_ohm=hypot(DRIFT_FRACTION * span_ohm, moved.std_at_b_ohm),
    )


def scale_and_offset(model: SensingModel, moved: WireChange) -> tuple[float, float]:
    """Return scale and offset [ohm] of today's resistance over the model's."""
    low_ohm, high_ohm = model.resistance_min_ohm, model.resistance_max_ohm
    scale = 1.0 + (moved.at_b_ohm - moved.at_c_ohm) / (high_ohm - low_ohm)
    return scale, moved.at_c_ohm - (scale - 1.0) * low_ohm


def notes_on(seen: SeenPoints, moved: WireChange, air: SweepAirTemperature) -> tuple[str, ...]:
    """Return what was not seen, what cannot be separated, and why nothing was corrected."""
    notes = []
    if seen.c_ohm is None:
        notes.append("C was not seen: the resistance still falls where the drive turned, so only B and the fall count")
    if seen.cooling_b_ohm is None:
        notes.append("B was seen on heating only")
    if air.change_k is None:
        notes.append(
            "without the air's temperature then and now, a shift of the transformation and warmer air look alike "
            f"(+-{moved.warming_std_k:.0f} K)"
        )
    if moved.shifted and not moved.corrects:
        notes.append(
            f"the change at B of {moved.at_b_ohm:+.3f} ohm is that of a transformation shifted by "
            f"{moved.warming_k:+.1f} K, under which the curve holds: it stays as it was"
        )
    elif not moved.certain:
        notes.append(
            f"the change at B of {moved.at_b_ohm:+.3f} ohm is within {CERTAIN_STDS:g} times its uncertainty of "
            f"{moved.std_at_b_ohm:.3f} ohm: the model's curve stays as it was"
        )
    return tuple(notes)


POINTS = 200


def homing_figure(before: SensingModel, found: Homing, *, style: str = "screen") -> Figure:
    """Draw a model's curve before and after a home move, and how far its resistance moved at B and C.

    Bars are two standard deviations. Raises CallerError for an unknown style; the message suggests the nearest.
    """
    from musclewire.figures import panels_side_by_side

    figure, (curves, moved) = panels_side_by_side(style, 2)
    with figure.styled():
        draw_curves(curves, before, found.model)
        draw_moved(moved, found)
    return figure


def draw_curves(axes: Axes, before: SensingModel, today: SensingModel) -> None:
    """Draw the mean of both branches of both models over their own range."""
    from musclewire.pages import AVERAGE, TARGET

    factor, unit = SHOWN_AS[before.quantity]
    thin = axes.figure.style.line_pt  # type: ignore[union-attr]  # our figures have a style
    for model, colour, width, name in ((before, TARGET, 2.5 * thin, "before"), (today, AVERAGE, thin, "today")):
        quantity = np.linspace(model.quantity_min, model.quantity_max, POINTS)
        axes.plot(model.resistance_ohm(quantity), factor * quantity, color=colour, linewidth=width, label=name)
    axes.set(xlabel="wire resistance [ohm]", ylabel=f"{before.quantity} [{unit}]")
    axes.legend()


def draw_moved(axes: Axes, found: Homing) -> None:
    """Draw the change of the resistance at B and C with two standard deviations, and say whether it was corrected."""
    from musclewire.pages import COOLING, HEATING, TARGET

    axes.axhline(0.0, color=TARGET, linewidth=0.8)
    points = (
        (found.resistance_max_moved_ohm, found.resistance_max_moved_std_ohm, COOLING, "o"),
        (found.resistance_min_moved_ohm, found.resistance_min_moved_std_ohm, HEATING, "s"),
    )
    for place, (value, std, colour, marker) in enumerate(points):
        axes.errorbar(place, value, 2.0 * std, color=colour, marker=marker, capsize=4)
    axes.set_xticks((0, 1), ("at B, cold", "at C, hot"))
    axes.set(xlim=(-0.5, 1.5), ylabel="change of\nthe resistance [ohm]")
    axes.set_title("the model is corrected" if found.home.corrected else "the model keeps its curve")
