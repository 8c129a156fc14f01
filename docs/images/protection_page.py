"""The page reference/protection of the site, from the table that host, exported C and firmware follow."""

from __future__ import annotations

from musclewire.controllers import AllowedDrive, ProtectionLimits, ProtectionTable, Signal, State, protection_table
from musclewire.rigs import open_rig

HEAD = """# What keeps the wire safe

For everybody who heats a real wire: what is watched, and what happens then.
`musclewire protection` prints the same table, `musclewire protection RIG` also the limits of a rig.

One table of states, signals and events protects every rig: simulated, replayed, on a card, on a board. A script
reaches the wire only through `rig.exchange(...)`, and `exchange` asks the table before a voltage goes out and after a
sample has come back. The C library of `musclewire export c` and the firmware carry the same table, made from the same
file, and follow it when the host is gone. The end of this page lists what the table cannot do.
"""

TRANSITIONS_HEAD = """## Transitions

Everything that happens to the protection is one of {signals} signals. The table gives for each state and signal the
state that follows and the effect on the way; `-` means that nothing happens. Host, C library and firmware look every
transition up here; no other line of code changes the state.
"""

RULES = """- **Latched.** After a trip the drive stays off whatever is commanded; the first cause stays, too. The rig
  must be opened again, a board armed again.
- **In time.** From a fault to 0 V takes at most 0.5 s. An event's own time is in the table; one sample period is
  added, because a fault shows in the next sample.
- **Missing.** A reading without current, a late sample or a missing command is bridged: the drive is held at once,
  falls to the sense voltage after {sense} s and goes off after {trip} s. Nothing that a script commands is followed
  meanwhile. Readings that are missing again and again add up, in any pattern; a reading that is there makes up for a
  quarter of its time, so that one of five or fewer bring nothing to the sense voltage, and their heat counts.
- **Heat.** The wire counts as heated by the larger of two powers: what was read, and what the ordered drive gives the
  smallest resistance that this wire can have (`resistance_low`); readings that are too small hide nothing. While a
  reading is missing, what was ordered counts alone; of several drives in a reading's time the highest.
- **Two clocks.** Heat counts over the sample's own time; on a rig paced by a real clock over the host's, if that is
  longer since the drive was last at the sense voltage. A tenth of difference for 5 s, or a leap, is a fault.
- **Late.** A reading may be of any drive ordered within {delay} ms before it: only more than these is a stuck output.
- **Silence.** A rig whose samples come at the pace of a real clock goes to the sense voltage {sense} s after a sample
  was due if nobody has asked for it, and is not tripped: the next `exchange` says so and runs. Any exception inside
  `exchange`, Ctrl-C too, leaves the sense voltage or less; when Python ends, every rig is switched off.
- **Opened again.** The wire of a board or a card is as warm as it was: its estimated temperature and the time are kept
  under the device's serial number, or its port, in the user's state folder (`MUSCLEWIRE_STATE_HOME` sets another one).
- **Averaged.** A reading is judged as a mean over at least {reading} ms: one noisy sample of a fast rig is no event.
- **Reported.** A trip raises `ProtectionTripError`, a `RigError` with the event in `.event`; a command ends with exit
  code 3, and the recording states the cause in `ended`.
"""

EVENTS_HEAD = """## Events

What is watched. An event that trips is the signal `fault`, once it has lasted for its time; an event that degrades is
the signal `missing`, `missing_long` or `missing_too_long`, by how long it has been seen.
"""

RESERVED_HEAD = """\
Reserved: nothing uses these any more, and nothing else will. A program written for them still compiles, and a
board with firmware 1.0 is understood: its state 3 is `armed` or what is now `degraded`.
"""

LIMITS_HEAD = """## Limits

They follow from wire and circuit; a rig file's `[limits]` sets those the user knows better (`maximum_current`,
`maximum_power`, `maximum_temperature`, `minimum_current`, `resistance_low`, `resistance_high`, `jump_share`). For the
simulated rig with the paper's wire:
"""

LAST = """## What it cannot do

- A transistor or amplifier that has failed closed heats the wire whatever the software does. The event `output_stuck`
  reports it, and only the supply's fuse, its current limit or the emergency switch stop it.
- The temperature is an estimate from the power, for still air and a straight wire. A wire in a sleeve, against a wall
  or embedded is hotter.
- A frozen converter without noise of its own is seen only when the drive has moved.
- A contact that changes the resistance by less than `jump_share` from one reading to the next is not seen here.
- A data acquisition card has no program of its own. When the machine itself dies, its output stays: see
  [how to drive an NI card](../how-to/drive_an_ni_card.md).
"""


