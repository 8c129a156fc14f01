"""Checks of a design: a number compared with a reference."""

from __future__ import annotations

from typing import NamedTuple


class DesignCheck(NamedTuple):
    """A number of a design, compared with a reference.

    ``rule`` is "about" (within ``tolerance`` of it, relative), "below", "above", or "shown" if it is not judged.
    """

    name: str
    value: float
    reference: float
    unit: str
    rule: str
    tolerance: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether the rule holds, apart from rounding in the last digits."""
        if self.rule == "shown":
            return True
        slack = 1e-9 * abs(self.reference)
        if self.rule == "below":
            return self.value <= self.reference + slack
        if self.rule == "above":
            return self.value >= self.reference - slack
        return abs(self.value - self.reference) <= self.tolerance * abs(self.reference)
