"""An ensemble of grains in plain Python: what one writes after Preisach, without compiling it.

Relays between austenite and martensite over a common barrier, their balance temperatures spread as a normal
distribution; the wire around them, heat, spring and resistance, is that of ``easier_wire`` in explicit steps.
It remembers minor loops, as the simulated wire does, and has neither R-phase nor friction.
"""

from __future__ import annotations

from statistics import NormalDist

from benchmarks.speed.easier_wire import (
    AMBIENT_K,
    AREA_M2,
    AUSTENITE_OHM_M,
    AUSTENITE_PA,
    AUSTENITE_PER_K,
    BALANCE_K,
    BARRIER_K,
    CAPACITY_J_PER_K,
    COLD_STRAIN,
    LATENT_J,
    LEG_M,
    LEGS,
    LENGTH_M,
    LOSS_W_PER_K,
    MARTENSITE_OHM_M,
    MARTENSITE_PA,
    MARTENSITE_PER_K,
    PRETENSION_N,
    SERIES_OHM,
    STIFFNESS_N_PER_M,
    STRESS_RATE_PA_PER_K,
    STROKE,
)

__all__ = ["GRAINS", "GrainWire"]

# As many as the simulated wire had before its distribution became continuous.
GRAINS = 160
SPREAD_K = 6.0


class GrainWire:
    """A wire of so many grains, cold at the start."""

    def __init__(self) -> None:
        """Spread the balance temperatures of the grains."""
        deviates = [NormalDist().inv_cdf((number + 0.5) / GRAINS) for number in range(GRAINS)]
        self.balance_k = [BALANCE_K + SPREAD_K * deviate for deviate in deviates]
        self.is_martensite = [True] * GRAINS
        self.enthalpy_j = 0.0
        self.temperature_k, self.martensite = AMBIENT_K, 1.0

    def advance(self, drive_voltage_v: float, step_s: float) -> None:
        """Advance by one explicit step at a drive voltage."""
        x = self.martensite
        compliance = x / MARTENSITE_PA + (1.0 - x) / AUSTENITE_PA
        stress_pa = (PRETENSION_N + STIFFNESS_N_PER_M * LEG_M * (COLD_STRAIN - STROKE * x)) / (
            LEGS * AREA_M2 + STIFFNESS_N_PER_M * LEG_M * compliance
        )
        warm_k = self.temperature_k - 293.15
        ohm_m = x * MARTENSITE_OHM_M * (1.0 + MARTENSITE_PER_K * warm_k)
        ohm_m += (1.0 - x) * AUSTENITE_OHM_M * (1.0 + AUSTENITE_PER_K * warm_k)
        stretch = (1.0 + STROKE * x) / (1.0 + STROKE)
        resistance_ohm = ohm_m * LENGTH_M / AREA_M2 * stretch * stretch
        current_a = drive_voltage_v / (resistance_ohm + SERIES_OHM)
        lost_w = LOSS_W_PER_K * (self.temperature_k - AMBIENT_K)
        self.enthalpy_j += (current_a * current_a * resistance_ohm - lost_w) * step_s
        self._switch(stress_pa / STRESS_RATE_PA_PER_K)
        self.temperature_k = AMBIENT_K + (self.enthalpy_j - LATENT_J * (1.0 - self.martensite)) / CAPACITY_J_PER_K

    def _switch(self, by_stress_k: float) -> None:
        """Let each grain jump whose barrier is overcome."""
        switched = 0
        for grain, balance_k in enumerate(self.balance_k):
            advantage_k = balance_k + by_stress_k - self.temperature_k
            if self.is_martensite[grain]:
                self.is_martensite[grain] = advantage_k > -BARRIER_K
            else:
                self.is_martensite[grain] = advantage_k > BARRIER_K
            switched += self.is_martensite[grain]
        self.martensite = switched / GRAINS
