"""The grain ensemble written a second time from its rules, by brute force, without the kernel.

Twenty thousand grains, each wholly in one of three phases; a grain switches when an advantage passes its barrier,
and the larger excess wins. No grain has a width and nothing is compiled.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

AUSTENITE, R_PHASE, MARTENSITE = 0, 1, 2


class HardSwitches:
    """Grains of an alloy at one stress, all austenite at the start."""

    def __init__(self, numbers: dict[str, float], stress_pa: float, grains: int = 20_000) -> None:
        share = (np.arange(grains) + 0.5) / grains
        early = int((share < numbers["early_fraction"]).sum())
        z = norm.ppf(np.maximum(share, numbers["early_fraction"]))
        stretch = np.where(z > 0, 1 + numbers["grain_skew"], 1 - numbers["grain_skew"])
        delta = stretch * z * (z**2 + 0.3**2) ** (numbers["grain_tail"] / 2)
        delta[:early] -= numbers["early_width"] * (1.0 - share[:early] / max(numbers["early_fraction"], 1e-9))
        self.middle_m = (
            numbers["martensite_temperature_k"]
            + stress_pa / numbers["martensite_stress_rate_pa_per_k"]
            + (numbers["martensite_spread_k"] + numbers["martensite_spread_per_pa"] * stress_pa) * delta
        )
        self.middle_r = (
            numbers["r_phase_temperature_k"]
            + stress_pa / numbers["r_phase_stress_rate_pa_per_k"]
            + numbers["r_phase_spread_k"] * delta
        )
        self.ratio = numbers["r_phase_entropy_ratio"]
        self.h_m = numbers["martensite_barrier_k"] + numbers["martensite_barrier_per_pa"] * stress_pa
        self.h_r = numbers["r_phase_barrier_k"]
        self.h_rm = numbers["r_to_m_barrier_k"]
        self.phase = np.full(grains, AUSTENITE)

    def go_to(self, temperature_k: float) -> None:
        """Switch until nothing more is due."""
        f_m = self.middle_m - temperature_k
        f_r = self.ratio * (self.middle_r - temperature_k)
        advantage = np.stack((np.zeros_like(f_m), f_r, f_m))
        barrier = np.array([[0, self.h_r, self.h_m], [self.h_r, 0, self.h_rm], [self.h_m, self.h_rm, 0]])
        everyone = np.arange(self.phase.size)
        for _ in range(4):
            excess = advantage - advantage[self.phase, everyone] - barrier[self.phase].T
            excess[self.phase, everyone] = 0.0
            best = excess.argmax(axis=0)
            due = excess[best, everyone] > 0.0
            if not due.any():
                return
            self.phase = np.where(due, best, self.phase)
        raise AssertionError("grains go round in circles: the barriers contradict each other")

    def fractions(self) -> tuple[float, float]:
        """Return the shares of martensite and R-phase."""
        return float(np.mean(self.phase == MARTENSITE)), float(np.mean(self.phase == R_PHASE))

    def along(self, temperatures_k: Iterable[float]) -> NDArray[np.float64]:
        """Return both fractions at each temperature, (n, 2)."""
        found = []
        for temperature in temperatures_k:
            self.go_to(float(temperature))
            found.append(self.fractions())
        return np.array(found)
