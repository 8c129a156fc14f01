"""The page reference/simulated_numbers of the site: tables of simulated numbers, whose meaning is on pages by hand."""

from __future__ import annotations

import alternatives_page
import balance_numbers
import robustness_page
import turns_numbers

HEAD = """# Tables of simulated numbers

For whoever needs all numbers behind a sentence of [physics](../explanation/physics.md), [turns and minor
loops](../explanation/turns_and_minor_loops.md), [parameters](../explanation/parameters.md) or
[estimators](../explanation/estimators.md), which say how they came about.
"""


def page() -> str:
    """Return the whole page, after a minute of simulations."""
    turns = turns_numbers.tables()
    sections = {
        "What parts the branches, over pretension": balance_numbers.balance_tables(),
        "The gap with each cause taken out": balance_numbers.changes_table(),
        "Distance of the branches of isobars": turns["branches"],
        "Strain after the turns at the ends of isobars": turns["ends"],
        "Kelvins of rest after a turn inside the loop": turns["rests"],
        "What fits predict that they did not see": alternatives_page.held_out_table(),
        "What it costs to hold a parameter to what is published": alternatives_page.held_inside_table(),
        "Errors of estimators under disturbance": robustness_page.all_conditions(),
        "Errors of controllers at tasks": robustness_page.all_tasks(),
    }
    return "\n".join([HEAD, *(f"## {title}\n\n{table}\n" for title, table in sections.items())])
