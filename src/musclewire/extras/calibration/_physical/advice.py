"""What to measure next: experiments simulated with the fitted wire, and which parameters each of them would identify.

An experiment that has not been made has no residuals, but its simulation has a derivative, which is sufficient: its
information, added to that of recordings and prior, gives the width that each interval would have (Laplace).
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, TypeVar

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import MusclewireError
from musclewire.extras.calibration._physical.calibration import Calibration
from musclewire.extras.calibration._physical.candidates import CandidateParameters, WireValues, candidate_constants
from musclewire.extras.calibration._physical.cooling import CoolingObservation
from musclewire.extras.calibration._physical.driven import DrivenObservation
from musclewire.extras.calibration._physical.isobaric import IsobaricObservation
from musclewire.extras.calibration._physical.observations import Observation, RawChannel
from musclewire.extras.calibration._physical.posterior import IDENTIFIABLE_FRACTION, PosteriorProblem
from musclewire.extras.calibration._physical.search import ParallelProblem, jacobian, threads
from musclewire.identify import IsobaricLoop
from musclewire.parameters import ReachedConditions, ValidityLimits, beyond_validity, section_m2, validity_of
from musclewire.wire import isobaric_path

Clocked = TypeVar("Clocked", DrivenObservation, CoolingObservation)
MAX_ADVICE = 3
# Step of a derivative, in prior standard deviations, as in the search (search.py).
STEP = 0.1
# Typical instruments: noise of a sample; of resistance as a fraction.
NOISE = {"strain": 5e-5, "resistance": 3e-4, "force": 5e-3, "temperature": 0.3}
PERIOD_S = 90.0  # [s] of the slow sine
SAMPLE_S = 0.05  # [s] from one of its samples to the next
FAST_SAMPLE_S = 0.005  # [s] the same for a step
STEP_ON_S = 1.0  # [s] of the highest voltage in a step
STEP_WHOLE_S = 5.0  # [s] of a step with its cooling
MINOR_FACTOR = 0.875  # of the drive, with which a loop is a minor one
LOW_FACTOR = 0.5  # of the pretension
HIGH_FACTOR = 2.0  # of the pretension
SENSE_FRACTION = 0.05
ISOBAR_STRESSES_PA = (50e6, 100e6, 200e6)
ISOBAR_POINTS = 150  # temperatures of each branch of an isobar
ABOVE_TRANSFORMATION_K = 60.0  # [K] above the middle of the transformation, where isobar and cooling begin to fall
COOLING_S = 20.0  # [s] of a cooling curve
COOLING_SAMPLE_S = 0.02  # [s] from one of its samples to the next


@dataclass(frozen=True)
class ExperimentAdvice:
    """A recommended experiment: instructions, the parameters it would identify, and those it would narrow by half."""

    title: str
    text: str
    identifies: tuple[str, ...]
    narrows: tuple[str, ...]
    gain: float  # on all parameters: sum of the logarithms of deviation before over after


@cache
def texts() -> dict[str, Any]:
    """Return the texts of the data file."""
    return tomllib.loads((files("musclewire.extras.calibration._physical") / "data" / "advice.toml").read_text("utf-8"))


def how_to_identify(measure: str) -> str:
    """Return the kind of measurement that identifies a parameter, by the "measure" of its prior."""
    return str(texts()["measures"].get(measure, measure))


def next_experiments(calibration: Calibration) -> tuple[ExperimentAdvice, ...]:
    """Return what to measure next: the experiments that would identify most of what the recordings do not.

    Up to nine experiments are simulated, with a derivative by every parameter: it takes seconds.

    Parameters
    ----------
    calibration
        The calibration from the present recordings.

    Returns
    -------
    At most three experiments, the best first; none if no usual experiment would identify another parameter.
    """
    candidates, coordinates, information = all_parameters(calibration)
    now = deviations(information)
    found = []
    with threads(calibration.inputs.settings.threads) as pool:
        for key, experiment in proposed(calibration):
            try:
                slope = slope_of(experiment.refined(), candidates, coordinates, pool)
            except MusclewireError:
                continue  # the fitted wire cannot be simulated in this experiment, so it is not recommended
            found.append(advice_of(key, candidates.names, now, deviations(information + slope.T @ slope)))
    worth = [item for item in found if item.identifies or item.narrows]
    return tuple(sorted(worth, key=lambda item: (-len(item.identifies), -item.gain))[:MAX_ADVICE])


def advice_of(key: str, names: tuple[str, ...], before: FloatArray, after: FloatArray) -> ExperimentAdvice:
    """Return the value of an experiment, from the deviations in units of the prior's before and after it, (n,)."""
    text = texts()["experiments"][key]
    unknown = before > IDENTIFIABLE_FRACTION
    identifies = unknown & (after <= IDENTIFIABLE_FRACTION)
    narrows = unknown & ~identifies & (after <= 0.5 * before)
    # The parameter that would be identified best comes first.
    order = np.argsort(after)
    identified, halved = (tuple(names[place] for place in order if which[place]) for which in (identifies, narrows))
    return ExperimentAdvice(text["title"], text["text"], identified, halved, float(np.sum(np.log(before / after))))


