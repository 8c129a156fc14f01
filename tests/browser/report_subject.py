"""A report that a command writes, as the tests in a browser open it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class ReportSubject:
    """A report: the commands that lead to it, what they need in their folder, and how many figures it has at least."""

    name: str
    commands: tuple[tuple[str, ...], ...]
    figures: int
    files: Mapping[str, str] = field(default_factory=dict)
