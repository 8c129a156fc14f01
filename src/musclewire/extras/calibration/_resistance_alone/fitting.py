"""Fit a self-sensing model to a recording of the resistance alone, with a named wire as prior."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, FitRejectedError, NumericsError
from musclewire.extras.calibration._physical.bench import SETTABLE, bench_of, checked_settings
from musclewire.extras.calibration._physical.candidates import CandidateParameters
from musclewire.extras.calibration._physical.posterior import PosteriorProblem, covariance, excess_variance
from musclewire.extras.calibration._physical.recording_kinds import start_of
from musclewire.extras.calibration._physical.search import (
    FINAL_STEP,
    ParallelProblem,
    graduated,
    jacobian,
    threads,
)
from musclewire.extras.calibration._resistance_alone.observation import (
    Marks,
    ResistanceAndMarks,
    electrical_part,
    leg_length_m,
    observe_resistance,
)
from musclewire.extras.calibration._resistance_alone.possible_curves import (
    BetterMeasurement,
    PossibleCurves,
    StrokeShare,
    costs_of,
    possible_curves,
    scale_and_offset_std,
    what_helps,
)
from musclewire.extras.calibration._resistance_alone.spreads import priors_around
from musclewire.identify import loop_notes, power_loop, stated_heat_balance, with_gains
from musclewire.judge import resistance_reading
from musclewire.parameters import Bench, Parameter, bench_known_with, require_seed
from musclewire.sensing import SensingModel, find_segments, fit_loop, with_wire_model
from musclewire.signals import Recording

# Factors on the observations' uncertainty, descent by descent; one start suffices, since the prior is a named wire.
SCALES = (30.0, 5.0, 1.0)
EVALUATIONS = 15


def posterior_wires(
    candidates: CandidateParameters, observation: ResistanceAndMarks, start: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, float]:
    """Return the likeliest wire, (n,), the covariance of those an observation leaves possible, (n, n), and the misfit.

    That is the root mean square of the residuals over their uncertainty, 1 for a wire that the model can be. The search
    (least squares, Laplace) starts at the prior's mean, or at ``start``, (n,), where one with less in it ended. Raises
    NumericsError if the named wire cannot be simulated on this bench and drive.
    """
    with threads(None) as pool:
        parallel = ParallelProblem(PosteriorProblem(candidates, [observation]), pool)
        begun, scales = (np.zeros(len(candidates)), SCALES) if start is None else (start, SCALES[-1:])
        cost, best = graduated(parallel, begun, scales, EVALUATIONS)
        if not np.isfinite(cost):
            raise NumericsError("the named wire cannot be simulated: check the recording's bench, drive and units")
        residuals = parallel.residuals(best)
        if residuals is None:
            raise NumericsError("the best wire cannot be simulated: report this with the recording")
        slope = jacobian(parallel, best, residuals, FINAL_STEP, central=True)
    unknowns = len(candidates)
    observed = residuals[:-unknowns]
    spread = covariance(slope[:-unknowns], excess_variance(observed, unknowns))
    return best, spread, float(np.sqrt(np.mean(observed**2)))


PAPER_ORDER = 6
DRAWN_WIRES = 80
# Residuals over their uncertainty, from which on they are those of another wire, or of another load:
OTHER_WIRE_MISFIT = 10.0  # the fit is refused
DOUBTFUL_MISFIT = 3.0  # the fit has a warning
# Marks whose difference is known worse than the stroke is without them, by this factor, would lessen its standard
# deviation by less than a twentieth.
COARSE = 3.0
# What costs less than this fraction of the stroke is not worth a line.
CHEAP = 5e-4
# A number further than this from that of the named wire, in standard deviations of the prior, is worth a word.
FAR = 3.0


@dataclass(frozen=True)
class ResistanceFit:
    """A model from resistance alone, how far it may be off, and what would make it better."""

    # The model. Its ``scale_std`` and ``offset_std`` are in the standard deviation of every estimate.
    model: SensingModel
    stroke: float  # the model's largest quantity, strain or displacement [m]
    stroke_std: float  # its standard deviation, in the same unit
    # Root mean square of the resistance's residuals over their uncertainty; 1 if the named wire can be this one.
    misfit: float
    costs: tuple[StrokeShare, ...]  # what each stated number costs, the dearest first
    # Measurements by the standard deviation of the stroke after them, the best first.
    helps: tuple[BetterMeasurement, ...]

    def __str__(self) -> str:
        """Return how far the model may be off and what would help, in a few lines."""
        off = 100.0 * self.stroke_std / self.stroke
        lines = [f"from resistance alone: the stroke may be off by {off:.2g} % (a standard deviation)"]
        dear = [item for item in self.costs if item.stroke_std >= CHEAP]
        lines += ["of that, what was stated:"] * bool(dear) + [f"  {item.text}" for item in dear]
        lines += ["what would help, the best first:"] * bool(self.helps)
        lines += [f"  {item.what}: {100.0 * item.stroke_std:.2g} % instead of {off:.2g} %" for item in self.helps]
        return "\n".join(lines)


class AssumedWire(NamedTuple):
    """What is assumed of a wire: its name, the unknowns around it, and notes on the stated bench."""

    wire: str
    candidates: CandidateParameters
    bench: Mapping[str, float]
    notes: tuple[str, ...]


def fit_resistance(
    recording: Recording,
    wire: str,
    *,
    bench: Mapping[str, float | str] | None = None,
    marks: Marks | None = None,
    order: int | str = PAPER_ORDER,
    quantity: str = "strain",
    seed: int = 1,
) -> ResistanceFit:
    """Fit a self-sensing model to a slow loop of which only the resistance was measured.

    The named wire, on the stated load, is simulated under the recording's drive; what differs between spools is found
    from the resistance, as far as the resistance shows it, and from two marks or an end stop if there are any. Both
    branches are those of the most likely wire, between the R_min and R_max that were measured. How far wires differ
    that the resistance leaves possible is the model's uncertainty. Instruments of motion in the recording are not used.

    Parameters
    ----------
    recording
        A slow loop from cold and back, as ``characterize`` records it: drive and resistance.
    wire
        The wire by name, or a wire file of a calibrated relative.
    bench
        Numbers of the bench that the recording does not state, by name, in SI or as text with a unit: wire_length_m,
        legs, pretension_n, spring_stiffness_n_per_m. None if the recording states all.
    marks
        Positions read off a ruler, or an end stop, with their errors; None if there are none.
    order
        Order of the polynomials, as in ``fit``.
    quantity
        "strain" or "displacement".
    seed
        Seed of the wires that are drawn to find the uncertainty.

    Returns
    -------
    The model, its uncertainty and what would lessen it.

    Raises
    ------
    RecordingError
        If the recording has no usable loop, or its drive is not recorded.
    CallerError
        For an unknown wire or quantity, an incomplete bench, or marks that contradict each other.
    FitRejectedError
        If the resistance is not that of the named wire on this load, or the fit cannot be inverted.
    NumericsError
        If the named wire cannot be simulated on this bench.

    References
    ----------
    Lan and Fan 2010, Eqs. 3 to 5, for the model; the prior's sources are in
    this folder's ``named-wire.toml``.

    Examples
    --------
    >>> import musclewire as mw
    >>> with mw.open_rig("simulated") as rig:
    ...     loop = mw.characterize(rig)
    >>> found = mw.fit_resistance(loop, "paper-100um")
    >>> 0.0 < found.stroke_std / found.stroke < 0.1
    True
    """
    if quantity not in ("strain", "displacement"):
        raise CallerError(
            f"without an instrument there is no model of {quantity}: fit strain, or displacement, and give the "
            "known stiffness where force is wanted"
        )
    require_seed(seed)
    known = marks or Marks()
    assumed = assumed_of(recording, wire, bench, known)
    observation = observe_resistance(recording, assumed.bench, known.end_stop_m, assumed.candidates.names)
    fitted = partial(fit_loop, order=order, quantity=quantity)
    found = possible_of(assumed, observation, fitted, seed)
    if found.misfit > OTHER_WIRE_MISFIT:
        raise FitRejectedError(
            f"the resistance is not that of {wire} on this load: it differs by {found.misfit:.0f} times its "
            "uncertainty from the nearest such wire; check the wire's name, its length, load and air"
        )
    notes: tuple[str, ...] = ()
    if known.stroke_m is not None:
        coarse = why_marks_are_left_out(found, known)
        if coarse:
            notes = (coarse,)
        else:
            observation = ResistanceAndMarks(observation.driven, known)
            found = possible_of(assumed, observation, fitted, seed, found.coordinates)
    return result_of(found, model_between_measured_ends(found, recording, observation, assumed), known, assumed, notes)


class PossibleWires(NamedTuple):
    """The likeliest wire that an observation leaves possible: its misfit, model and leg [m]; and the curves of some."""

    coordinates: FloatArray
    misfit: float
    model: SensingModel
    leg_m: float
    curves: PossibleCurves

    @property
    def metres_per_unit(self) -> float:
        """Displacement for one unit of the model's quantity."""
        return 1.0 if self.model.quantity == "displacement" else self.leg_m


