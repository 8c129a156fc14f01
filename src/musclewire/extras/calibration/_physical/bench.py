"""The bench of a recording: the numbers known of it, and those that are assumed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from musclewire.errors import CallerError, RecordingError, argument, nearest_hint
from musclewire.parameters import Bench, Parameter, Wire, checked, load_bench
from musclewire.signals import Recording, parse_quantity

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo


def unit_of(field: FieldInfo) -> str:
    """Return the unit that a field of a parameter group declares."""
    return str(field.json_schema_extra["unit"]) if isinstance(field.json_schema_extra, dict) else ""


# The numbers of its bench that a recording may state.
BENCH_KEYS = (
    "wire_length_m",
    "legs",
    "pretension_n",
    "spring_stiffness_n_per_m",
    "shunt_resistance_ohm",
    "lead_resistance_ohm",
    "ambient_temperature_k",
    "sample_period_s",
    "start_temperature_k",
)
# Numbers that a user may state in addition to those of a bench: name and unit.
OTHER_SETTINGS = {"diameter_m": "m", "start_temperature_k": "K"}
SETTABLE: dict[str, str] = {
    **{key: unit_of(field) for key, field in Bench.model_fields.items() if key not in ("name", "description")},
    **OTHER_SETTINGS,
}
# Diameters that differ by less than this fraction count as equal.
SAME_DIAMETER = 0.01
# A load cell that begins below this fraction of its range in the recording was tared.
TARED_FRACTION = 0.02


def checked_settings(given: Mapping[str, float | str]) -> dict[str, float]:
    """Return a user's settings in SI. Raises CallerError for unknown names, wrong units and impossible numbers."""
    found = {}
    for name, setting in given.items():
        if name not in SETTABLE:
            raise CallerError(f"a bench has no number '{name}'{nearest_hint(name, SETTABLE)}")
        value = in_si(name, setting) if isinstance(setting, str) else setting
        field = Bench.model_fields.get(name) or Wire.model_fields.get(name)
        if not np.isfinite(value):
            raise CallerError(f"{name} is {value}: give a finite number")
        if field is not None:
            try:
                checked(name, Parameter(value=value, unit=SETTABLE[name], kind="measured", source="the user"), field)
            except ValueError as error:
                raise CallerError(str(error)) from None
        found[name] = float(value)
    return found


def in_si(name: str, text: str) -> float:
    """Return a number with its unit in SI. Raises CallerError that names the setting."""
    try:
        return parse_quantity(text, "" if SETTABLE[name] == "1" else SETTABLE[name])
    except CallerError as error:
        raise CallerError(f"{name}: {error}") from None


def bench_of(recording: Recording, given: Mapping[str, float]) -> dict[str, float]:
    """Return the known numbers of a recording's bench: those of the user, then those of the recording.

    A stiffness that neither states is fitted to force and displacement. Raises CallerError if length or load remain
    unknown, RecordingError if two wires made the recording.
    """
    facts = recording.facts
    if facts.wires > 1.0:
        raise RecordingError(
            f"{facts.wires:g} wires made this recording ({', '.join(facts.load) or 'wires'}): record one wire on a "
            "spring, a weight or a finger by itself"
        )
    known = {key: value for key in BENCH_KEYS if (value := facts.number_or_none(key)) is not None}
    if "ambient_temperature_k" in recording:
        known["ambient_temperature_k"] = float(np.mean(recording["ambient_temperature_k"]))
    known |= {key: value for key, value in given.items() if key != "diameter_m"}
    known |= lengths(recording, known)
    missing = {"spring_stiffness_n_per_m", "pretension_n"} - known.keys()
    if missing:
        known = {**load_line(recording, missing), **known}
    return known


def lengths(recording: Recording, known: Mapping[str, float]) -> dict[str, float]:
    """Return overall length and number of legs. Raises CallerError if they are not known."""
    leg, whole, legs = recording.facts.number_or_none("leg_length_m"), known.get("wire_length_m"), known.get("legs")
    if leg is not None and legs is not None:
        return {"wire_length_m": leg * legs, "legs": legs}
    if leg is not None and whole is not None:
        return {"wire_length_m": whole, "legs": float(max(round(whole / leg), 1))}
    if leg is not None:
        raise CallerError(
            "one leg's length is known, but not how many legs there are: give "
            + argument("bench", {"legs": 1})
            + " for a straight wire, "
            + argument("bench", {"legs": 2})
            + " for a V"
        )
    if whole is None:
        raise CallerError(
            "the wire's length is not known: give "
            + argument("bench", {"wire_length_m": None})
            + ", or "
            + argument("metadata", {"leg_length_m": None})
            + " and "
            + argument("bench", {"legs": 2})
        )
    return {"wire_length_m": whole, "legs": 1.0 if legs is None else legs}


def load_line(recording: Recording, missing: set[str]) -> dict[str, float]:
    """Return stiffness and pretension by a straight line fitted to force over displacement."""
    if "force_n" not in recording or "displacement_m" not in recording:
        wanted = " and ".join(sorted(missing))
        raise CallerError(
            f"the load is not known: give {wanted} ("
            + argument("bench", {"pretension_n": "1.9 N"})
            + "; a hanging weight has no stiffness), or record force_n and displacement_m"
        )
    force = recording["force_n"]
    if "pretension_n" in missing and force[0] < TARED_FRACTION * np.ptp(force):
        raise CallerError(
            f"force_n begins at {force[0]:.3g} N: a tared load cell does not show the pretension: "
            "give " + argument("bench", {"pretension_n": "1.9 N"})
        )
    slope, start = np.polyfit(recording["displacement_m"], force, 1)
    return {"spring_stiffness_n_per_m": max(float(slope), 0.0), "pretension_n": max(float(start), 0.0)}


def assumed_of_bench(known: Mapping[str, float]) -> list[str]:
    """Return the assumptions, in words, for numbers of a bench that neither recording nor user states."""
    usual = load_bench("paper").values()
    found: list[str] = []
    if "ambient_temperature_k" not in known:
        found.append(
            f"air at {usual['ambient_temperature_k'] - 273.15:.1f} C ("
            + argument("bench", {"ambient_temperature_k": "22 degC"})
            + ")"
        )
    return found


def diameter_of(recordings: Mapping[str, Recording], given: Mapping[str, float]) -> float | None:
    """Return the diameter [m] stated by recordings or user, None if by none. Raises CallerError if wires differ."""
    if "diameter_m" in given:
        return given["diameter_m"]
    stated = {name: recording.facts.number_or_none("wire_diameter_m") for name, recording in recordings.items()}
    known = {name: value for name, value in stated.items() if value is not None}
    if not known:
        return None
    (thin, thinnest), (thick, thickest) = (pick(known.items(), key=lambda pair: pair[1]) for pick in (min, max))
    if thickest > (1.0 + SAME_DIAMETER) * thinnest:
        raise CallerError(
            f"{thin} was made on a wire of {1e6 * thinnest:.0f} um, {thick} on one of {1e6 * thickest:.0f} um: "
            "calibrate one wire at a time"
        )
    return float(thinnest)
