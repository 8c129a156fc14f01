"""The numbers of a run while it goes on: target, estimate, resistance, drive and temperature of the last sample."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from musclewire.rigs import GuardedRig

# What a column's name ends in, and how it is shown: factor, unit, digits.
SHOWN_AS = {"_strain": (100.0, "%", 2), "_m": (1e3, "mm", 3), "_n": (1.0, "N", 3)}
ZERO_CELSIUS_K = 273.15


class LiveNumbers:
    """The last row of a run, put into words a few times a second by the thread that draws it."""

    def __init__(self, rig: GuardedRig) -> None:
        """Show nothing yet."""
        self._rig = rig
        self._row: Mapping[str, float] | None = None

    def keep_row(self, row: Mapping[str, float]) -> None:
        """Keep a row of the run; the caller does not change it afterwards."""
        self._row = row

    def text(self) -> str:
        """Return the last row in words; empty before the first."""
        if self._row is None:
            return ""
        return numbers_text(self._row, self._rig.shunt_resistance_ohm, self._rig.protection.temperature_k)


def numbers_text(row: Mapping[str, float], shunt_ohm: float, temperature_k: float) -> str:
    """Return target, estimate, resistance, drive and temperature of a row, as far as it has them.

    ``temperature_k`` is what the protection expects of the wire at most; a policy's own estimate goes before it.
    """
    parts = [f"{word} {shown}" for word in ("target", "estimate") if (shown := quantity_text(row, word))]
    ohm = resistance_of(row, shunt_ohm)
    parts.append("resistance -" if ohm is None else f"resistance {ohm:.3f} ohm")
    parts.append(f"drive {row['drive_voltage_v']:.3f} V")
    kelvin = row.get("estimated_temperature_k", temperature_k)
    parts.append(f"about {kelvin - ZERO_CELSIUS_K:.0f} C" if isfinite(kelvin) else "temperature -")
    return "   ".join(parts)


def quantity_text(row: Mapping[str, float], word: str) -> str:
    """Return a row's target or estimate with its unit; empty without such a column, a dash without a value."""
    stem = {"target": "target_", "estimate": "estimated_"}[word]
    for name, value in row.items():
        ending = next((end for end in SHOWN_AS if name.endswith(end)), None)
        if ending is not None and name.startswith(stem):
            factor, unit, digits = SHOWN_AS[ending]
            usable = value is not None and isfinite(value) and (word == "target" or row.get("valid", 1.0) > 0.0)
            return f"{factor * value:.{digits}f} {unit}" if usable else "-"
    return ""


def resistance_of(row: Mapping[str, float], shunt_ohm: float) -> float | None:
    """Return the resistance of a row's wire; None without a current."""
    # Numba comes with this import, and --help and the shell's completion do without.
    from musclewire.physics import series_resistance_ohm

    wire_v, shunt_v = row.get("wire_voltage_v"), row.get("shunt_voltage_v")
    if wire_v is None or shunt_v is None or not shunt_v > 0.0:
        return None
    ohm = series_resistance_ohm(wire_v, shunt_v, shunt_ohm)
    return ohm if isfinite(ohm) else None
