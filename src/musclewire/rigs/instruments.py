"""What the instruments of a simulated rig make of the truth: noise, steps, ranges."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from musclewire.arrays import FloatArray

__all__ = ["Instruments"]


class Instruments:
    """Converter, displacement sensor, load cells and laser of a bench, repeatable for one seed."""

    def __init__(self, bench: Mapping[str, float], seed: int) -> None:
        """Take noise, steps and ranges from the bench's numbers."""
        self._bench = bench
        self._random = np.random.default_rng(seed)
        self._voltage_step_v = 2.0 * bench["acquisition_range_v"] / 2.0 ** bench["acquisition_bits"]

    def voltages_v(self, *voltages_v: float) -> tuple[float, ...]:
        """Return what a converter with noise, steps and a range makes of voltages, averaged over its readings."""
        readings = int(self._bench["acquisition_readings"])
        noise: FloatArray = self._random.standard_normal((len(voltages_v), readings))
        noisy = np.asarray(voltages_v)[:, None] + self._bench["acquisition_noise_v"] * noise
        stepped = np.round(noisy / self._voltage_step_v) * self._voltage_step_v
        limit = self._bench["acquisition_range_v"]
        return tuple(float(value) for value in np.clip(stepped, -limit, limit).mean(axis=1))

    def connector(self, displacement_m: float, force_n: float) -> tuple[float, float]:
        """Return readings of displacement and force at the connector."""
        displacement_noise, force_noise = self._random.standard_normal(2)
        return (
            displacement_m + self._bench["displacement_noise_m"] * displacement_noise,
            force_n + self._bench["force_noise_n"] * force_noise,
        )

    def endpoint(self, displacement_m: float, force_n: float) -> tuple[float, float]:
        """Return readings of displacement and force at a finger's endpoint."""
        displacement_noise, force_noise = self._random.standard_normal(2)
        return (
            displacement_m + self._bench["endpoint_noise_m"] * displacement_noise,
            force_n + self._bench["endpoint_force_noise_n"] * force_noise,
        )