def possible_of(
    assumed: AssumedWire,
    observation: ResistanceAndMarks,
    fitted: partial[SensingModel],
    seed: int,
    start: FloatArray | None = None,
) -> PossibleWires:
    """Return the wires that an observation leaves possible; ``fitted`` is the model of resistance and quantity."""
    candidates = assumed.candidates
    best, spread, misfit = posterior_wires(candidates, observation, start)
    drawn = np.random.default_rng(seed).multivariate_normal(best, spread, size=DRAWN_WIRES, method="cholesky")

    def model_of(coordinates: FloatArray) -> SensingModel:
        values = candidates.wire_values(coordinates)
        resistance_ohm, moved_m = observation.loop(values)
        per_m = 1.0 if fitted.keywords["quantity"] == "displacement" else 1.0 / leg_length_m(values)
        return fitted(resistance_ohm, per_m * moved_m)

    curves = possible_curves(np.clip(drawn, candidates.low, candidates.high), model_of)
    return PossibleWires(best, misfit, model_of(best), leg_length_m(candidates.wire_values(best)), curves)


def why_marks_are_left_out(found: PossibleWires, marks: Marks) -> str:
    """Return why marks are left out, whose own error would outweigh what they add; "" for marks that help."""
    known_m = float(found.curves.largest.std(ddof=1)) * found.metres_per_unit
    if marks.stroke_std_m <= COARSE * known_m:
        return ""
    return (
        f"the marks are left out: their difference is known to {1e3 * marks.stroke_std_m:.2g} mm, and from the wire's "
        f"name and its resistance the stroke is known to {1e3 * known_m:.2g} mm"
    )


