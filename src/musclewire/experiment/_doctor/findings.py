"""Results of checks, as plain values."""

from __future__ import annotations

from typing import NamedTuple


class RigCheck(NamedTuple):
    """One check: measured value, whether it is acceptable, and advice: what to do if not, else what it means."""

    name: str
    ok: bool
    value: float | str | None
    unit: str
    advice: str


class SkippedCheck(NamedTuple):
    """A check that could not be made on this rig or after earlier findings, and why."""

    name: str
    reason: str


class Findings(NamedTuple):
    """Checks that were made and checks that could not be."""

    checks: tuple[RigCheck, ...]
    unchecked: tuple[SkippedCheck, ...] = ()

    def __add__(self, other: object) -> Findings:
        """Return both lists, one after the other."""
        if not isinstance(other, Findings):
            return NotImplemented
        return Findings(self.checks + other.checks, self.unchecked + other.unchecked)

    @property
    def failed(self) -> frozenset[str]:
        """Names of the checks that did not hold."""
        return frozenset(check.name for check in self.checks if not check.ok)
