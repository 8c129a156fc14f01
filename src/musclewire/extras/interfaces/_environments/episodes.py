"""An episode: its targets, the paper's staircase or levels drawn at random, and the units in which it is judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any, Literal

import numpy as np

from musclewire.arrays import FloatArray, IntArray
from musclewire.controllers import staircase
from musclewire.errors import CallerError, nearest_hint

# The reward is the error in percent strain, so that a typical one is between -1 and 0.
PERCENT = 100.0
# A resistance is observed up to this multiple of the upper end of the wire's window.
MAX_RESISTANCE_FACTOR = 2.0

KINDS = ("staircase", "random")


@dataclass(frozen=True)
class Episode:
    """What a wire is asked to follow from a reset to the end of its episode; the defaults are the paper's staircase.

    References
    ----------
    Lan and Fan 2010, Fig. 11 and Table 2.
    """

    # "staircase": from low to high in equal increments and back; "random": as many levels of the whole range.
    targets: Literal["staircase", "random"] = "staircase"
    low: float = 0.015  # strain as a fraction
    high: float = 0.030  # strain as a fraction
    increments: int = 5  # from low to high; 5 make 11 levels
    hold_s: float = 6.0  # duration of a level
    # Additional time for the first level, in which a cold wire arrives there; as in mw.control.
    approach_s: float = 12.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.targets not in KINDS:
            raise CallerError(f"there are no targets '{self.targets}'{nearest_hint(self.targets, KINDS)}")
        if not (0.0 < self.low < self.high < 1.0):
            raise CallerError(f"targets from {self.low} to {self.high}: strains as fractions, the lower one first")
        if int(self.increments) != self.increments or self.increments < 1:
            raise CallerError(f"an episode of {self.increments} increments: give a whole number of at least 1")
        if not (isfinite(self.hold_s) and self.hold_s > 0.0 and isfinite(self.approach_s) and self.approach_s >= 0.0):
            raise CallerError(
                f"a level is held for {self.hold_s} s, after {self.approach_s} s for the approach: "
                "the first must be above 0, the second at least 0"
            )

    @property
    def levels(self) -> int:
        """Number of levels, the same for both kinds of targets."""
        return 2 * self.increments + 1

    def drawn(self, draws: FloatArray) -> FloatArray:
        """Return strains in the shape of the draws from 0 to 1, (..., n_levels); a staircase needs none of them."""
        if self.targets == "random":
            return self.low + (self.high - self.low) * draws
        steps = staircase(self.low, self.high, (self.high - self.low) / self.increments, self.hold_s)
        return np.broadcast_to(np.asarray(steps.levels), draws.shape).copy()

    def level_of_sample(self, sample_period_s: float) -> IntArray:
        """Return the level asked for in each sample after the reset, and after the last one, (n_samples + 1,)."""
        approach, hold = round(self.approach_s / sample_period_s), max(round(self.hold_s / sample_period_s), 1)
        samples = np.arange(approach + self.levels * hold + 1)
        return np.clip((samples - approach) // hold, 0, self.levels - 1)


def episode_from(given: Episode | str | Mapping[str, Any]) -> Episode:
    """Return an episode from the name of its targets or from its numbers, as ``gymnasium.make`` can carry them."""
    if isinstance(given, Episode):
        return given
    if isinstance(given, str):
        return Episode(targets=given)  # type: ignore[arg-type]  # checked there
    known = Episode.__dataclass_fields__
    for name in given:
        if name not in known:
            raise CallerError(f"an episode has no '{name}'{nearest_hint(name, known)}")
    return Episode(**given)
