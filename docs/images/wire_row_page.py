"""The page reference/wire_row of the site, from the two lists of fields that lay out the simulated wire in memory."""

from __future__ import annotations

from musclewire.wire import Row, WireConstants, WireState

HEAD = """# The row of a wire

For those who write their own programs around the simulated wire.
A simulated wire is two rows: its state, which changes from step to step, and its constants. A row is a
NumPy record: compiled code reads and writes `state.temperature_k` in place, Python reads the same name
(`required_true_state(rig).wire_state.temperature_k`), and many wires are an array of rows. A state that was handed out
never changes: a step works on a copy. `state.replace(time_s=0.0)` is another state, `state.values()` every field by
name, `state.row` the record itself, in an array of one.

Every number is a double. `classes` is the number of classes of barrier, 1 unless whoever builds the constants gives
more; each number of them has a layout of its own, for which the kernels are compiled once and kept on disk. What a step
reads are products and reciprocals of the constants, made once (`wire:StepConstants`).
"""


def page() -> str:
    """Return the whole page."""
    parts = [
        HEAD,
        f"## State\n\n`wire:WireState`. {summary(WireState)}\n\n{fields(WireState)}\n",
        f"## Constants\n\n`wire:WireConstants`. {summary(WireConstants)}\n\n{fields(WireConstants)}\n",
    ]
    return "\n".join(parts)


def summary(row: type[Row]) -> str:
    """Return the first line of a class's docstring."""
    return (row.__doc__ or "").splitlines()[0]


def fields(row: type[Row]) -> str:
    """Return the fields of a row as a table, in their order in memory."""
    lines = [
        f"| `{item.name}` | {item.unit} | {'' if item.length is None else f'({item.length},)'} | {item.meaning} |"
        for item in row.fields
    ]
    return "\n".join(["| field | unit | shape | meaning |", "|---|---|---|---|", *lines])
