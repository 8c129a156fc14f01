"""The kind of run ``characterize``: the slow sine, the gaps of its loop, and on request a model fitted to it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache, partial
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.experiment import characterize
from musclewire.extras.studies._ideal_runs import Readings, ideal_run
from musclewire.extras.studies._run_kind import (
    KindOptions,
    Outcome,
    Quantity,
    RunKind,
    StudyRun,
    StudyRuns,
    each,
    noted_overheating,
)
from musclewire.extras.studies._varied_rig import VariedWire
from musclewire.identify import fit, force_is_level, gap_in, required_quantity
from musclewire.judge import resistance_reading
from musclewire.sensing import find_segments, hysteresis_gap
from musclewire.signals import Recording, measured_in

NUMBERS = {
    "strain_gap": Quantity("1", "gap of strain between heating and cooling (Eq. 2)"),
    "force_gap": Quantity("1", "gap of force, NaN if it does not rise with the contraction"),
    "displacement_gap": Quantity("1", "gap of displacement (Eq. 9)"),
    "resistance_min_ohm": Quantity("ohm", "resistance at C, the least of the loop"),
    "resistance_max_ohm": Quantity("ohm", "resistance at B, the largest of the loop"),
    "stroke": Quantity("1", "largest strain of the run"),
    "displacement_max_m": Quantity("m", "largest displacement of the run"),
    "force_max_n": Quantity("N", "largest force of the run"),
}
HOTTEST = {"temperature_max_k": Quantity("K", "highest temperature of the wire")}
FITTED = {
    "fit_rmse": Quantity("1", "root mean square error of the fitted model, in strain"),
    "fit_order": Quantity("1", "order of its polynomials"),
    "fit_warnings": Quantity("1", "number of doubts about the fit"),
}
SERIES = {
    "drive_voltage_v": Quantity("V", "drive voltage", True),
    "wire_resistance_ohm": Quantity("ohm", "resistance of the wire (Eq. 1)", True),
    "strain": Quantity("1", "strain, contraction positive", True),
    "force_n": Quantity("N", "force", True),
}


class CharacterizeOptions(KindOptions):
    """Keys of ``[run]`` with ``kind = "characterize"``."""

    # "rig": through the rig's instruments and its protection; "ideal" without them is much faster.
    readings: Readings = "ideal"
    # Of the slow sine; by default the wire's own.
    amplitude: Annotated[float, measured_in("V"), Field(gt=0.0, allow_inf_nan=False)] | None = None
    period: Annotated[float, measured_in("s"), Field(ge=1.0, le=86400.0)] = 90.0
    cycles: int = Field(default=2, ge=1)  # the last is analysed
    fit: bool = False  # whether a model is fitted to the loop
    order: int | Literal["auto"] = 6  # of its polynomials


def quantities(options: CharacterizeOptions) -> Mapping[str, Quantity]:
    """Return what a slow sine yields."""
    ideal = options.readings == "ideal"
    return {**NUMBERS, **(HOTTEST if ideal else {}), **(FITTED if options.fit else {}), **SERIES}


def evaluate(runs: StudyRuns[CharacterizeOptions]) -> Sequence[Outcome]:
    """Return gaps and extremes of the loop of each run."""
    return each(partial(outcome_of, runs), runs.runs)


def outcome_of(runs: StudyRuns[CharacterizeOptions], run: StudyRun[CharacterizeOptions]) -> Outcome:
    """Return what a run yields, by ideal readings or through the rig's instruments."""
    options = run.options
    if options.readings == "ideal":
        wire = runs.wire(run)
        found = ideal_run(wire, drive_v(options, wire))
        hottest_k = float(found.temperature_k.max())
        hottest = {"temperature_max_k": hottest_k} if "temperature_max_k" in runs.keep else {}
        numbers = loop_numbers(found.recording, options, runs.keep)
        return {**numbers, **hottest, **runs.overheating(wire, hottest_k)}
    with runs.open(run) as rig, noted_overheating(rig):
        amplitude_v, period_s, cycles = options.amplitude, options.period, options.cycles
        recording = characterize(rig, amplitude_v=amplitude_v, period_s=period_s, cycles=cycles, minor_loop=False)
    return loop_numbers(recording, options, runs.keep)


def drive_v(options: CharacterizeOptions, wire: VariedWire) -> FloatArray:
    """Return the slow sine of a run [V], (n_samples,), with the numbers of ``experiment.slow_sine``."""
    amplitude_v = wire.spool.wire["drive_amplitude_v"] if options.amplitude is None else options.amplitude
    sense_v, sample_s = wire.spool.bench["sense_voltage_v"], wire.spool.bench["sample_period_s"]
    if not sense_v < amplitude_v:
        raise CallerError(f"the amplitude of {amplitude_v:g} V must be above the sense voltage of {sense_v:g} V")
    samples = round(options.cycles * options.period / sample_s)
    return sense_v + (amplitude_v - sense_v) * swing(options.period, sample_s, samples)


@lru_cache(maxsize=8)
def swing(period_s: float, sample_period_s: float, samples: int) -> FloatArray:
    """Return a raised cosine from 0 to 1 and back at the beginning of each sample, (n_samples,)."""
    times_s = [round(sample * sample_period_s, 9) for sample in range(samples)]
    return np.array([0.5 * (1.0 - math.cos(2.0 * math.pi * time_s / period_s)) for time_s in times_s])


def loop_numbers(
    recording: Recording, options: CharacterizeOptions, keep: frozenset[str]
) -> dict[str, float | FloatArray]:
    """Return those quantities of a loop that are kept; ``loop_gaps`` and ``fit`` would find the same numbers."""
    reading = resistance_reading(recording)
    strain = required_quantity(recording, "strain")
    found: dict[str, float | FloatArray] = {
        "stroke": float(strain.max()),
        "displacement_max_m": float(required_quantity(recording, "displacement").max()),
        "force_max_n": float(recording["force_n"].max()),
        "drive_voltage_v": recording["drive_voltage_v"],
        "wire_resistance_ohm": reading.resistance_ohm,
        "strain": strain,
        "force_n": recording["force_n"],
    }
    if keep & {"strain_gap", "force_gap", "displacement_gap", "resistance_min_ohm", "resistance_max_ohm"}:
        segments = find_segments(reading.resistance_ohm, strain, reading.valid, "last")
        found["resistance_min_ohm"] = segments.resistance_min_ohm
        found["resistance_max_ohm"] = segments.resistance_max_ohm
        if "strain_gap" in keep:
            found["strain_gap"] = hysteresis_gap(segments.heating, segments.cooling)
        if "displacement_gap" in keep:
            found["displacement_gap"] = gap_in(segments, reading, required_quantity(recording, "displacement"))
        if "force_gap" in keep:
            force = required_quantity(recording, "force")
            level = force_is_level(force, strain, segments)
            found["force_gap"] = math.nan if level else gap_in(segments, reading, force)
    if keep & set(FITTED):
        model = fit(recording, order=options.order)
        found |= {
            "fit_rmse": model.rmse_average,
            "fit_order": float(model.order),
            "fit_warnings": float(len(model.warnings)),
        }
    return {name: found[name] for name in keep if name in found}


CHARACTERIZE = RunKind(CharacterizeOptions, quantities, evaluate, runs_per_chunk=200)
