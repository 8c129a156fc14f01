"""The page reference/faults of the site, from the table that the fault tests run (tests/faults/matrix.toml)."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

MATRIX = Path(__file__).resolve().parents[2] / "tests" / "faults" / "matrix.toml"
WHERE = ("wire", "circuit", "converter", "board", "line", "host")

HEAD = """# Faults that were injected

For everybody who asks what happens when something breaks: what was broken on purpose, and what followed.
`pytest tests/extras/board/faults tests/extras/instruments` injects every row.

{count} faults are injected into wire, circuit, converter, board, line and host. {ended} end in the safe state: 0 V at
the wire within the stated time, the cause in the recording's `ended`, exit code 3 if the host survives. {survived}
are survived: the run continues. The voltage at the wire is read from the bench's own log, tick by tick, not from host
or board.

How they are run:

- **lockstep**: the real firmware in QEMU, host driver and serial protocol, the simulated wire on its pins; time passes
  only for commands, so the result is the same on a busy machine.
- **clock**: the same by the clock, 1 kHz.
- **command**: the same with `musclewire characterize` as a process of its own.
- **simulated**: the simulated rig with a `[[fault]]` in its rig file.

None of this was tried on a real board with a real wire: QEMU is no hardware, and its timing is not that of a
microcontroller ([what was tried](firmware_protocol.md)).
"""

FOOT = """## What the times mean

From the injection to the last tick with a voltage at the wire. The sample period, 50 ms here, is added to the
time an event must last. The board watches by itself and does not wait for the host: rows in which "board" acts need no
host at all. A transistor that has failed closed cannot be switched off by anything in this table: there the commanded
code is checked, and the message says to cut the power.

"-" as exit code: the host was killed, or a script's own exception decides. Where several events are named, chance
decides which of them is seen first.

## Faults in a simulated rig

A simulated rig file takes the same faults, to see what your own script does with them:

    [[fault]]
    kind = "bad_contact"    # the wire's clamp lets go a little
    at = "3 s"
    lasts = "0.5 s"         # without it the fault stays
    resistance = "5 ohm"

All kinds and their keys: [rig files](rig_files.md).
"""


def page() -> str:
    """Return the whole page."""
    rows: list[dict[str, Any]] = tomllib.loads(MATRIX.read_text(encoding="utf-8"))["fault"]
    survived = sum(not row["event"] for row in rows)
    head = HEAD.format(count=len(rows), ended=len(rows) - survived, survived=survived)
    parts = [head]
    for where in WHERE:
        parts.append(f"## In the {where}\n\n{table([row for row in rows if row['where'] == where])}\n")
    return "\n".join([*parts, FOOT])


def table(rows: list[dict[str, Any]]) -> str:
    """Return the faults of one place."""
    lines = ["| Fault | Ends with | Within | Who acts | Exit code | Run |", "|---|---|---|---|---|---|"]
    for row in rows:
        events = " or ".join(f"`{event}`" for event in row["event"]) or "survived"
        within = f"{row['within_s']:g} s" if row["event"] else "-"
        code = row.get("exit", "3") if row["event"] else "0"
        events = {
            "`-`": "expiry on the board",
            "`version`": "refused on opening",
            "`cannot write`": "its own message",
        }.get(events, events)
        lines.append(f"| {row['name']} | {events} | {within} | {row['acts']} | {code} | {row['run']} |")
    return "\n".join(lines)
