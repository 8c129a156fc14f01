"""What the search may move, within which bounds, and what it pulls towards."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from musclewire.parameters import Alloy, Bench, Wire, load_alloy, load_bench, load_wire

FloatArray = NDArray[np.float64]
Group = TypeVar("Group", Alloy, Wire, Bench)
SPOOLS = ("100um", "125um", "200um", "finger")
FILES = {"100um": "paper-100um", "125um": "paper-125um", "200um": "paper-200um", "finger": "finger-100um"}

# name: low, high. Alloy parameters by their own names, within what is published (parameters/data/published/ranges.toml)
# where anything is, else within what the equations allow; what follows belongs to spools and benches.
BOUNDS: dict[str, tuple[float, float]] = {
    "martensite_temperature_k": (320.15, 345.0),
    "martensite_stress_rate_pa_per_k": (7e6, 9.3e6),
    "martensite_barrier_k": (9.6, 17.5),
    "martensite_barrier_per_pa": (-3e-8, 2e-8),
    "martensite_spread_k": (3.0, 16.0),
    "martensite_spread_per_pa": (0.0, 5e-8),
    "grain_skew": (-0.6, 0.6),
    "grain_tail": (0.0, 1.5),
    "early_fraction": (0.02, 0.4),
    "early_width": (0.3, 8.0),
    # Published: 293 to 313 K. --r-phase published holds it there; docs/explanation/parameters.md says what that costs.
    "r_phase_temperature_k": (293.15, 345.0),
    "r_phase_stress_rate_pa_per_k": (15e6, 30e6),
    "r_phase_spread_k": (0.5, 25.0),
    "r_phase_entropy_ratio": (0.1, 0.4),
    "r_phase_hysteresis_k": (1.0, 5.0),
    "r_to_m_barrier_k": (1.0, 30.0),
    "strain_at_no_stress": (0.025, 0.046),
    "strain_saturated": (0.041, 0.046),
    "strain_stress_scale_pa": (2e7, 4e8),
    "r_phase_strain": (0.002, 0.005),
    "austenite_modulus_pa": (35e9, 83e9),
    "martensite_modulus_pa": (20.5e9, 45e9),
    "martensite_expansion_per_k": (-10.8e-6, 9.7e-6),
    "austenite_resistivity_ohm_m": (0.82e-6, 1.00e-6),
    "austenite_resistivity_per_k": (0.0, 2e-4),
    "r_phase_resistivity_ohm_m": (0.9e-6, 1.3e-6),
    "r_phase_resistivity_per_k": (-1.5e-3, 1e-3),
    "martensite_resistivity_ohm_m": (0.87e-6, 1.06e-6),
    "martensite_resistivity_per_k": (2e-4, 1.2e-3),
    "specific_heat_j_per_kg_k": (447.0, 837.0),
    "latent_heat_j_per_kg": (12e3, 24.2e3),
    "convection_factor": (0.75, 1.4),
    "guide_friction_n": (0.0, 0.08),
    "amplitude_125um_v": (2.3, 3.3),
    "amplitude_200um_v": (1.8, 3.3),
    "amplitude_finger_v": (1.65, 2.0),
    "isobar_sample_shift_k": (0.0, 24.0),
    # Each transformation temperature of a spool lies within 5 K of its alloy's.
    **{f"temperature_shift_{spool}_k": (-5.0, 5.0) for spool in SPOOLS},
    **{f"r_phase_temperature_shift_{spool}_k": (-5.0, 5.0) for spool in SPOOLS},
}
PUBLISHED_R_PHASE_K = (293.15, 313.15)
# name: centre, deviation, weak: what the literature says where the targets leave a choice.
PULL = {
    "r_phase_temperature_k": (311.0, 8.0),
    "convection_factor": (1.0, 0.25),
    "r_phase_strain": (0.0035, 0.001),
    "austenite_resistivity_per_k": (2e-4, 2e-4),
    "martensite_resistivity_per_k": (4e-4, 3e-4),
    "r_phase_resistivity_per_k": (0.0, 6e-4),
    "amplitude_finger_v": (1.75, 0.1),
    **{f"temperature_shift_{spool}_k": (0.0, 3.0) for spool in SPOOLS},
    **{f"r_phase_temperature_shift_{spool}_k": (0.0, 4.0) for spool in SPOOLS},
}
NAMES = tuple(BOUNDS)


def limits(bounds: Mapping[str, tuple[float, float]] = BOUNDS) -> tuple[FloatArray, FloatArray]:
    """Return the lower and the upper bounds, each (n,), in the order of ``NAMES``."""
    return np.array([bounds[name][0] for name in NAMES]), np.array([bounds[name][1] for name in NAMES])


@dataclass(frozen=True)
class PaperWires:
    """One alloy, the paper's four spools, the isobars' sample and both benches, as a vector stands for them."""

    numbers: dict[str, float]
    alloy: Alloy
    wires: dict[str, Wire]
    isobar_sample: Wire
    bench: Bench
    finger_bench: Bench

    def amplitude_v(self, spool: str) -> float:
        """Return the amplitude of the slow sine for a spool; 3.2 V is printed for 100 um."""
        return 3.2 if spool == "100um" else self.numbers[f"amplitude_{spool}_v"]


def changed(group: Group, **numbers: float) -> Group:
    """Return an alloy, wire or bench with some numbers replaced."""
    fields = {name: getattr(group, name).model_copy(update={"value": float(value)}) for name, value in numbers.items()}
    return group.model_copy(update=fields)


def alloy_numbers(numbers: Mapping[str, float]) -> dict[str, float]:
    """Return the alloy's own numbers of a vector; the barrier of the R-phase follows from its hysteresis."""
    own = {name: numbers[name] for name in NAMES if name in Alloy.model_fields}
    barrier = 0.5 * numbers["r_phase_entropy_ratio"] * numbers["r_phase_hysteresis_k"]
    return {**own, "r_phase_barrier_k": barrier}


