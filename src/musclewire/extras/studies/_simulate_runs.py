"""The kind of run ``simulate``: a supply switched on for a time and off again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Annotated

import numpy as np
from pydantic import Field

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.experiment import drive_wire
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
from musclewire.identify import required_quantity
from musclewire.judge import resistance_reading
from musclewire.signals import Recording, measured_in

# Of its largest contraction:
CONTRACTED = 0.9  # from here on a wire counts as contracted
RELAXED = 0.1  # up to here it counts as relaxed
NUMBERS = {
    "stroke": Quantity("1", "largest strain of the run"),
    "displacement_max_m": Quantity("m", "largest displacement of the run"),
    "force_max_n": Quantity("N", "largest force of the run"),
    "contracted_after_s": Quantity("s", "time from switching on to 90 % of the largest strain"),
    "relaxed_after_s": Quantity("s", "time from switching off to 10 % of the largest strain, NaN if not reached"),
    "current_max_a": Quantity("A", "largest current"),
    "energy_j": Quantity("J", "electrical energy in the wire"),
    "resistance_min_ohm": Quantity("ohm", "least resistance of the run"),
    "resistance_max_ohm": Quantity("ohm", "largest resistance of the run"),
    "temperature_max_k": Quantity("K", "highest temperature of the wire"),
}
SERIES = {
    "strain": Quantity("1", "strain, contraction positive", True),
    "force_n": Quantity("N", "force", True),
    "wire_resistance_ohm": Quantity("ohm", "resistance of the wire (Eq. 1)", True),
    "wire_temperature_k": Quantity("K", "temperature of the wire", True),
}
Volts = Annotated[float, measured_in("V"), Field(gt=0.0, allow_inf_nan=False)]
Seconds = Annotated[float, measured_in("s"), Field(gt=0.0, le=86400.0)]


class SimulateOptions(KindOptions):
    """Keys of ``[run]`` with ``kind = "simulate"``."""

    # "rig": through the rig's instruments and its protection; "ideal" without them is much faster.
    readings: Readings = "ideal"
    supply: Volts  # not above the wire's maximum
    off_after: Seconds = 1.0  # until switching off; the first sample is taken before switching on
    duration: Seconds = 10.0  # of the whole run


def quantities(options: SimulateOptions) -> Mapping[str, Quantity]:  # noqa: ARG001  the same for all options
    """Return what a drive yields."""
    return {**NUMBERS, **SERIES}


def evaluate(runs: StudyRuns[SimulateOptions]) -> Sequence[Outcome]:
    """Return contraction, heat and times of each run."""
    return each(partial(outcome_of, runs), runs.runs)


def outcome_of(runs: StudyRuns[SimulateOptions], run: StudyRun[SimulateOptions]) -> Outcome:
    """Return what a run yields, by ideal readings or through the rig's instruments."""
    options = run.options
    if options.readings == "ideal":
        wire = runs.wire(run)
        found = ideal_run(wire, drive_v(options, wire))
        numbers = drive_numbers(found.recording, found.temperature_k, options.off_after)
        return {**numbers, **runs.overheating(wire, float(found.temperature_k.max()))}
    with runs.open(run) as rig, noted_overheating(rig):
        recording = drive_wire(rig, supply_v=options.supply, on_s=options.off_after, duration_s=options.duration)
    return drive_numbers(recording, recording["wire_temperature_k"], options.off_after)


def drive_v(options: SimulateOptions, wire: VariedWire) -> FloatArray:
    """Return the drive of a run [V], (n_samples,): a sample at the sense voltage, the supply, the sense voltage."""
    sense_v, sample_s = wire.spool.bench["sense_voltage_v"], wire.spool.bench["sample_period_s"]
    if not (sense_v < options.supply and options.off_after <= options.duration):
        raise CallerError(
            f"supply {options.supply:g} V must be above the sense voltage of {sense_v:g} V, and off_after "
            f"{options.off_after:g} s not above the duration of {options.duration:g} s"
        )
    begins_s = np.array([round(sample * sample_s, 9) for sample in range(round(options.duration / sample_s))])
    is_on = (begins_s > 0.0) & (begins_s < sample_s + options.off_after - 1e-9)
    return np.where(is_on, options.supply, sense_v)


def drive_numbers(recording: Recording, temperature_k: FloatArray, on_s: float) -> dict[str, float | FloatArray]:
    """Return the quantities of a drive, of which the caller keeps those it names."""
    time_s, strain = recording["time_s"], required_quantity(recording, "strain")
    resistance = resistance_reading(recording).resistance_ohm
    current_a = recording["shunt_voltage_v"] / recording.facts.shunt_resistance_ohm
    sample_s = float(time_s[0])
    largest = float(strain.max())
    relaxed = (time_s >= sample_s + on_s) & (strain <= RELAXED * largest)
    return {
        "stroke": largest,
        "displacement_max_m": float(required_quantity(recording, "displacement").max()),
        "force_max_n": float(recording["force_n"].max()),
        "contracted_after_s": float(time_s[np.argmax(strain >= CONTRACTED * largest)] - sample_s),
        "relaxed_after_s": float(time_s[np.argmax(relaxed)] - sample_s - on_s) if relaxed.any() else np.nan,
        "current_max_a": float(current_a.max()),
        "energy_j": float((recording["wire_voltage_v"] * current_a).sum() * sample_s),
        "resistance_min_ohm": float(resistance.min()),
        "resistance_max_ohm": float(resistance.max()),
        "temperature_max_k": float(temperature_k.max()),
        "strain": strain,
        "force_n": recording["force_n"],
        "wire_resistance_ohm": resistance,
        "wire_temperature_k": temperature_k,
    }


SIMULATE = RunKind(SimulateOptions, quantities, evaluate, runs_per_chunk=500)