def all_parameters(calibration: Calibration) -> tuple[CandidateParameters, FloatArray, FloatArray]:
    """Return all parameters with a prior, the fitted wire's coordinates, (n,), and the information on them, (n, n).

    For parameters on which the recordings do not depend, it is that of the prior alone.
    """
    groups = {"alloy": calibration.alloy, "wire": calibration.wire, "bench": calibration.bench}
    candidates = CandidateParameters(calibration.inputs.priors, calibration.alloy, calibration.wire, calibration.bench)
    pairs = zip(candidates.names, candidates.priors, strict=True)
    numbers = np.array([groups[prior.group][name] for name, prior in pairs])
    places = [candidates.names.index(name) for name in calibration.problem.candidates.names]
    observed = calibration.search_result.jacobian[: -len(places)]
    information = np.eye(len(candidates))
    information[np.ix_(places, places)] += observed.T @ observed / calibration.excess_variance
    return candidates, np.clip(candidates.coordinates(numbers), candidates.low, candidates.high), information


def deviations(information: FloatArray) -> FloatArray:
    """Return standard deviations in units of the prior's, (n,), from information, (n, n)."""
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information))))


def slope_of(
    observation: Observation, candidates: CandidateParameters, coordinates: FloatArray, pool: ThreadPoolExecutor
) -> FloatArray:
    """Return the derivative of an experiment's normalised residuals by all parameters, (m, n)."""
    parallel = ParallelProblem(PosteriorProblem(candidates, [observation]), pool)
    here = parallel.residuals(coordinates)
    if here is None:
        raise MusclewireError("the fitted wire cannot be simulated in this experiment")
    return jacobian(parallel, coordinates, here, STEP, central=True)[: -len(candidates)]


def proposed(calibration: Calibration) -> Iterator[tuple[str, Observation]]:
    """Yield the experiments that would add information, by key of the data file, simulated with the fitted wire."""
    values, observations = calibration.values, calibration.problem.observations
    driven = [item for item in observations if isinstance(item, DrivenObservation)]
    bench = {**values.bench, **(driven[0].bench if driven else {})}
    highest_v = max((item.highest_drive_v for item in driven), default=values.wire["drive_amplitude_v"])
    measured = {channel.name for item in driven for channel in item.channels}
    usual = tuple(sorted(measured)) or ("resistance", "strain")

    def loop(
        pretension: float = 1.0, drive: float = 1.0, channels: Sequence[str] = usual, step: bool = False
    ) -> Observation:
        period_s = FAST_SAMPLE_S if step else SAMPLE_S
        drive_v = (fast_step if step else slow_sine)(drive * highest_v)
        around = {**bench, "pretension_n": pretension * bench["pretension_n"], "sample_period_s": period_s}
        return as_measured(lambda raw: DrivenObservation("", drive_v, period_s, around, None, raw), channels, values)

    if driven:
        yield "half_pretension", loop(pretension=LOW_FACTOR)
        if bears_twice(calibration, bench):
            yield "twice_pretension", loop(pretension=HIGH_FACTOR)
        yield "minor_loop", loop(drive=MINOR_FACTOR)
        yield "fast_step", loop(step=True)
        if "temperature" not in measured:
            yield "temperature", loop(channels=("temperature",))
        if "force" not in measured and bench["spring_stiffness_n_per_m"] > 0.0:
            yield "load_cell", loop(channels=("force",))
        if "strain" not in measured:
            yield "displacement", loop(channels=("strain",))
    else:
        yield "resistance", loop()
    if not any(isinstance(item, IsobaricObservation) for item in observations):
        yield "isobars", isobars_experiment(values)
    if not any(isinstance(item, CoolingObservation) for item in observations):
        yield "cooling_curve", cooling_experiment(values, bench)


