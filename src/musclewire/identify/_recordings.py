"""What moved in a recording: strain, displacement or contraction force; and its resistance over the cold wire's."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError, argument
from musclewire.judge import JudgedRecording, resistance_reading
from musclewire.physics import ArrayReading
from musclewire.sensing import noise_level
from musclewire.signals import MAX_STRAIN, Recording, asked_once, reference_quantity

# Readings at the beginning of a recording, whose median is the cold wire's resistance.
COLD_READINGS = 9
WARM_PART = 0.05  # of its range, by which power or contraction later lies below its beginning: the wire began warm
OUTER_PERCENT = 2.0  # of the readings at either end, left out of a range so that no single one decides
NOISES = 20.0  # standard deviations of the noise: a smaller range is no motion
HEATED_TIMES = 2.0  # highest over lowest power: with less no current has heated the wire
SAME_POWER_PART = 0.5  # of a power: readings at one drive differ by less
# Where a recording and a model state by which cold resistance [ohm] all others were divided.
DIVIDED_BY = "divided_by_ohm"


def over_cold_resistance(recording: Recording) -> tuple[Recording, float]:
    """Return a recording with resistance over the cold wire's, with which it begins, and that of the cold wire [ohm].

    So a model of one wire or coil reads another of the kind. The wire's voltage and power are divided, too; a recorded
    drive is left out, as it would contradict both. Raises RecordingError for one that begins warm.
    """
    reading = resistance_reading(recording)
    rows = cold_rows(recording, reading)
    cold_ohm = float(np.median(reading.resistance_ohm[rows]))
    if warm := why_warm_at_start(recording, reading, rows):
        raise RecordingError(
            f"{recording.facts.whose} does not begin with the cold wire, by whose resistance all others are divided: "
            f"{warm}; let the wire rest before recording, cut off what was recorded before it was cold, or negate a "
            "contraction that falls while the wire heats"
        )
    columns = {name: values for name, values in recording.columns.items() if name != "drive_voltage_v"}
    for name in ("wire_voltage_v", "wire_resistance_ohm"):
        if name in columns:
            columns[name] = columns[name] / cold_ohm
    return Recording(columns, {**recording.metadata, DIVIDED_BY: cold_ohm}), cold_ohm


def cold_rows(recording: Recording, reading: ArrayReading) -> NDArray[np.intp]:
    """Return the first readings of a recording, before its drive rises or falls: some, or one alone."""
    rows = np.flatnonzero(reading.valid)[:COLD_READINGS]
    power_w = power_in(recording)
    if power_w is None:
        return rows
    changed = np.flatnonzero(np.abs(power_w[rows] - power_w[rows[0]]) > SAME_POWER_PART * power_w[rows[0]])
    return rows[: changed[0]] if changed.size else rows


def power_in(recording: Recording) -> FloatArray | None:
    """Return the electrical power [W] in a wire, (n_times,); None without a current."""
    judged = asked_once(recording, JudgedRecording)
    return judged.circuit.wire_v * judged.circuit.shunt_v / judged.circuit.shunt_ohm if judged.has_current else None


def has_power(recording: Recording) -> bool:
    """Return whether power follows from the resistance: by a voltage or a current next to it."""
    return "wire_voltage_v" in recording or "wire_current_a" in recording


def heating_power_w(
    recording: Recording, resistance_ohm: FloatArray, rows: NDArray[np.intp] | None = None
) -> FloatArray:
    """Return the power [W] at some rows, or all, by their resistance, and the voltage or else the current."""
    by_voltage = "wire_voltage_v" in recording
    values = recording["wire_voltage_v" if by_voltage else "wire_current_a"]
    squared = (values if rows is None else values[rows]) ** 2
    return squared / resistance_ohm if by_voltage else squared * resistance_ohm


def why_warm_at_start(recording: Recording, reading: ArrayReading, rows: NDArray[np.intp]) -> str:
    """Return how motion, or else power, shows that a recording begins with a warm wire; "" if it does not."""
    measured = (reference_quantity(recording, quantity) for quantity in ("strain", "displacement"))
    moved = next((one for one in measured if one is not None and np.isfinite(one[rows]).any()), None)
    power_w = power_in(recording)
    what, values = ("its power", power_w) if moved is None else ("its contraction", moved)
    if values is None:
        return ""
    there = values[reading.valid & np.isfinite(values)]
    low, high = np.percentile(there, [OUTER_PERCENT, 100.0 - OUTER_PERCENT])
    moves = high - low > NOISES * noise_level(there) if moved is not None else high > HEATED_TIMES * low
    above = (float(np.nanmedian(values[rows])) - low) / max(float(high - low), 1e-300)
    if not moves or above <= WARM_PART:
        return ""
    return f"{what} there is {100 * above:.0f} % of its range above the least that comes later"


def required_quantity(recording: Recording, quantity: str = "strain") -> FloatArray:
    """Return the quantity of :func:`reference_quantity`, which must be in the recording.

    Raises RecordingError that names the column if the recording lacks the instrument, or for a strain that no wire has,
    and CallerError for an unknown quantity.
    """
    found = measured_quantity(recording, quantity)
    if found is None:
        raise RecordingError(why_no_reference(recording, quantity))
    return found


def measured_quantity(recording: Recording, quantity: str) -> FloatArray | None:
    """Return what :func:`reference_quantity` does. Raises RecordingError for a strain that no wire has."""
    found = reference_quantity(recording, quantity)
    if found is None or quantity != "strain" or not (beyond := np.abs(found) > MAX_STRAIN).any():
        return found
    cause = "reference_strain" if "reference_strain" in recording else "displacement_m or the length of the wire"
    raise RecordingError(
        f"{int(beyond.sum())} of {found.size} rows, the first at {recording['time_s'][beyond.argmax()]:.4g} s, are at "
        f"a strain of up to {100 * np.abs(found).max():.3g} %, and no wire comes back from {100 * MAX_STRAIN:g} %: "
        f"correct {cause}, or a unit, or take off what it reads cold ("
        + argument("zero", True)
        + "), or name what was measured ("
        + argument("quantity", "displacement")
        + ")"
    )


def why_no_reference(recording: Recording, quantity: str) -> str:
    """Return why a recording gives no strain, displacement or force, with what is missing; "" if it gives it."""
    if reference_quantity(recording, quantity) is not None:
        return ""
    if quantity == "strain" and "displacement_m" in recording:
        return "displacement_m gives strain only with the wire's length: give " + argument(
            "metadata", {"leg_length_m": None}
        )
    needed = {
        "strain": "reference_strain or displacement_m",
        "displacement": "endpoint_displacement_m or displacement_m",
        "force": "force_n",
    }
    return (
        f"this recording has no {quantity}: it needs the column {needed[quantity]}; it has {', '.join(recording.names)}"
    )


def without_loop(error: RecordingError, recording: Recording) -> RecordingError:
    """Return the error of a recording without a loop: another message for a wire held at both ends."""
    strain, force = (reference_quantity(recording, quantity) for quantity in ("strain", "force"))
    if "blocked" not in recording.facts.load or strain is None or force is None:
        return error
    return RecordingError(
        f"no loop: the part 'blocked' holds the wire, so that its strain moves by {100 * np.ptp(strain):.2g} % while "
        f"its force rises by {np.ptp(force):.3g} N, and its resistance does not fall; the recording serves for the "
        "force and its limit, and there is nothing to fit"
    )
