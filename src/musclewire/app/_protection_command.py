"""The command that prints the protection table, and what one rig's limits are: protection."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app._output import Result, table

if TYPE_CHECKING:
    from musclewire.controllers import ProtectionTable

# Ends of the limits' names and the unit they stand for.
UNITS = {"_v": "V", "_a": "A", "_w": "W", "_ohm": "ohm", "_k": "K", "_j_per_k": "J/K", "_w_per_k": "W/K"}


def protection(
    rig: Annotated[
        str | None, typer.Argument(metavar="[RIG]", help="Also open this rig and show its limits; nothing is driven.")
    ] = None,
) -> Result:
    """Show the protection table: monitored conditions of a heated wire and the responses; with a rig, its limits."""
    from musclewire.app._answers import ProtectionAnswer
    from musclewire.controllers import protection_table

    rows = protection_table()
    limits, text = None, table_text(rows)
    if rig is not None:
        from musclewire.rigs import open_rig

        with open_rig(rig) as opened:
            limits = opened.protection_limits
        shown = ((name, shown_limit(name, value)) for name, value in limits._asdict().items())
        text += f"\n\nLimits of {rig}:\n" + table(["", ""], shown, left=(0, 1))
    return Result(ProtectionAnswer(**rows.model_dump(), limits=limits), text)


def table_text(rows: ProtectionTable) -> str:
    """Return states, transitions and events for people."""
    states = list(rows.signal[0].then)
    follow = (
        (signal.name, *("-" if then.effect == "nothing" else then.to for then in signal.then.values()))
        for signal in rows.signal
    )
    events = (
        (row.number, row.name, row.action, f"{row.lasts_s:g} s" if row.lasts_s else "-", row.when) for row in rows.event
    )
    return "\n".join(
        [
            table(
                ["state", "drive", "meaning"],
                ((row.name, row.output, row.meaning) for row in rows.state),
                left=range(3),
            ),
            "",
            "The state that follows a signal:",
            table(["signal", *(f"in {name}" for name in states)], follow, left=range(9)),
            "",
            f"What is missing: hold at once, sense voltage after {rows.sense_after_s:g} s, off after "
            f"{rows.trip_after_s:g} s. A reading is the mean over {1e3 * rows.reading_period_s:g} ms at least.",
            "",
            table(["", "event", "then", "lasting", "when"], events, left=(1, 2, 4)),
        ]
    )


def shown_limit(name: str, value: float) -> str:
    """Return one limit with its unit; temperatures also in degrees Celsius."""
    if name == "readings_noisy":
        return "yes" if value else "no"
    unit = next((UNITS[end] for end in sorted(UNITS, key=len, reverse=True) if name.endswith(end)), "")
    degrees = f" ({value - 273.15:.0f} C)" if unit == "K" else ""
    return f"{value:.4g} {unit}{degrees}".rstrip()