def result_of(
    found: PossibleWires, model: SensingModel, marks: Marks, assumed: AssumedWire, notes: tuple[str, ...]
) -> ResistanceFit:
    """Return the model with its uncertainty, and what it rests on."""
    scale_std, offset_std = scale_and_offset_std(found.curves, model)
    if marks.end_stop_m is not None:
        scale_std = float(np.hypot(scale_std, marks.reading_std_m / marks.end_stop_m))
    stroke_std = float(np.hypot(scale_std * model.quantity_max, offset_std))
    warnings = (*model.warnings, *notes, *doubts(assumed, found, stroke_std / model.quantity_max))
    return ResistanceFit(
        replace(model, scale_std=scale_std, offset_std=offset_std, warnings=warnings, measured_stroke=0.0),
        model.quantity_max,
        stroke_std,
        found.misfit,
        tuple(costs_of(found.curves, assumed.candidates)),
        tuple(what_helps(found.curves, assumed.candidates, found.metres_per_unit)),
    )


def assumed_of(recording: Recording, wire: str, bench: Mapping[str, float | str] | None, marks: Marks) -> AssumedWire:
    """Return the unknowns of a named wire on the stated bench, whose length has the error of the ruler."""
    stated = {key: item.value for key, item in bench_known_with(wire).items()} | checked_settings(bench or {})
    start, notes = start_of({"the recording": recording}, wire, stated)
    known = bench_of(electrical_part(recording), stated)
    changed = {
        name: Parameter(value=value, unit=SETTABLE[name], kind="measured", source="the recording or the user")
        for name, value in known.items()
        if name in Bench.model_fields
    }
    its_bench = start.bench.model_copy(update=changed)
    priors = priors_around(start.alloy, start.wire, its_bench)
    unknown = dict(priors.parameters)
    length = unknown["wire_length_m"]
    std_m = its_bench.legs.value * marks.leg_length_std_m
    unknown["wire_length_m"] = length.model_copy(
        update={"std": std_m, "low": length.mean - 4.0 * std_m, "high": length.mean + 4.0 * std_m}
    )
    if marks.end_stop_m is not None:
        unknown.pop("spring_stiffness_n_per_m", None)  # the load's table holds the stated one
    candidates = CandidateParameters(
        priors.model_copy(update={"parameters": unknown}), start.alloy, start.wire, its_bench
    )
    return AssumedWire(wire, candidates, stated | {"diameter_m": start.wire.diameter_m.value}, tuple(notes))


