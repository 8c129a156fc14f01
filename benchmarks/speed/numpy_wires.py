"""Many easier wires at once in NumPy: what one writes who has many wires and no compiler."""

from __future__ import annotations

import numpy as np
from benchmarks.speed import easier_wire as wire
from benchmarks.speed.compiled_wires import EXPLICIT_STEP_S

from musclewire.arrays import FloatArray

__all__ = ["numpy_batch", "numpy_rates"]


def numpy_rates(
    temperature_k: FloatArray, martensite: FloatArray, drive_voltage_v: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the rates of temperature [K/s] and martensite [1/s], each (n_wires,), as ``easier_wire.rates`` of each."""
    compliance = martensite / wire.MARTENSITE_PA + (1.0 - martensite) / wire.AUSTENITE_PA
    stress_pa = (
        wire.PRETENSION_N + wire.STIFFNESS_N_PER_M * wire.LEG_M * (wire.COLD_STRAIN - wire.STROKE * martensite)
    ) / (wire.LEGS * wire.AREA_M2 + wire.STIFFNESS_N_PER_M * wire.LEG_M * compliance)
    warm_k = temperature_k - 293.15
    ohm_m = martensite * wire.MARTENSITE_OHM_M * (1.0 + wire.MARTENSITE_PER_K * warm_k)
    ohm_m += (1.0 - martensite) * wire.AUSTENITE_OHM_M * (1.0 + wire.AUSTENITE_PER_K * warm_k)
    stretch = (1.0 + wire.STROKE * martensite) / (1.0 + wire.STROKE)
    resistance_ohm = ohm_m * (wire.LENGTH_M / wire.AREA_M2) * stretch * stretch
    advantage_k = wire.BALANCE_K + stress_pa / wire.STRESS_RATE_PA_PER_K - temperature_k
    overcome = np.minimum((wire.BARRIER_K - advantage_k) / wire.SHARPNESS_K, 50.0)
    to_martensite = wire.JUMPS_PER_S / (1.0 + np.exp(overcome))
    to_austenite = wire.JUMPS_PER_S / (
        1.0 + np.exp(np.minimum((advantage_k + wire.BARRIER_K) / wire.SHARPNESS_K, 50.0))
    )
    change = (1.0 - martensite) * to_martensite - martensite * to_austenite
    current_a = drive_voltage_v / (resistance_ohm + wire.SERIES_OHM)
    power_w = current_a * current_a * resistance_ohm - wire.LOSS_W_PER_K * (temperature_k - wire.AMBIENT_K)
    return (power_w + wire.LATENT_J * change) / wire.CAPACITY_J_PER_K, change


def numpy_batch(temperature_k: FloatArray, martensite: FloatArray, drive_v: FloatArray, steps: int) -> None:
    """Advance many wires in place, each (n_wires,), at their drives by explicit steps, all wires in each step."""
    for _ in range(steps):
        warming, change = numpy_rates(temperature_k, martensite, drive_v)
        temperature_k += warming * EXPLICIT_STEP_S
        martensite += change * EXPLICIT_STEP_S
