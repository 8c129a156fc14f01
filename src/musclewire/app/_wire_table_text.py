"""How the table of all wires reads: as text, and as keys for JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from musclewire.app._output import table
from musclewire.app._wire_text import MARKS, ZERO_DEGC_K

if TYPE_CHECKING:
    from musclewire.app._answers import WireTableAnswer
    from musclewire.identify import WireRow

HEAD = ("wire", "R cold [ohm]", "1 s [mA]", "catalogue", "holds", "for long", "supply [V]", "power [W]", "sense [V]",
        "slow sine [V]", "shunt [ohm]", "[mW]", "buy [W]")  # fmt: skip


def table_answer(rows: Sequence[WireRow], length_m: float, stress_pa: float, ambient_k: float) -> WireTableAnswer:
    """Return the table: a row for each wire, in order; SI."""
    from musclewire.app._answers import WireTableAnswer

    return WireTableAnswer.read_from(
        length_m=length_m,
        stress_pa=stress_pa,
        ambient_temperature_degc=ambient_k - ZERO_DEGC_K,
        simulated=True,
        rows=[row_keys(row) for row in rows],
    )


def row_keys(row: WireRow) -> dict[str, Any]:
    """Return one wire of the table."""
    keys = row._asdict()
    shunt, cell = keys.pop("shunt"), keys.pop("catalogue_current")
    keys |= {f"shunt_{name}": value for name, value in shunt._asdict().items()}
    return {**keys, "catalogue_current_a": 1e-3 * cell.value, "catalogue_current_status": cell.status}


def table_text(rows: Sequence[WireRow], length_m: float, stress_pa: float, ambient_k: float) -> str:
    """Return the table as lines."""
    air = f"still air of {ambient_k - ZERO_DEGC_K:g} C"
    lines = [
        f"{1e3 * length_m:g} mm of wire, {stress_pa / 1e6:.0f} MPa, {air}; simulated",
        "",
        table(HEAD, map(cells, rows)),
        "",
        "1 s: contracts by 90 % in a second; then lower it to what holds. For long: settles at 150 C, a working limit",
        "(assumed). Supply across wire and shunt at the one-second current, power in the wire; the switch or amplifier",
        "comes on top. ? the catalogue's number is not corroborated. Shunt: power at that current, and what to buy.",
    ]
    return "\n".join(lines)


def cells(row: WireRow) -> tuple[str, ...]:
    """Return one wire as the cells of its row."""
    printed, shunt = row.catalogue_current, row.shunt
    currents_a = (row.holding_current_a, row.lasting_current_a)
    return (
        row.wire,
        f"{row.cold_resistance_ohm:.4g}",
        f"{1e3 * row.one_second_current_a:.0f}",
        f"{printed.value:g}{MARKS[printed.status]}",
        *(f"{1e3 * current_a:.0f}" for current_a in currents_a),
        f"{row.supply_v:.2f}",
        f"{row.power_w:.3g}",
        f"{row.sense_voltage_v:.3f}",
        f"{row.amplitude_v:.2f}",
        f"{shunt.resistance_ohm:g}",
        f"{1e3 * shunt.power_w:.0f}",
        f"{shunt.rating_w:g}",
    )
