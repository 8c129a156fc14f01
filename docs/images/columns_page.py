"""The page reference/columns of the site: every column of a recording, from the list that reading and writing use."""

from __future__ import annotations

from key_tables import section

from musclewire.signals import COLUMNS

TEXT = """For those who read or write a recording: a column's name, its SI unit and its meaning.
[Files](files.md#recordings) says what else is in one.
"""
KINDS = {
    "time": "Time",
    "electrical": "Voltages and resistance",
    "reference": "From instruments",
    "control": "From estimators and controllers",
    "table": "Printed loops",
}


def page() -> str:
    """Return the whole page."""
    sections = [
        section(
            title,
            "",
            ("Column", "Unit", "Meaning"),
            [(f"`{one.name}`", one.unit or "1", one.description) for one in COLUMNS.values() if one.kind == kind],
        )
        for kind, title in KINDS.items()
    ]
    return "\n".join(["# Columns of recordings\n", TEXT, *sections])