def bears_twice(calibration: Calibration, bench: Mapping[str, float]) -> bool:
    """Return whether the wire bears twice its pretension: by its largest force, and cold by its vendor's stress."""
    values, pretension_n = calibration.values, HIGH_FACTOR * bench["pretension_n"]
    leg_m = bench["wire_length_m"] / bench["legs"]
    spring_n = bench["spring_stiffness_n_per_m"] * values.alloy["strain_saturated"] * leg_m
    cold = ReachedConditions(largest_stress_pa=pretension_n / section_m2(values.wire["diameter_m"], bench["legs"]))
    vendors = ValidityLimits(working_stress_pa=validity_of(calibration.alloy).working_stress_pa)
    return pretension_n + spring_n <= values.wire["maximum_force_n"] and not beyond_validity(vendors, cold)


def slow_sine(highest_v: float) -> FloatArray:
    """Return one period of a slow sine from the sense voltage to the highest voltage [V], (n,)."""
    phase = np.linspace(0.0, 2.0 * np.pi, int(PERIOD_S / SAMPLE_S))
    lowest_v = SENSE_FRACTION * highest_v
    return np.asarray(lowest_v + (highest_v - lowest_v) * 0.5 * (1.0 - np.cos(phase)))


def fast_step(highest_v: float) -> FloatArray:
    """Return the highest voltage for a second, then the sense voltage [V], (n,)."""
    time_s = np.arange(0.0, STEP_WHOLE_S, FAST_SAMPLE_S)
    return np.asarray(np.where(time_s < STEP_ON_S, highest_v, SENSE_FRACTION * highest_v))


def as_measured(
    observed: Callable[[Mapping[str, RawChannel]], Clocked], names: Sequence[str], values: WireValues
) -> Clocked:
    """Return the observation of channels that the fitted wire would show, with typical noise."""
    found, clean = {}, observed({}).columns(values)
    for name in names:
        noise = NOISE[name] * (float(np.median(clean[name])) if name == "resistance" else 1.0)
        size = clean[name].size
        found[name] = RawChannel("", clean[name], np.full(size, noise), np.ones(size, dtype=bool))
    return observed(found)


def isobars_experiment(values: WireValues) -> IsobaricObservation:
    """Return three simulated isobars of the fitted wire as an observation."""
    constants = candidate_constants(values, values.wire, values.bench)
    loops = []
    for stress in ISOBAR_STRESSES_PA:
        middle = constants.martensite_temperature_k + stress / constants.martensite_stress_rate_pa_per_k
        up = np.linspace(values.bench["ambient_temperature_k"], middle + ABOVE_TRANSFORMATION_K, ISOBAR_POINTS)
        kelvin = np.concatenate([up, up[-2::-1]])
        loops.append(IsobaricLoop(stress, kelvin, isobaric_path(constants, stress, kelvin).strain))
    return IsobaricObservation("", loops)


def cooling_experiment(values: WireValues, bench: Mapping[str, float]) -> Observation:
    """Return a simulated cooling curve of the fitted wire as an observation."""
    constants = candidate_constants(values, values.wire, bench)
    stress_pa = bench["pretension_n"] / (constants.legs * constants.area_m2)
    warmer_k = 2.0 * stress_pa / constants.martensite_stress_rate_pa_per_k
    start_k = constants.martensite_temperature_k + warmer_k + ABOVE_TRANSFORMATION_K
    samples = int(COOLING_S / COOLING_SAMPLE_S)
    return as_measured(
        lambda raw: CoolingObservation("", start_k, COOLING_SAMPLE_S, samples, bench, None, raw),
        ("temperature", "strain"),
        values,
    )
