"""What the search may move, within which bounds, and what it pulls towards."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.parameters.parameter_groups import Alloy, Bench, Wire

FloatArray = NDArray[np.float64]
DIAMETERS_UM = (100, 125, 200)

# name: low, high. Alloy parameters by their own names; what follows belongs to spools and rig.
BOUNDS = {
    "martensite_temperature_k": (318.0, 355.0),
    "martensite_stress_rate_pa_per_k": (6e6, 10e6),
    "martensite_barrier_k": (5.0, 16.0),
    "martensite_barrier_per_pa": (-3e-8, 1e-8),
    "martensite_spread_k": (4.0, 16.0),
    "martensite_spread_per_pa": (0.0, 5e-8),
    "grain_skew": (-0.45, 0.45),
    "grain_tail": (0.1, 1.3),
    "r_phase_temperature_k": (300.0, 362.0),
    "r_phase_stress_rate_pa_per_k": (15e6, 30e6),
    "r_phase_spread_k": (0.5, 25.0),
    "r_phase_entropy_ratio": (0.08, 0.5),
    "r_phase_barrier_k": (0.03, 3.0),
    "r_to_m_barrier_k": (2.0, 30.0),
    "strain_at_no_stress": (0.025, 0.05),
    "strain_saturated": (0.036, 0.055),
    "strain_stress_scale_pa": (2e7, 4e8),
    "r_phase_strain": (0.002, 0.006),
    "austenite_modulus_pa": (40e9, 83e9),
    "martensite_modulus_pa": (20e9, 40e9),
    "austenite_resistivity_ohm_m": (0.80e-6, 0.97e-6),
    "austenite_resistivity_per_k": (2e-5, 6e-4),
    "r_phase_resistivity_ohm_m": (0.9e-6, 1.15e-6),
    "r_phase_resistivity_per_k": (-1.5e-3, 5e-4),
    "martensite_resistivity_ohm_m": (0.87e-6, 1.06e-6),
    "martensite_resistivity_per_k": (2e-4, 9e-4),
    "specific_heat_j_per_kg_k": (450.0, 610.0),
    "latent_heat_j_per_kg": (12e3, 18e3),
    "convection_factor": (0.86, 1.2),
    "guide_friction_n": (0.0, 0.06),
    "amplitude_125um_v": (2.3, 3.1),
    "amplitude_200um_v": (2.0, 2.9),
    "isobar_sample_shift_k": (-5.0, 28.0),
    "r_phase_shift_125_200um_k": (-8.0, 22.0),
}
# name: centre, deviation, weak: what the literature says where the targets leave a choice.
PULL = {
    # Above what is usual in binary NiTi (293 to 313 K): R-phase matters on cooling only where it comes before
    # martensite, which starts near 325 K in 70 C wire (vendor).
    "r_phase_temperature_k": (335.0, 12.0),
    "convection_factor": (1.0, 0.2),
    "r_phase_strain": (0.004, 0.001),
    "isobar_sample_shift_k": (10.0, 10.0),
    "r_phase_shift_125_200um_k": (0.0, 8.0),
}
NAMES = tuple(BOUNDS)
LOW = np.array([low for low, _ in BOUNDS.values()])
HIGH = np.array([high for _, high in BOUNDS.values()])


@dataclass(frozen=True)
class PaperWires:
    """One alloy, the paper's three spools, the isobars' sample and the bench, as a vector stands for them."""

    numbers: dict[str, float]
    alloy: Alloy
    wires: dict[int, Wire]
    isobar_sample: Wire
    bench: Bench

    def amplitude_v(self, diameter_um: int) -> float:
        """Return the amplitude of the slow sine for a spool; 3.2 V is printed for 100 um."""
        return 3.2 if diameter_um == 100 else self.numbers[f"amplitude_{diameter_um}um_v"]


def changed(group: Alloy | Wire | Bench, **numbers: float):
    """Return an alloy, wire or bench with some numbers replaced."""
    fields = {name: getattr(group, name).model_copy(update={"value": float(value)}) for name, value in numbers.items()}
    return group.model_copy(update=fields)


def paper_wires(vector: FloatArray) -> PaperWires:
    """Return what a vector, (n,) in SI in the order of ``NAMES``, stands for."""
    numbers = dict(zip(NAMES, (float(value) for value in vector), strict=True))
    alloy = load_alloy("flexinol")
    own = {name: numbers[name] for name in NAMES if name in type(alloy).model_fields}
    spools = {}
    for diameter in DIAMETERS_UM:
        shift = 0.0 if diameter == 100 else numbers["r_phase_shift_125_200um_k"]
        spool = load_wire(f"paper-{diameter}um")
        spools[diameter] = changed(spool, convection_factor=numbers["convection_factor"], r_phase_shift_k=shift)
    sample = changed(load_wire("isobar-sample"), temperature_shift_k=numbers["isobar_sample_shift_k"])
    bench = changed(load_bench("paper"), guide_friction_n=numbers["guide_friction_n"])
    return PaperWires(numbers, changed(alloy, **own), spools, sample, bench)


def shipped_vector() -> FloatArray:
    """Return the vector of the parameter files as they are."""
    alloy, bench = load_alloy("flexinol").values(), load_bench("paper").values()
    spools = {diameter: load_wire(f"paper-{diameter}um").values() for diameter in DIAMETERS_UM}
    known = {
        **alloy,
        "convection_factor": spools[100]["convection_factor"],
        "guide_friction_n": bench["guide_friction_n"],
        "amplitude_125um_v": spools[125]["drive_amplitude_v"],
        "amplitude_200um_v": spools[200]["drive_amplitude_v"],
        "isobar_sample_shift_k": load_wire("isobar-sample").temperature_shift_k.value,
        "r_phase_shift_125_200um_k": spools[125]["r_phase_shift_k"],
    }
    return np.array([known[name] for name in NAMES])
