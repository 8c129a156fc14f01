"""What rows need and no seed changes, made once for all seeds: the published sample's isobars, the staircase."""

from __future__ import annotations

from functools import cached_property
from typing import NoReturn

from musclewire.controllers import Staircase, staircase
from musclewire.identify import IsobaricLoop, IsobarSummary, simulated_isobar, summarize_isobar
from musclewire.parameters import load_alloy, load_bench, load_wire

ISOBAR_WIRE = "isobar-sample"


class NeedsSeedError(Exception):
    """A row asked for a recording of a rig, which differs from seed to seed."""


class SeedlessRuns:
    """The part of ``RunCache`` that no seed changes, measured on once; anything else raises NeedsSeedError."""

    def __init__(self) -> None:
        """Make nothing yet."""
        self._isobars: dict[float, IsobaricLoop] = {}

    def __getattr__(self, name: str) -> NoReturn:
        """Refuse what a seed is needed for."""
        raise NeedsSeedError(name)

    @cached_property
    def staircase(self) -> Staircase:
        """The paper's steps."""
        return staircase()

    def isobar(self, stress_mpa: float) -> IsobaricLoop:
        """Return the simulated loop at constant stress of the sample behind the published isobars."""
        if stress_mpa not in self._isobars:
            wire = load_wire(ISOBAR_WIRE)
            self._isobars[stress_mpa] = simulated_isobar(
                load_alloy(wire.alloy), wire, load_bench("paper"), 1e6 * stress_mpa
            )
        return self._isobars[stress_mpa]

    def isobar_summary(self, stress_mpa: float) -> IsobarSummary:
        """Return stroke and temperatures of the simulated isobar."""
        return summarize_isobar(self.isobar(stress_mpa))
