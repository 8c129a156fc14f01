"""Synthetic strain-resistance loops with a gap that is known exactly.

One number u runs along a branch: 0 at A (cold), A_TO_B at B, 1 at C, beyond 1 hotter austenite. Resistance
and strain are closed-form functions of it, so heating and cooling are curves whose distance is known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Loop:
    resistance_ohm: FloatArray
    strain: FloatArray
    time_s: FloatArray


@dataclass(frozen=True)
class LoopMaker:
    """A wire like the paper's of 100 um: 15.15 to 17.49 ohm, strain to 3.5 %, A-B 15 % of it."""

    resistance_min_ohm: float = 15.1526
    resistance_max_ohm: float = 17.4945
    resistance_cold_ohm: float = 17.05
    hot_rise_ohm: float = 0.12
    strain_max: float = 0.035
    a_to_b: float = 0.15
    middle_gap: float = 0.001  # strain between the branches where they are furthest apart
    crossing: bool = False
    roundness: float = 0.6  # 0: resistance falls linearly with progress; 1: a cosine

    def gap_at(self, normalised_resistance: FloatArray) -> FloatArray:
        """Heating minus cooling strain; zero at both ends, where the loop closes."""
        if self.crossing:
            return self.middle_gap * np.sin(2 * np.pi * normalised_resistance)
        return self.middle_gap * 4 * normalised_resistance * (1 - normalised_resistance)

    def exact_gap(self) -> float:
        """Mean absolute distance of the branches over the largest strain of B-C (Eq. 2)."""
        share = 2 / np.pi if self.crossing else 2 / 3
        return abs(self.middle_gap) * share / self.strain_max

    def resistance(self, progress: FloatArray) -> FloatArray:
        cold = np.clip(1 - progress / self.a_to_b, 0, 1)
        rise = self.resistance_max_ohm - (self.resistance_max_ohm - self.resistance_cold_ohm) * cold**1.3
        span = self.resistance_max_ohm - self.resistance_min_ohm
        fall = self.resistance_min_ohm + span * self.normalised(progress)
        hot = self.hot_rise_ohm * np.clip((progress - 1) / 0.2, 0, None)
        return np.where(progress < self.a_to_b, rise, fall + hot)

    def normalised(self, progress: FloatArray) -> FloatArray:
        within = np.clip((progress - self.a_to_b) / (1 - self.a_to_b), 0, 1)
        return (1 - self.roundness) * (1 - within) + self.roundness * (1 + np.cos(np.pi * within)) / 2

    def strain(self, progress: FloatArray, heating: bool) -> FloatArray:
        share = np.clip(progress, 0, 1)
        # Thermal expansion of austenite beyond C takes a little of the contraction back.
        base = self.strain_max * (share - 0.01 * np.clip(progress - 1, 0, None))
        inside = (progress > self.a_to_b) & (progress < 1)
        half = np.where(inside, self.gap_at(self.normalised(progress)) / 2, 0.0)
        return base + (half if heating else -half)

    def along(self, progress: FloatArray) -> Loop:
        """A recording of the given progress; rising progress is heating."""
        heating = np.gradient(progress) >= 0
        strain = np.where(heating, self.strain(progress, True), self.strain(progress, False))
        return Loop(self.resistance(progress), strain, np.arange(progress.size, dtype=np.float64))

    def record(
        self,
        samples: int = 1800,
        top: float = 1.2,
        bottom: float = 0.0,
        cycles: float = 1.0,
        start: float = 0.0,
    ) -> Loop:
        """A slow sine between ``bottom`` and ``top``; ``start`` is the phase in cycles (0 cold, 0.5 hot)."""
        phase = start + np.linspace(0, cycles, samples)
        return self.along(bottom + (top - bottom) * (1 - np.cos(2 * np.pi * phase)) / 2)


def noisy(loop: Loop, resistance_share: float, strain_share: float, seed: int = 0) -> Loop:
    """White noise: a share of the mean resistance, and a share of the stroke."""
    random = np.random.default_rng(seed)
    size = loop.strain.size
    resistance = loop.resistance_ohm + random.normal(size=size) * resistance_share * loop.resistance_ohm.mean()
    strain = loop.strain + random.normal(size=size) * strain_share * np.ptp(loop.strain)
    return Loop(resistance, strain, loop.time_s)


def picked(loop: Loop, keep: npt.NDArray[np.intp]) -> Loop:
    return Loop(loop.resistance_ohm[keep], loop.strain[keep], loop.time_s[keep])
