"""The column "Compared" of docs/reference/paper_map.md: what the rows of ``musclewire reproduce`` say of each entry.

The page is written by hand but for that column. Column "Rows" names beginnings of rows, as ``--only`` takes them; which
rows fail is the committed list of known failures, which test_reproduce.py of tests/extras/paper holds to a whole run.
"""

from __future__ import annotations

import re
from collections import Counter
from typing import get_args

from musclewire.extras.paper import Origin, PaperCheck, all_checks, known_failures, selected

ROWS, COMPARED = "Rows", "Compared"
NOTHING = "not compared"


def page(text: str) -> str:
    """Return the page with its column written again."""
    lines, header = [], []
    for line in text.splitlines():
        if not line.startswith("|"):
            header = []
        elif not header:
            header = cells_of(line)
        elif COMPARED in header and not set(line) <= set("|-: "):
            cells = cells_of(line)
            cells[header.index(COMPARED)] = compared(re.findall(r"`([^`]+)`", cells[header.index(ROWS)]))
            line = f"| {' | '.join(cells)} |".replace("|  |", "| |")
        lines.append(line)
    return "\n".join(lines) + "\n"


def cells_of(line: str) -> list[str]:
    """Return the cells of a table's line."""
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]]


def checks_of(beginnings: list[str]) -> list[PaperCheck]:
    """Return the judged rows that begin with one of some names, each once."""
    checks = all_checks()
    found = {check.name: check for beginning in beginnings for check in selected(checks, beginning)}
    return [check for check in found.values() if check.compare in {"within", "at most", "at least"}]


def compared(beginnings: list[str]) -> str:
    """Return whether the rows hold, how many there are of which origin, and the names of those that fail."""
    checks = checks_of(beginnings)
    if not checks:
        return NOTHING
    counts = Counter(check.origin for check in checks)
    origins = ", ".join(f"{counts[origin]} {origin}" for origin in get_args(Origin) if counts[origin])
    failing = [f"`{check.name}`" for check in checks if check.name in known_failures()]
    if not failing:
        return f"holds: {origins}"
    return f"**fails** {len(failing)} of {len(checks)} ({origins}): {', '.join(failing)}"