def model_between_measured_ends(
    found: PossibleWires, recording: Recording, observation: ResistanceAndMarks, assumed: AssumedWire
) -> SensingModel:
    """Return the likeliest wire's model between measured B and C, with loops by the simulated motion."""
    reading = resistance_reading(recording)
    ticks_s = observation.driven.ticks_s()
    moved_m = observation.loop(assumed.candidates.wire_values(found.coordinates))[1]
    moved_m = np.interp(recording["time_s"] - recording["time_s"][0] + ticks_s[0], ticks_s, moved_m)
    measured = find_segments(reading.resistance_ohm, moved_m, reading.valid, quantity="displacement")
    electrical = electrical_part(recording)
    notes = {"leg_length_m": found.leg_m, **loop_notes(electrical), "wire": assumed.wire}
    model = replace(
        found.model,
        resistance_min_ohm=measured.resistance_min_ohm,
        resistance_max_ohm=measured.resistance_max_ohm,
        resistance_noise_ohm=measured.resistance_noise_ohm,
        slow_loop=power_loop(recording, reading, moved_m, "last", "displacement"),
        wire=notes | {"strain_from": f"the prior of {assumed.wire}, and resistance alone"},
        source=recording.facts.text_or_none("source") or "",
    )
    stated = stated_heat_balance(model, electrical.facts)
    return with_gains(with_wire_model(model, stated=stated), electrical.facts)


def doubts(assumed: AssumedWire, wires: PossibleWires, stroke_std: float) -> list[str]:
    """Return what a user of the model must know: that nothing was measured but resistance, and what is unusual."""
    found = [
        f"no motion was measured: the stroke is that of {assumed.wire} as far as the resistance shows, and may be off "
        f"by {196.0 * stroke_std:.2g} % (95 %)"
    ]
    if wires.misfit > DOUBTFUL_MISFIT:
        found.append(
            f"the resistance differs by {wires.misfit:.1f} times its uncertainty from the nearest {assumed.wire}: "
            "check the wire's name, its length, load and air"
        )
    far = [
        f"{name} by {place:+.1f}"
        for name, place in zip(assumed.candidates.names, wires.coordinates, strict=True)
        if abs(place) > FAR
    ]
    if far:
        found.append(f"unusual for {assumed.wire}, in standard deviations: {', '.join(far)}; is it this wire?")
    return [*found, *assumed.notes]
