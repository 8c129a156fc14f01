"""Tables of estimators under disturbance, short and long, from the rows that ``musclewire robustness`` has written.

They are a copy of its rows.json: studies/robustness/rows.json, of a run on the held-out seeds.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from parameter_page import table

ROWS = Path(__file__).parents[2] / "studies" / "robustness" / "rows.json"
# Conditions that the page leaves out, as they are nearly those of another row.
LEFT_OUT = ("air known", "12 bits", "24 bits")
# Those of the short table.
SHOWN = ("none", "draughts 0.25", "load +50 %", "k x2", "R +1 %", "R +1 %, home", "T +5 K", "noise x10")


def all_conditions() -> str:
    """Return errors of estimators, and next to them errors of closed loops, as one table."""
    data = json.loads(ROWS.read_text("utf-8"))
    rows = [row for row in data["rows"] if not name_of(row).endswith(LEFT_OUT)]
    alone, loops = errors(rows), loop_errors(rows)
    conditions = list(dict.fromkeys(map(name_of, rows)))
    cells = [[item, *(number(found.get(item)) for found in (alone | loops).values())] for item in conditions]
    heads = [*(f"{name}, %" for name in alone), *(f"loop: {name}, %" for name in loops)]
    return (
        "Estimators: root mean square error in percent of the full stroke. Loops: mean absolute error in percent of "
        f"the target on the paper's staircase, approach included. {len(data['seeds'])} wires, {data['seeds_are']}; "
        f"references: {', '.join(data['references'])}.\n\n{table(['condition', *heads], cells)}"
    )


def block() -> str:
    """Return what estimators err by under some of the conditions, in a short table."""
    rows = [row for row in json.loads(ROWS.read_text("utf-8"))["rows"] if name_of(row) in SHOWN]
    alone = errors(rows)
    return table(
        ["condition", *(f"{name}, %" for name in alone)],
        [[item, *(number(found[item]) for found in alone.values())] for item in SHOWN],
    )


def name_of(row: dict[str, Any]) -> str:
    """Return the name of a row's condition."""
    return f"{row['disturbance']} {row['level']}".strip()


def number(value: float | None) -> str:
    """Return a number with two digits, a dash for none."""
    return "–" if value is None else f"{value:.2f}"


def errors(rows: list[dict[str, Any]]) -> dict[str, dict[str, float]]:
    """Return the root mean square error of each estimator by condition [% of the stroke]."""
    found: dict[str, dict[str, float]] = {}
    for row in rows:
        if row["controller"] is None:
            found.setdefault(row["estimator"], {})[name_of(row)] = row["estimate_rms_pct"]
    return found


def loop_errors(rows: list[dict[str, Any]]) -> dict[str, dict[str, float]]:
    """Return the mean absolute error of each closed loop that has any, by condition [% of the target]."""
    found: dict[str, dict[str, float]] = {}
    for row in rows:
        if row["controller"] is not None and row["mae_mean_pct"] is not None:
            found.setdefault(f"{row['estimator']}, {row['controller']}", {})[name_of(row)] = row["mae_mean_pct"]
    return found
