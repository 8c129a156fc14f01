"""The page reference/paper_map of the site: what is written by hand, and a column that says what its rows say.

Column "Rows" names beginnings of rows of ``musclewire reproduce``, as ``--only`` takes them; which rows fail is the
committed list of known failures, which test_reproduce.py of tests/extras/paper holds to a whole run.
"""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import get_args

from musclewire.extras.paper import Origin, PaperCheck, all_checks, known_failures, selected

BY_HAND = Path(__file__).resolve().parents[1] / "reference" / "paper_map.md"
ROWS, COMPARED = "Rows", "Compared"
NOTHING = "not compared"


def page() -> str:
    """Return the whole page."""
    lines, header = [], []
    for line in BY_HAND.read_text("utf-8").splitlines():
        if not line.startswith("|"):
            header = []
            lines.append(line)
            continue
        cells = cells_of(line)
        if not header:
            header, said = cells, COMPARED
        elif set(line) <= set("|-"):
            said = "---"
        else:
            said = compared(re.findall(r"`([^`]+)`", cells[header.index(ROWS)]))
        after = header.index(ROWS) + 1
        lines.append(f"| {' | '.join([*cells[:after], said, *cells[after:]])} |")
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
