"""Wires for tests: alloys of round numbers, so that no test rests on a value that a fit may move.

The one place that knows how the kernel's fronts are called without a wire around them.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from musclewire.compiled import compiled
from musclewire.parameters import Alloy, Bench, Wire, load_alloy, load_bench, load_wire
from musclewire.physics import REFERENCE_TEMPERATURE_K
from musclewire.wire import (
    ConnectorLoad,
    DrivenPath,
    WireConstants,
    WireMeans,
    WireState,
    advance,
    constants_from,
    drive_path,
    fixed_steps,
)
from musclewire.wire._fronts import cumulative_at, fronts_after

Array = NDArray[np.float64]

# Every number that a fit may move, rounded. In "narrow" all grains turn to R-phase at once, in "broad" over a wide
# range; in "early" a fifth of the grains transform before the others; in "late" R-phase and martensite are harder to
# reach from each other than by way of austenite.
ROUND = {
    "martensite_temperature_k": 342.0,
    "martensite_stress_rate_pa_per_k": 8e6,
    "martensite_barrier_k": 10.0,
    "martensite_barrier_per_pa": -2e-8,
    "martensite_spread_k": 11.0,
    "martensite_spread_per_pa": 1e-8,
    "grain_skew": -0.2,
    "grain_tail": 1.0,
    "early_fraction": 0.0,
    "early_width": 1.0,
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
    "austenite_expansion_per_k": 11e-6,
    "martensite_expansion_per_k": 6.6e-6,
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
    "early": {"early_fraction": 0.2, "early_width": 3.0, "grain_tail": 0.5},
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
    """Return the wire of 100 um at the alloy's own temperatures: a spool's shifts are numbers that a fit moves."""
    spool = {"temperature_shift_k": 0.0, "r_phase_shift_k": 0.0, "martensite_barrier_shift_k": 0.0}
    return changed(load_wire("paper-100um"), convection_factor=0.9, resistivity_factor=1.0, **spool)


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


class Fronts(NamedTuple):
    """Two fronts in units of the spread: austenite lies below the first, martensite above the second."""

    austenite: float
    martensite: float


ALL_AUSTENITE = Fronts(math.inf, math.inf)


class Fractions(NamedTuple):
    """Volume fractions."""

    martensite: float
    r_phase: float


@compiled
def trace_fronts(
    constants: np.ndarray, tables: np.ndarray, temperature_k: Array, stress_pa: Array, start: tuple[float, float]
) -> Array:
    """Return both fronts and the fractions of martensite and R-phase along a walk, (4, n_points)."""
    k, cells = constants[0], tables[0]
    shown = np.empty((4, temperature_k.shape[0]))
    f, m = start
    for point in range(temperature_k.shape[0]):
        after = fronts_after(k, temperature_k[point], stress_pa[point], 1.0, k.class_barrier_k[0], (f, m))
        f, m = after.austenite, after.martensite
        below_f, _ = cumulative_at(k, cells, 0, f)
        below_m, _ = cumulative_at(k, cells, 0, m)
        shown[0, point], shown[1, point], shown[2, point], shown[3, point] = f, m, 1.0 - below_m, below_m - below_f
    return shown


def fronts_along(wire: WireConstants, temperature_k: object, stress_pa: object, start: Fronts = ALL_AUSTENITE) -> Array:
    """Return both fronts and both fractions of a wire of one class of barrier along a walk, (4, n_points)."""
    kelvin, pascal = np.broadcast_arrays(np.asarray(temperature_k, float), np.asarray(stress_pa, float))
    return trace_fronts(
        *wire.step_arrays()[:2],
        np.ascontiguousarray(kelvin).reshape(-1),
        np.ascontiguousarray(pascal).reshape(-1),
        (float(start.austenite), float(start.martensite)),
    )


def fronts_at(wire: WireConstants, temperature_k: float, stress_pa: float, start: Fronts = ALL_AUSTENITE) -> Fronts:
    """Return the fronts after one temperature and stress."""
    return Fronts(*fronts_along(wire, [temperature_k], [stress_pa], start)[:2, -1].tolist())


def fractions(wire: WireConstants, fronts: Fronts) -> Fractions:
    """Return the fractions between fronts."""
    constants, tables, _ = wire.step_arrays()
    below = [float(cumulative_at(constants[0], tables[0], 0, front)[0]) for front in fronts]
    return Fractions(1.0 - below[1], below[1] - below[0])


def walk(
    wire: WireConstants, start: Fronts, stress_pa: float, *turning_points_k: float, step_k: float = 0.125
) -> list[Fronts]:
    """Take fronts from temperature to temperature at constant stress; return those at each turning point.

    All walks step on one grid of temperatures (0.125 K is exact in binary), so that two passes over a stretch
    see the same temperatures and must do the same to the bit.
    """
    visited = [start]
    for before, end in pairwise(turning_points_k):
        steps = round((end - before) / step_k)
        way = before + np.sign(steps) * np.arange(1, abs(steps) + 1) * step_k
        shown = fronts_along(wire, way, stress_pa, visited[-1])
        visited.append(Fronts(*shown[:2, -1].tolist()) if way.size else visited[-1])
    return visited


def stored_heat_j(state: WireState, wire: WireConstants) -> float:
    """Return m c (T - T_ref) - m L (x_M + r x_R), from the fractions."""
    transformed = state.martensite_fraction + wire.r_phase_entropy_ratio * state.r_phase_fraction
    warmth_j = wire.heat_capacity_j_per_k * (state.temperature_k - REFERENCE_TEMPERATURE_K)
    return warmth_j - wire.latent_heat_j * transformed


def load_n(load: ConnectorLoad, displacement_m: float) -> float:
    """Return what a load asks beyond the pretension, from its table by NumPy."""
    at = load.step_m * np.arange(load.force_n.size)
    return load.stiffness_n_per_m * displacement_m + float(np.interp(displacement_m, at, load.force_n))


def balanced_stress_pa(state: WireState, wire: WireConstants, load: ConnectorLoad, friction_n: float) -> float:
    """Solve strain and balance, both written out, for the stress of one leg."""
    x_m, x_r = state.martensite_fraction, state.r_phase_fraction

    def excess_pa(stress: float) -> float:
        reoriented = wire.strain_saturated + (wire.strain_at_no_stress - wire.strain_saturated) * np.exp(
            -stress / wire.strain_stress_scale_pa
        )
        elastic = stress * ((1 - x_m) / wire.austenite_modulus_pa + x_m / wire.martensite_modulus_pa)
        alpha = x_m * wire.martensite_expansion_per_k + (1 - x_m) * wire.austenite_expansion_per_k
        strain = reoriented * x_m + wire.r_phase_strain * x_r + elastic + alpha * (state.temperature_k - 293.15)
        x = (wire.cold_strain - strain) / (1 + wire.cold_strain) * wire.leg_length_m
        return stress - (wire.pretension_n + load_n(load, x) + friction_n) / (wire.legs * wire.area_m2)

    return float(brentq(excess_pa, 0.0, 5e9, xtol=1e-3))


def slow_sine_v(time_s: float, amplitude_v: float = 3.2, period_s: float = 90.0) -> float:
    """Return the drive from the sense voltage up to the amplitude and back."""
    return 0.3 + (amplitude_v - 0.3) * 0.5 * (1.0 - float(np.cos(2.0 * np.pi * time_s / period_s)))


def stepped(
    state: WireState, wire: WireConstants, drive_voltage_v: float, step_s: float, steps: int
) -> tuple[WireState, WireMeans]:
    """Return a wire after so many steps of one length, and the means over them."""
    return advance(state, wire, float(drive_voltage_v), step_s * steps, fixed_steps(step_s))


def driven(
    wire: WireConstants, drive: Array, step_s: float, steps: int, *, state: WireState | None = None
) -> tuple[DrivenPath, WireState]:
    """Return a wire along a drive in steps of one length, so many a sample."""
    return drive_path(wire, drive, sample_s=step_s * steps, stepping=fixed_steps(step_s), state=state)


def run(
    state: WireState,
    wire: WireConstants,
    voltages_v: list[float] | Array,
    *,
    step_s: float = 1e-3,
    hold_s: float = 0.05,
) -> tuple[list[WireState], list[WireMeans]]:
    """Hold each voltage for a while; return the state and the means after each."""
    states, means = [], []
    for voltage in voltages_v:
        state, mean = stepped(state, wire, voltage, step_s, round(hold_s / step_s))
        states.append(state)
        means.append(mean)
    return states, means
