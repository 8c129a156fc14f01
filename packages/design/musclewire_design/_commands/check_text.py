"""How the checks of a design read: as lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from musclewire_design._design_checks import DesignCheck

# How numbers of a unit are shown: unit, factor.
SHOWN = {"N/m": ("N/m", 1.0), "Pa": ("MPa", 1e-6), "m": ("mm", 1e3), "N": ("N", 1.0), "1": ("", 1.0)}
RULES = {"about": "", "below": "at most ", "above": "at least ", "shown": ""}


def check_lines(checks: Sequence[DesignCheck]) -> list[str]:
    """Return checks as lines, one below the other."""
    width = max(len(check.name) for check in checks)
    return [check_line(check, width) for check in checks]


def check_line(check: DesignCheck, width: int) -> str:
    """Return a check as a line."""
    unit, factor = SHOWN[check.unit]
    mark = "    " if check.rule == "shown" else "ok  " if check.ok else "NOT "
    against = f"{RULES[check.rule]}{factor * check.reference:.5g} {unit}".rstrip()
    off = ""
    if check.rule in ("about", "shown"):
        off = f", {100 * (check.value / check.reference - 1):+.2f} %"
    return f"  {mark}{check.name:<{width}}  {factor * check.value:>8.5g}  {against}{off}"