def spool_numbers(numbers: Mapping[str, float], spool: str) -> dict[str, float]:
    """Return what a vector says of a spool's wire file."""
    shift = numbers[f"temperature_shift_{spool}_k"]
    return {
        "convection_factor": numbers["convection_factor"],
        "temperature_shift_k": shift,
        "r_phase_shift_k": numbers[f"r_phase_temperature_shift_{spool}_k"] - shift,
        "martensite_barrier_shift_k": 0.0,
    }


def paper_wires(vector: FloatArray) -> PaperWires:
    """Return what a vector, (n,) in SI in the order of ``NAMES``, stands for."""
    numbers = dict(zip(NAMES, (float(value) for value in vector), strict=True))
    spools = {spool: changed(load_wire(FILES[spool]), **spool_numbers(numbers, spool)) for spool in SPOOLS}
    sample = changed(load_wire("isobar-sample"), temperature_shift_k=numbers["isobar_sample_shift_k"])
    bench = changed(load_bench("paper"), guide_friction_n=numbers["guide_friction_n"])
    alloy = changed(load_alloy("flexinol"), **alloy_numbers(numbers))
    return PaperWires(numbers, alloy, spools, sample, bench, load_bench("finger"))


def shipped_vector() -> FloatArray:
    """Return the vector of the parameter files as they are."""
    alloy, bench = load_alloy("flexinol").values(), load_bench("paper").values()
    spools = {spool: load_wire(FILES[spool]).values() for spool in SPOOLS}
    known = {
        **alloy,
        "r_phase_hysteresis_k": 2.0 * alloy["r_phase_barrier_k"] / alloy["r_phase_entropy_ratio"],
        "convection_factor": spools["100um"]["convection_factor"],
        "guide_friction_n": bench["guide_friction_n"],
        "isobar_sample_shift_k": load_wire("isobar-sample").temperature_shift_k.value,
    }
    for spool, values in spools.items():
        shift = values["temperature_shift_k"]
        known |= {
            f"amplitude_{spool}_v": values["drive_amplitude_v"],
            f"temperature_shift_{spool}_k": shift,
            f"r_phase_temperature_shift_{spool}_k": shift + values["r_phase_shift_k"],
        }
    return np.array([known[name] for name in NAMES])
