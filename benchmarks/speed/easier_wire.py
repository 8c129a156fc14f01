"""The wire that one writes with SciPy in an afternoon: what the simulated wire is compared with.

Two phases with thermally activated jumps over one barrier (Seelecke and Mueller's kinetics), a bias spring in closed
form, constant convection, latent heat, resistance; scalars and ``math`` only, as no array makes it faster. Without
R-phase, spread of transformation temperatures (so minor loops), friction and the stress dependence of martensite's
strain it is an easier wire than ours. References: Seelecke and Mueller 2004, doi 10.1115/1.1584064.
"""

from __future__ import annotations

import math
from typing import Any

__all__ = ["AMPLITUDE_V", "PERIOD_S", "SENSE_V", "START", "ScipyLoop", "drive_v", "rates", "scipy_cycle"]

# The slow sine of the paper's bench.
PERIOD_S, SENSE_V, AMPLITUDE_V = 90.0, 0.3, 3.2

# 0.1 mm wire, 14 cm in a V, round numbers for NiTi.
AREA_M2 = math.pi / 4 * 100e-6**2
LENGTH_M, LEG_M, LEGS = 0.14, 0.07, 2.0
CAPACITY_J_PER_K = 6450.0 * 500.0 * AREA_M2 * LENGTH_M
LATENT_J = 6450.0 * 20e3 * AREA_M2 * LENGTH_M
LOSS_W_PER_K = 135.0 * math.pi * 100e-6 * LENGTH_M
AMBIENT_K, PRETENSION_N, STIFFNESS_N_PER_M, SERIES_OHM = 295.15, 1.9, 588.6, 1.0
BALANCE_K, STRESS_RATE_PA_PER_K, BARRIER_K, SHARPNESS_K, JUMPS_PER_S = 342.0, 8e6, 10.0, 1.5, 20.0
AUSTENITE_PA, MARTENSITE_PA, STROKE = 60e9, 30e9, 0.04
AUSTENITE_OHM_M, MARTENSITE_OHM_M, AUSTENITE_PER_K, MARTENSITE_PER_K = 0.86e-6, 0.95e-6, 2e-4, 6e-4
COLD_STRAIN = PRETENSION_N / (LEGS * AREA_M2) / MARTENSITE_PA + STROKE
# Temperature [K] and fraction of martensite of the cold wire.
START = (AMBIENT_K, 1.0)
# Along the slow sine its temperature is then within 10 mK of a solution at tighter tolerances.
TOLERANCES: dict[str, Any] = {"method": "LSODA", "rtol": 1e-5, "atol": 1e-7}


def drive_v(time_s: float) -> float:
    """Return the slow sine [V]."""
    return SENSE_V + (AMPLITUDE_V - SENSE_V) * 0.5 * (1.0 - math.cos(2.0 * math.pi * time_s / PERIOD_S))


def rates(temperature_k: float, martensite: float, drive_voltage_v: float) -> tuple[float, float]:
    """Return the rates of temperature [K/s] and martensite [1/s]: force balance, Joule heat, convection, jumps.

    It calls nothing but ``math``, so that Numba compiles the same lines (``compiled_wires``).
    """
    # The force balance is linear in the stress, and so in closed form.
    compliance = martensite / MARTENSITE_PA + (1.0 - martensite) / AUSTENITE_PA
    stress_pa = (PRETENSION_N + STIFFNESS_N_PER_M * LEG_M * (COLD_STRAIN - STROKE * martensite)) / (
        LEGS * AREA_M2 + STIFFNESS_N_PER_M * LEG_M * compliance
    )
    warm_k = temperature_k - 293.15
    ohm_m = martensite * MARTENSITE_OHM_M * (1.0 + MARTENSITE_PER_K * warm_k)
    ohm_m += (1.0 - martensite) * AUSTENITE_OHM_M * (1.0 + AUSTENITE_PER_K * warm_k)
    stretch = (1.0 + STROKE * martensite) / (1.0 + STROKE)
    resistance_ohm = ohm_m * LENGTH_M / AREA_M2 * stretch * stretch
    advantage_k = BALANCE_K + stress_pa / STRESS_RATE_PA_PER_K - temperature_k
    to_martensite = JUMPS_PER_S / (1.0 + math.exp(min(-(advantage_k - BARRIER_K) / SHARPNESS_K, 50.0)))
    to_austenite = JUMPS_PER_S / (1.0 + math.exp(min((advantage_k + BARRIER_K) / SHARPNESS_K, 50.0)))
    change = (1.0 - martensite) * to_martensite - martensite * to_austenite
    current_a = drive_voltage_v / (resistance_ohm + SERIES_OHM)
    power_w = current_a * current_a * resistance_ohm - LOSS_W_PER_K * (temperature_k - AMBIENT_K) + LATENT_J * change
    return power_w / CAPACITY_J_PER_K, change


def scipy_cycle(sample_s: float) -> Any:
    """Solve one cycle of the slow sine in one call, the state wanted at every sample; return SciPy's solution."""
    from scipy.integrate import solve_ivp

    wanted = [sample * sample_s for sample in range(round(PERIOD_S / sample_s) + 1)]
    return solve_ivp(
        lambda time_s, state: rates(state[0], state[1], drive_v(time_s)),
        (0.0, PERIOD_S),
        START,
        t_eval=wanted,
        **TOLERANCES,
    )


class ScipyLoop:
    """The wire under a drive that a program chooses for every period: one call of SciPy's each."""

    def __init__(self, period_s: float) -> None:
        """Start cold."""
        self._period_s = period_s
        self.state: tuple[float, float] = START

    def advance(self, drive_voltage_v: float) -> None:
        """Advance by one period at a drive voltage."""
        from scipy.integrate import solve_ivp

        found = solve_ivp(
            lambda _, state, voltage_v: rates(state[0], state[1], voltage_v),
            (0.0, self._period_s), self.state, args=(drive_voltage_v,), **TOLERANCES,
        )  # fmt: skip
        self.state = (float(found.y[0, -1]), float(found.y[1, -1]))
