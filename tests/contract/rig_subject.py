"""A rig of the contract suite: how it is opened, and what its wire does."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from musclewire.rigs import Rig

Opened = Callable[[pytest.FixtureRequest, Path], Rig]

# Resistance between the terminals by the maker's ohm per metre, within his 15 %: 126 over 14 cm.
PAPERS_WIRE_OHM = (12.0, 20.0)


@dataclass(frozen=True)
class RigSubject:
    """One rig of the suite; its wire is cold and at rest when it has been opened.

    ``opened`` is given the test that asks, and a folder. ``cold_ohm`` is between which resistances the cold wire lies;
    ``least_strain`` and ``least_force_n`` are what the hot wire does within ten seconds: strain, and force beyond that
    of the cold wire. ``fixed_pretension``: a part of the load is the pretension. ``emulated``: opening starts a card's
    server or a board's emulator. ``in_full``: another of its kind is in CI. ``by_the_clock``: a real clock paces the
    wire of a rig that is paced; where time passes by reading, a busy test machine would make it rest.
    """

    name: str
    opened: Opened
    cold_ohm: tuple[float, float]
    least_strain: float = 0.02
    least_force_n: float = 0.1
    fixed_pretension: bool = False
    emulated: bool = False
    in_full: bool = False
    by_the_clock: bool = True

    @property
    def group(self) -> Sequence[pytest.MarkDecorator]:
        """The group of tests of this rig."""
        return (pytest.mark.full,) if self.in_full else (pytest.mark.emulated,) if self.emulated else ()


def without_a_test(make: Callable[[], Rig]) -> Opened:
    """Return what opens a rig that needs to know neither the test nor a folder."""
    return lambda _request, _folder: make()
