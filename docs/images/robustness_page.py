"""Tables of estimators under disturbance and of controllers at tasks, from rows that ``musclewire robustness`` wrote.

They are copies of its files in studies/robustness: rows.json of a run on the held-out seeds, tasks.json of --tasks.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from parameter_page import table

FOLDER = Path(__file__).parents[2] / "studies" / "robustness"
# Conditions that the page leaves out, as they are nearly those of another row.
LEFT_OUT = ("air known", "12 bits", "24 bits")


def all_conditions() -> str:
    """Return errors of estimators as a table."""
    data = json.loads((FOLDER / "rows.json").read_text("utf-8"))
    rows = [row for row in data["rows"] if not name_of(row).endswith(LEFT_OUT)]
    alone = errors(rows)
    conditions = list(dict.fromkeys(map(name_of, rows)))
    cells = [[item, *(number(found.get(item)) for found in alone.values())] for item in conditions]
    return (
        f"Root mean square error in percent of the full stroke. {len(data['seeds'])} wires, {data['seeds_are']}; "
        f"references: {', '.join(data['references'])}.\n\n"
        f"{table(['condition', *(f'{name}, %' for name in alone)], cells)}"
    )


def all_tasks() -> str:
    """Return mean and largest errors of controllers at tasks as a table."""
    data = json.loads((FOLDER / "tasks.json").read_text("utf-8"))
    rows = data["rows"]
    controllers = list(dict.fromkeys(row["controller"] for row in rows))
    found = {(row["plant"], row["task"], row["condition"], row["controller"]): row for row in rows}
    cells = [
        [
            *name,
            *(
                f"{number(found[*name, one]['mae_mean_pct'])}; {number(found[*name, one]['error_largest_pct'])}"
                for one in controllers
            ),
        ]
        for name in dict.fromkeys(key[:3] for key in found)
    ]
    heads = ["plant", "task", "condition", *(f"{name}, %" for name in controllers)]
    named = " ".join(
        f"{one['controller']}: {one['sees'] + one['others']} of {one['runs']} runs err by more than 5 % in the mean, "
        f"{one['sees']} see it themselves, {one['sees_named']} of these end with 1 or were announced."
        for one in data["named"]
    )
    return f"Mean and largest error in percent of the target, medians over seeds. {named}\n\n{table(heads, cells)}"


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
        found.setdefault(row["estimator"], {})[name_of(row)] = row["estimate_rms_pct"]
    return found
