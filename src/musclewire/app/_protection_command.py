"""The command that prints the protection table, and what one rig's limits are: protection."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app._options import Json
from musclewire.app._output import emit_json, show

if TYPE_CHECKING:
    from musclewire.controllers import ProtectionLimits, ProtectionTable

__all__ = ["protection"]

# Ends of the limits' names and the unit they stand for.
UNITS = {"_v": "V", "_a": "A", "_w": "W", "_ohm": "ohm", "_k": "K", "_j_per_k": "J/K", "_w_per_k": "W/K"}


def protection(
    rig: Annotated[
        str | None, typer.Argument(metavar="[RIG]", help="Also open this rig and show its limits; nothing is driven.")
    ] = None,
    json: Json = False,
) -> None:
    """Show the protection table: monitored conditions of a heated wire and the responses; with a rig, its limits."""
    from musclewire.controllers import protection_table

    table = protection_table()
    limits = None if rig is None else limits_of_rig(rig)
    if json:
        emit_json(document(table, limits))
        return
    show(table_text(table))
    if limits is not None:
        show(f"\nLimits of {rig}:\n{limits_text(limits)}")


def limits_of_rig(rig: str) -> ProtectionLimits:
    """Return the limits of a rig, which is opened and closed again with its output off."""
    from musclewire.rigs import open_rig

    with open_rig(rig) as opened:
        return opened.protection_limits


def document(table: ProtectionTable, limits: ProtectionLimits | None) -> dict[str, Any]:
    """Return the table, and the limits if there are some, as one JSON document."""
    answer: dict[str, Any] = table.model_dump(mode="json")
    plural = {"state": "states", "effect": "effects", "signal": "signals", "event": "events"}
    answer = {plural.get(key, key): value for key, value in answer.items()}
    if limits is not None:
        finite = {name: value for name, value in limits._asdict().items() if value < float("inf")}
        answer["limits"] = {**finite, "readings_noisy": bool(limits.readings_noisy)}
    return answer


def table_text(table: ProtectionTable) -> str:
    """Return states, transitions and events for a terminal."""
    names = list(table.signal[0].then)
    lines = ["States"]
    lines += [f"  {row.name:8} {row.output}: {row.meaning}" for row in table.state]
    lines += ["", f"{'Signals, and the state that follows':36}" + "".join(f"{f'in {name}':13}" for name in names)]
    for signal in table.signal:
        follow = (signal.then[name] for name in names)
        lines.append(
            (
                f"  {signal.name:34}" + "".join(f"{'-' if one.effect == 'nothing' else one.to:13}" for one in follow)
            ).rstrip()
        )
    lines += [
        "",
        f"What is missing: hold at once, sense voltage after {table.sense_after_s:g} s, off after "
        f"{table.trip_after_s:g} s. A reading is the mean over {1e3 * table.reading_period_s:g} ms at least.",
        "",
        f"{'Events':31}{'then':9}{'lasting':>9}  when",
    ]
    for row in table.event:
        lasting = f"{row.lasts_s:g} s" if row.lasts_s else "-"
        lines.append(f"  {row.number:>2} {row.name:26}{row.action:9}{lasting:>9}  {row.when}")
    return "\n".join(lines)


def limits_text(limits: ProtectionLimits) -> str:
    """Return the limits of a rig for a terminal."""
    return "\n".join(f"  {name:24} {shown_limit(name, value)}" for name, value in limits._asdict().items())


def shown_limit(name: str, value: float) -> str:
    """Return one limit with its unit; temperatures also in degrees Celsius."""
    if name == "readings_noisy":
        return "yes" if value else "no"
    unit = next((UNITS[end] for end in sorted(UNITS, key=len, reverse=True) if name.endswith(end)), "")
    degrees = f" ({value - 273.15:.0f} C)" if unit == "K" else ""
    return f"{value:.4g} {unit}{degrees}".rstrip()
