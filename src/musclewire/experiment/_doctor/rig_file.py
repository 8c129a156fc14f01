"""Offsets and gains of the two input channels, and a rig file with them: all its other lines stay as they were."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from musclewire.errors import CallerError
from musclewire.experiment._doctor.evidence import VoltageLevel
from musclewire.rigs import read_rig_file
from musclewire.signals import parse_quantity, write_whole
from musclewire.small_files import read_small, read_toml, toml_of

# A meter and a channel that differ by more do not measure the same voltage.
MAX_GAIN_ERROR = 0.2


class ChannelCalibration(NamedTuple):
    """Error of one channel: true = (reading - offset_v) * gain. ``gain`` is None without a meter's reading."""

    channel: str
    offset_v: float
    gain: float | None


def calibrations(
    zero: VoltageLevel | None, at_sense: VoltageLevel | None, meter_wire_v: float | None, meter_shunt_v: float | None
) -> tuple[ChannelCalibration, ...]:
    """Return the calibration of both channels: offsets at 0 V, gains by a meter that was read at the sense voltage.

    Empty without readings at 0 V. Raises CallerError if a meter's reading cannot belong to the channel.
    """
    if zero is None:
        return ()
    found = []
    for channel, meter_v in (("wire", meter_wire_v), ("shunt", meter_shunt_v)):
        offset = float(getattr(zero, f"{channel}_voltage_v").mean())
        found.append(ChannelCalibration(channel, offset, gain_of(channel, offset, at_sense, meter_v)))
    return tuple(found)


def gain_of(channel: str, offset_v: float, at_sense: VoltageLevel | None, meter_v: float | None) -> float | None:
    """Return the factor by which a channel's reading agrees with a meter's."""
    if meter_v is None:
        return None
    if at_sense is None:
        raise CallerError(
            f"the sense voltage was not applied, so --meter-{channel} cannot be used: correct the failed checks first"
        )
    reading = float(getattr(at_sense, f"{channel}_voltage_v").mean()) - offset_v
    gain = meter_v / reading if reading else 0.0
    if not abs(gain - 1.0) <= MAX_GAIN_ERROR:
        raise CallerError(
            f"--meter-{channel} {meter_v:g} V and a reading of {reading:g} V: over {MAX_GAIN_ERROR:.0%} apart, so "
            "they do not measure the same voltage: check where the meter was"
        )
    return gain


# Kinds of rigs whose files hold the calibration of their channels: volts on the circuit = gain * terminal + offset.
CALIBRATED_KINDS = ("nidaq",)
SECTIONS = {"wire": "inputs.wire_voltage", "shunt": "inputs.shunt_voltage"}


def require_calibrated_kind(rig: str) -> None:
    """Raise CallerError, before anything is driven, if there is no rig file that holds a calibration."""
    if not Path(rig).is_file():
        raise CallerError(f"--write needs a rig file of your own, and '{rig}' is none: name the rig by its path")
    kind = str(read_toml(Path(rig), "rig file").get("kind", "simulated"))
    if kind not in CALIBRATED_KINDS:
        known = ", ".join(CALIBRATED_KINDS)
        raise CallerError(f"--write: a rig file of kind '{kind}' holds no calibration of its channels; {known} does")


def write_calibration(path: Path, found: Sequence[ChannelCalibration]) -> Path:
    """Write a calibration into a rig file, whole or not at all. Raises CallerError if that cannot be done."""
    text = with_calibration(read_small(path, "rig file"), found, str(path))

    def checked(temporary: Path) -> None:
        temporary.write_text(text, encoding="utf-8")
        read_rig_file(temporary)

    write_whole(path, checked)
    return path


def with_calibration(text: str, found: Sequence[ChannelCalibration], where: str) -> str:
    """Return a rig file's text with gain and offset of its channels corrected by the calibration that was found.

    Readings were taken with the file's own gain g and offset o; true = (reading - offset) * gain, so the new ones are
    gain * g and gain * (o - offset). Raises CallerError if a channel has no table of its own.
    """
    for one in found:
        section = SECTIONS[one.channel]
        now = section_of(toml_of(text, f"rig file {where}"), section, where)
        gain = 1.0 if one.gain is None else one.gain
        old_gain, old_offset_v = number(now, "gain", 1.0), number(now, "offset", 0.0)
        text = with_key(text, section, "offset", gain * (old_offset_v - one.offset_v), where)
        if one.gain is not None:
            text = with_key(text, section, "gain", gain * old_gain, where)
    return text


def section_of(tables: Mapping[str, Any], section: str, where: str) -> Mapping[str, Any]:
    """Return a table by its dotted name."""
    found: Any = tables
    for name in section.split("."):
        found = found.get(name) if isinstance(found, Mapping) else None
    if not isinstance(found, Mapping):
        raise CallerError(f"rig file {where}: there is no [{section}] to write a calibration into: add it")
    return found


def number(table: Mapping[str, Any], key: str, default: float) -> float:
    """Return a number of a table, also one written as text with a unit."""
    value = table.get(key, default)
    return parse_quantity(value, "V") if isinstance(value, str) else float(value)


def with_key(text: str, section: str, key: str, value: float, where: str) -> str:
    """Return a text in which a section's key has a value: its line replaced, or a line added under the header."""
    lines = text.splitlines()
    header = re.compile(rf"^\s*\[\s*{re.escape(section)}\s*\]")
    start = next((index for index, line in enumerate(lines) if header.match(line)), None)
    if start is None:
        raise CallerError(f"rig file {where}: write [{section}] as a table of its own, then --write can change it")
    following = (index for index in range(start + 1, len(lines)) if re.match(r"^\s*\[", lines[index]))
    end = next(following, len(lines))
    written = f"{key} = {value:.9g}"
    place = next((index for index in range(start + 1, end) if re.match(rf"^\s*{key}\s*=", lines[index])), None)
    if place is None:
        lines.insert(start + 1, written)
    else:
        comment = re.search(r"\s+#[^\"]*$", lines[place])
        lines[place] = written + (comment[0] if comment else "")
    return "\n".join(lines) + "\n"