def page() -> str:
    """Return the whole page."""
    table = protection_table()
    times = {"sense": f"{table.sense_after_s:g}", "trip": f"{table.trip_after_s:g}"}
    parts = [
        HEAD,
        f"## States\n\n{states(table)}\n\n{diagram(table)}\n\n"
        f"{RULES.format(**times, reading=f'{1e3 * table.reading_period_s:g}', delay=f'{1e3 * table.delay_s:g}')}",
        f"{TRANSITIONS_HEAD.format(signals=len(table.signal))}\n{transitions(table)}\n\n"
        f"{signals(table)}\n\n{effects(table)}\n",
        f"{EVENTS_HEAD}\n{events(table)}\n\n{RESERVED_HEAD}\n{reserved(table)}\n",
        f"{LIMITS_HEAD}\n{limits()}\n",
        LAST,
    ]
    return "\n".join(parts)


def states(table: ProtectionTable) -> str:
    """Return the states as a table."""
    rows = [f"| {row.number} | `{row.name}` | {row.output} | {row.meaning} |" for row in table.state]
    return "\n".join(["| No. | State | Output | Meaning |", "|---|---|---|---|", *rows])


def diagram(table: ProtectionTable) -> str:
    """Return the transitions as a diagram: one arrow for what leads from every driven state to the same one.

    What leads from every state to the same one (``arm``) is drawn only from the states that drive nothing.
    """
    driven = [state for state in State if table.output_drives[state] is not AllowedDrive.NONE]
    edges: dict[tuple[str, str], list[str]] = {}
    inner: dict[tuple[str, str], list[str]] = {}
    for signal in Signal:
        follow = {state: table.transitions[state][signal].state for state in State}
        reached = {follow[state] for state in driven}
        shared = len(reached) == 1 and not reached & set(driven)
        if shared:
            edges.setdefault(("driven", follow[driven[0]].name.lower()), []).append(signal.name.lower())
        everywhere = len(set(follow.values())) == 1
        for state in State:
            if follow[state] is state or (state in driven and (shared or everywhere)):
                continue
            group = inner if state in driven else edges
            group.setdefault((state.name.lower(), follow[state].name.lower()), []).append(signal.name.lower())
    lines = ["```mermaid", "stateDiagram-v2", "    [*] --> off", '    state "a drive is out" as driven {']
    lines += [f"        {start} --> {end}: {', '.join(names)}" for (start, end), names in inner.items()]
    lines += ["    }"]
    lines += [f"    {start} --> {end}: {', '.join(names)}" for (start, end), names in edges.items()]
    return "\n".join([*lines, "```"])


def transitions(table: ProtectionTable) -> str:
    """Return what each signal does in each state as a table."""
    names = list(table.signal[0].then)
    lines = [f"| Signal | {' | '.join(f'in `{name}`' for name in names)} |", "|---|" + "---|" * len(names)]
    for row in table.signal:
        cells = (row.then[name] for name in names)
        shown = ("-" if then.effect == "nothing" else f"`{then.to}`: {then.effect}" for then in cells)
        lines.append(f"| `{row.name}` | {' | '.join(shown)} |")
    return "\n".join(lines)


def signals(table: ProtectionTable) -> str:
    """Return when each signal comes as a table."""
    rows = [f"| `{row.name}` | {row.when} |" for row in table.signal]
    return "\n".join(["| Signal | When |", "|---|---|", *rows])


def effects(table: ProtectionTable) -> str:
    """Return what each effect is as a table."""
    rows = [f"| {row.name} | {row.meaning} |" for row in table.effect if row.name != "nothing"]
    return "\n".join(["| Effect | What it does |", "|---|---|", *rows])


def reserved(table: ProtectionTable) -> str:
    """Return the names and numbers that are not used any more as a table."""
    rows = [f"| {row.kind} | {row.number} | `{row.name}` | {row.why} |" for row in table.reserved]
    return "\n".join(["| What | No. | Name | Why |", "|---|---|---|---|", *rows])


def events(table: ProtectionTable) -> str:
    """Return the events as a table."""
    rows = [
        f"| {row.number} | `{row.name}` | {row.when} | {f'{row.lasts_s:g} s' if row.lasts_s else '-'} | {row.action} | "
        f"{', '.join(row.watched_by)} | {row.cause}: {row.remedy} |"
        for row in table.event
    ]
    head = "| No. | Event | When | Must last | Then | Watched by | Cause and remedy |"
    return "\n".join([head, "|---|---|---|---|---|---|---|", *rows])


def limits() -> str:
    """Return the limits of the simulated rig as a table, with what each is."""
    with open_rig("simulated") as rig:
        found = rig.protection_limits
    meaning = dict(meanings(ProtectionLimits))
    rows = [f"| `{name}` | {value:.4g} | {meaning[name]} |" for name, value in found._asdict().items()]
    return "\n".join(["| Limit | Value | What it is |", "|---|---|---|", *rows])


def meanings(model: type[ProtectionLimits]) -> list[tuple[str, str]]:
    """Return what the docstring says of each limit."""
    text = (model.__doc__ or "").partition("Attributes:")[2]
    pairs = (line.strip().partition(": ") for line in text.splitlines() if ": " in line)
    return [(name, said.rstrip(".")) for name, _, said in pairs]
