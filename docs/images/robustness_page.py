"""The table of docs/explanation/estimators.md, from the rows that ``musclewire robustness`` has written.

They are a copy of its rows.json: studies/robustness_rows.json, of a run on the held-out seeds.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from parameter_page import table

ROWS = Path(__file__).parents[2] / "studies" / "robustness_rows.json"
NOT_RUN = "Not run yet: `musclewire robustness`, then copy its `rows.json` to `studies/robustness_rows.json`."


def block() -> str:
    """Return errors of estimators, and errors of closed loops, as tables."""
    if not ROWS.exists():
        return NOT_RUN
    data = json.loads(ROWS.read_text("utf-8"))
    rows = data["rows"]
    parts = [
        f"{len(data['seeds'])} wires, {data['seeds_are']}; references: {', '.join(data['references'])}.",
        errors([row for row in rows if row["controller"] is None]),
    ]
    loops = [row for row in rows if row["controller"] is not None]
    if loops:
        parts += [
            "Closed loops on the paper's staircase, mean absolute error in percent of the target, approach included:",
            loop_errors(loops),
        ]
    return "\n\n".join(parts)


def name_of(row: dict[str, Any]) -> str:
    """Return the name of a row's condition."""
    return f"{row['disturbance']} {row['level']}".strip()


def number(value: float | None) -> str:
    """Return a number with two digits, a dash for none."""
    return "–" if value is None else f"{value:.2f}"


def errors(rows: list[dict[str, Any]]) -> str:
    """Return the errors of estimators: a row for each condition."""
    names = list(dict.fromkeys(row["estimator"] for row in rows))
    found = {(name_of(row), row["estimator"]): row["estimate_rms_pct"] for row in rows}
    conditions = list(dict.fromkeys(map(name_of, rows)))
    return table(["", *names], [[item, *(number(found[item, name]) for name in names)] for item in conditions])


def loop_errors(rows: list[dict[str, Any]]) -> str:
    """Return the mean errors of closed loops: a row for each condition."""
    names = list(dict.fromkeys((row["estimator"], row["controller"]) for row in rows))
    found = {(name_of(row), row["estimator"], row["controller"]): row["mae_mean_pct"] for row in rows}
    conditions = list(dict.fromkeys(map(name_of, rows)))
    head = ["", *(f"{estimator}, {controller}" for estimator, controller in names)]
    return table(head, [[item, *(number(found[item, *name]) for name in names)] for item in conditions])
