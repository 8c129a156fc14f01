"""Which electrical measurements a recording offers."""

from __future__ import annotations

from enum import StrEnum

from musclewire.errors import RecordingError, argument
from musclewire.signals._recording import Recording
from musclewire.signals._unusable_readings import JudgedReadings, judge_readings


class ElectricalSource(StrEnum):
    """The columns from which the resistance of the wire can be computed."""

    SHUNT = "wire_voltage_v and shunt_voltage_v"
    CURRENT = "wire_voltage_v and wire_current_a"
    RESISTANCE = "wire_resistance_ohm"

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the columns."""
        return tuple(self.value.split(" and "))


def require_electrical(recording: Recording) -> ElectricalSource:
    """Return the measurement from which resistance follows, the rawest first: shunt, current, resistance.

    ``SHUNT`` also needs a positive metadata ``shunt_resistance_ohm``. Raises RecordingError if nothing suffices.
    """
    has_shunt = "wire_voltage_v" in recording and "shunt_voltage_v" in recording
    if has_shunt and _shunt_is_known(recording):
        return ElectricalSource.SHUNT
    if "wire_voltage_v" in recording and "wire_current_a" in recording:
        return ElectricalSource.CURRENT
    if "wire_resistance_ohm" in recording:
        return ElectricalSource.RESISTANCE
    raise RecordingError(_what_is_missing(recording, has_shunt))


def usable_readings(recording: Recording) -> JudgedReadings:
    """Return which rows of a recording give a resistance, and why others give none.

    Parameters
    ----------
    recording
        A recording from which resistance follows, as :func:`require_electrical` finds.

    Returns
    -------
    The rows in which the columns that are used are measurements.

    Raises
    ------
    RecordingError
        If no resistance follows, or two sources of one quantity contradict each other throughout.
    """
    judged = judge_readings(recording.columns, recording.metadata, require_electrical(recording).columns)
    if judged.contradiction:
        raise RecordingError(f"two columns contradict each other: {judged.contradiction}")
    return judged


def _shunt_is_known(recording: Recording) -> bool:
    value = recording.metadata.get("shunt_resistance_ohm")
    return isinstance(value, (int, float)) and not isinstance(value, bool) and 0.0 < value < float("inf")


def _what_is_missing(recording: Recording, has_shunt: bool) -> str:
    if has_shunt:
        value = recording.metadata.get("shunt_resistance_ohm")
        problem = "is missing" if value is None else f"is {value!r}"
        return (
            f"metadata shunt_resistance_ohm {problem}: shunt_voltage_v needs it, give a positive number: "
            + argument("metadata", {"shunt_resistance_ohm": None})
        )
    columns = ("wire_voltage_v", "shunt_voltage_v", "wire_current_a", "wire_resistance_ohm")
    missing = ", ".join(name for name in columns if name not in recording)
    needs = f"give {ElectricalSource.SHUNT}, or {ElectricalSource.CURRENT}, or {ElectricalSource.RESISTANCE}"
    return f"no resistance can be computed from this recording, it lacks {missing}: {needs}"
