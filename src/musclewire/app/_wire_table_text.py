"""How the table of all wires reads: as text, and as keys for JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from musclewire.app._wire_text import MARKS, ZERO_DEGC_K

if TYPE_CHECKING:
    from musclewire.identify import WireRow

__all__ = ["table_json", "table_text"]

HEAD = (
    "                  |        | current [mA]                        | at 1 s         | slow sine [V]    | shunt",
    "wire              | R cold | 1 s     catalogue  holds  for long  | supply   power | sense  amplitude |   ohm  "
    "mW    buy",
)


def table_json(rows: Sequence[WireRow], length_m: float, stress_pa: float, ambient_k: float) -> dict[str, Any]:
    """Return the table: a row for each wire, in order; SI."""
    return {
        "length_m": length_m,
        "stress_pa": stress_pa,
        "ambient_temperature_degc": ambient_k - ZERO_DEGC_K,
        "simulated": True,
        "rows": [row_json(row) for row in rows],
    }


def row_json(row: WireRow) -> dict[str, Any]:
    """Return one wire of the table."""
    plain = row._asdict()
    shunt, cell = plain.pop("shunt"), plain.pop("catalogue_current")
    return {
        **plain,
        "catalogue_current_a": 1e-3 * cell.value,
        "catalogue_current_status": cell.status,
        "shunt_resistance_ohm": shunt.resistance_ohm,
        "shunt_power_w": shunt.power_w,
        "shunt_rating_w": shunt.rating_w,
    }


def table_text(rows: Sequence[WireRow], length_m: float, stress_pa: float, ambient_k: float) -> str:
    """Return the table as lines."""
    air = f"still air of {ambient_k - ZERO_DEGC_K:g} C"
    lines = [
        f"{1e3 * length_m:g} mm of wire, {stress_pa / 1e6:.0f} MPa, {air}; simulated",
        "",
        *HEAD,
        *(row_text(row) for row in rows),
        "",
        "1 s: contracts by 90 % in a second; then lower it to what holds. For long: settles at 150 C, a working limit",
        "(assumed). Supply across wire and shunt at the one-second current, power in the wire; the switch or amplifier",
        "comes on top. ? the catalogue's number is not corroborated. Shunt: power at that current, and what to buy.",
    ]
    return "\n".join(lines)


def row_text(row: WireRow) -> str:
    """Return one wire as a line."""
    printed = f"{row.catalogue_current.value:g}{MARKS[row.catalogue_current.status]}"
    return (
        f"{row.wire:<17} | {row.cold_resistance_ohm:6.4g} | {1e3 * row.one_second_current_a:<7.0f} {printed:<10} "
        f"{1e3 * row.holding_current_a:<6.0f} {1e3 * row.lasting_current_a:<8.0f}  | "
        f"{row.supply_v:5.2f} V {row.power_w:5.3g} W | "
        f"{row.sense_voltage_v:<6.3f} {row.amplitude_v:<9.2f} | {row.shunt.resistance_ohm:5g}  "
        f"{1e3 * row.shunt.power_w:<5.0f} {row.shunt.rating_w:g} W"
    )
