"""Wires for tests: alloys of round numbers, so that no test rests on a value that a fit may move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from musclewire.parameters import Alloy, Bench, Wire, load_alloy, load_bench, load_wire
from musclewire.simulate.stepping import fixed_steps
from musclewire.simulate.wires import WireMeans, advance
from musclewire.wire.building import constants_from
from musclewire.wire.constants import WireConstants
from musclewire.wire.loads import ConnectorLoad
from musclewire.wire.state import WireState

Array = NDArray[np.float64]

# Every number that a fit may move, rounded. In "narrow" all grains turn to R-phase at once, in "broad" over a wide
# range; in "late" R-phase and martensite are harder to reach from each other than by way of austenite.
ROUND = {
    "martensite_temperature_k": 342.0,
    "martensite_stress_rate_pa_per_k": 8e6,
    "martensite_barrier_k": 10.0,
    "martensite_barrier_per_pa": -2e-8,
    "martensite_spread_k": 11.0,
    "martensite_spread_per_pa": 1e-8,
    "grain_skew": -0.2,
    "grain_tail": 1.0,
    "r_phase_temperature_k": 350.0,
    "r_phase_stress_rate_pa_per_k": 30e6,
    "r_phase_spread_k": 8.0,
    "r_phase_entropy_ratio": 0.2,
    "r_phase_barrier_k": 0.5,
    "r_to_m_barrier_k": 7.0,
    "strain_at_no_stress": 0.04,
    "strain_saturated": 0.042,
    "strain_stress_scale_pa": 150e6,
    "r_phase_strain": 0.005,
    "austenite_modulus_pa": 60e9,
    "martensite_modulus_pa": 30e9,
    "austenite_resistivity_ohm_m": 0.86e-6,
    "austenite_resistivity_per_k": 2e-4,
    "r_phase_resistivity_ohm_m": 1.0e-6,
    "r_phase_resistivity_per_k": -5e-4,
    "martensite_resistivity_ohm_m": 0.95e-6,
    "martensite_resistivity_per_k": 6e-4,
    "specific_heat_j_per_kg_k": 500.0,
    "latent_heat_j_per_kg": 20e3,
}
ALLOYS: dict[str, dict[str, float]] = {
    "round": {},
    "narrow": {"r_phase_spread_k": 0.5, "r_phase_temperature_k": 345.0, "r_phase_entropy_ratio": 0.3},
    "broad": {
        "r_phase_temperature_k": 348.0,
        "r_phase_entropy_ratio": 0.5,
        "martensite_barrier_k": 16.0,
        "r_phase_barrier_k": 1.5,
        "r_to_m_barrier_k": 11.0,
    },
    "late": {"r_to_m_barrier_k": 25.0, "r_phase_temperature_k": 360.0},
}


def changed(group: Alloy | Wire | Bench, **values: float):
    """Return the group with other numbers."""
    return group.model_copy(
        update={key: getattr(group, key).model_copy(update={"value": value}) for key, value in values.items()}
    )


def alloy(kind: str = "round", **values: float) -> Alloy:
    return changed(load_alloy("flexinol"), **{**ROUND, **ALLOYS[kind], **values})


def bench(**values: float) -> Bench:
    return changed(load_bench("paper"), **{"guide_friction_n": 0.03, **values})


def wire_100um() -> Wire:
    return changed(load_wire("paper-100um"), convection_factor=0.9, resistivity_factor=1.0)


def constants(
    kind: str = "round",
    *,
    new_wire: bool = False,
    bench_values: dict[str, float] | None = None,
    load: ConnectorLoad | None = None,
    **alloy_values: float,
) -> WireConstants:
    around = bench(**(bench_values or {}))
    return constants_from(alloy(kind, **alloy_values), wire_100um(), around, load=load, new_wire=new_wire)


def slow_sine_v(time_s: float, amplitude_v: float = 3.2, period_s: float = 90.0) -> float:
    """Return the drive from the sense voltage up to the amplitude and back."""
    return 0.3 + (amplitude_v - 0.3) * 0.5 * (1.0 - float(np.cos(2.0 * np.pi * time_s / period_s)))


def run(
    state: WireState,
    wire: WireConstants,
    voltages_v: list[float] | Array,
    *,
    dt_s: float = 1e-3,
    hold_s: float = 0.05,
) -> tuple[list[WireState], list[WireMeans]]:
    """Hold each voltage for a while; return the state and the means after each."""
    states, means = [], []
    for voltage in voltages_v:
        state, mean = advance(state, wire, float(voltage), hold_s, fixed_steps(dt_s))
        states.append(state)
        means.append(mean)
    return states, means
