"""Wires drawn from the prior, and recordings of them with noise: what a calibration is to find again.

No number of a file that a fit may move is relied on: the truth is drawn here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache

import numpy as np
from numpy.typing import NDArray

from musclewire.extras.calibration import CandidateParameters, WireValues
from musclewire.identify import IsobaricLoop
from musclewire.parameters import load_alloy, load_bench, load_priors, load_wire
from musclewire.signals import Recording
from musclewire.wire import constants_of, drive_path, isobaric_path

Array = NDArray[np.float64]

BENCH = {
    "wire_length_m": 0.14,
    "legs": 2.0,
    "pretension_n": 1.9,
    "spring_stiffness_n_per_m": 588.6,
    "shunt_resistance_ohm": 1.0,
    "ambient_temperature_k": 295.15,
}
NOISE = {"voltage": 2e-4, "displacement": 2e-6, "force": 4e-3, "temperature": 0.2, "strain": 2e-5}
PERIOD_S = 0.05


@cache
def candidates() -> CandidateParameters:
    """All that has a prior, on the paper's wire and bench."""
    wire = load_wire("paper-100um")
    return CandidateParameters(load_priors(), load_alloy(wire.alloy), wire, load_bench("paper"))


def true_wire(seed: int = 1, spread: float = 0.5) -> tuple[WireValues, Array]:
    """A wire not too far from the prior's mean, and where it lies in prior deviations."""
    coordinates = spread * candidates().draw(np.random.default_rng(seed))
    return candidates().wire_values(coordinates), coordinates


def slow_sine(highest_v: float = 3.2, duration_s: float = 12.0) -> Array:
    phase = np.linspace(0.0, 2.0 * np.pi, int(duration_s / PERIOD_S))
    return np.asarray(0.1 + (highest_v - 0.1) * 0.5 * (1.0 - np.cos(phase)))


def driven(
    values: WireValues, drive: Array, seed: int = 1, keep: Iterable[str] = (), bench: Mapping[str, float] | None = None
) -> Recording:
    """A recording of a wire through a drive; ``keep`` adds force_n, displacement_m or wire_temperature_k."""
    random = np.random.default_rng(seed)
    around = {**BENCH, **(bench or {})}
    constants = constants_of(values.alloy, values.wire, {**values.bench, **around})
    path, _ = drive_path(constants, drive, sample_s=PERIOD_S)
    columns = {
        "wire_voltage_v": path.wire_voltage_v + NOISE["voltage"] * random.standard_normal(drive.size),
        "shunt_voltage_v": path.shunt_voltage_v + NOISE["voltage"] * random.standard_normal(drive.size),
        "displacement_m": path.displacement_m + NOISE["displacement"] * random.standard_normal(drive.size),
        "force_n": path.force_n + NOISE["force"] * random.standard_normal(drive.size),
        "wire_temperature_k": path.temperature_k + NOISE["temperature"] * random.standard_normal(drive.size),
    }
    chosen = ("wire_voltage_v", "shunt_voltage_v", "displacement_m", *keep)
    return Recording(
        {
            "time_s": PERIOD_S * np.arange(1, drive.size + 1),
            "drive_voltage_v": drive,
            **{name: columns[name] for name in chosen},
        },
        {**around, "wire_diameter_m": values.wire["diameter_m"], "sample_period_s": PERIOD_S},
    )


def isobars(values: WireValues, stresses_pa: Iterable[float] = (50e6, 100e6, 200e6), seed: int = 2) -> Recording:
    """Isobars as one table, strain positive in elongation from an arbitrary zero."""
    random = np.random.default_rng(seed)
    constants = constants_of(values.alloy, values.wire, values.bench)
    parts: list[IsobaricLoop] = []
    for stress in stresses_pa:
        up = np.linspace(295.0, constants.martensite_temperature_k + stress / 8e6 + 60.0, 120)
        kelvin = np.concatenate([up, up[-2::-1]])
        strain = isobaric_path(constants, stress, kelvin).strain
        parts.append(
            IsobaricLoop(stress, kelvin, 0.004 + strain + NOISE["strain"] * random.standard_normal(strain.size))
        )
    return Recording(
        {
            "wire_temperature_k": np.concatenate([item.temperature_k for item in parts]),
            "reference_strain": np.concatenate([item.strain for item in parts]),
            "stress_pa": np.concatenate([np.full(item.strain.size, item.stress_pa) for item in parts]),
        }
    )


def cooling(values: WireValues, seed: int = 3, samples: int = 400, period_s: float = 0.02) -> Recording:
    """A cooling curve of a wire that a current heated before, from the moment it is off: temperature, displacement."""
    random = np.random.default_rng(seed)
    constants = constants_of(values.alloy, values.wire, {**values.bench, **BENCH})
    _, hot = drive_path(constants, np.full(400, 3.2), sample_s=0.02)
    path, _ = drive_path(constants, np.zeros(samples - 1), sample_s=period_s, state=hot)
    temperature = np.concatenate([[hot.temperature_k], path.temperature_k])
    displacement = np.concatenate([[hot.contraction * constants.leg_length_m], path.displacement_m])
    return Recording(
        {
            "time_s": period_s * np.arange(samples),
            "wire_temperature_k": temperature + NOISE["temperature"] * random.standard_normal(samples),
            "displacement_m": displacement + NOISE["displacement"] * random.standard_normal(samples),
        },
        {**BENCH, "wire_diameter_m": values.wire["diameter_m"]},
    )
