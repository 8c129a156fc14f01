"""Every slope that Newton's method takes is a difference quotient, and its step solves the linear equations.

A wrong slope would only cost evaluations in most runs: the solution is checked, not the way to it. Here each function
is taken by itself, on alloys of round numbers; values are held to the published equations, written down again.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from wire_makers import ALLOYS, Array, constants

from musclewire.compiled import compiled
from musclewire.physics import (
    REFERENCE_TEMPERATURE_K,
)
from musclewire.wire import (
    ConnectorForce,
    ConnectorLoad,
    RunningWire,
    ShakedownEffects,
    WireConstants,
    convection_w_per_m2_k,
    load_at,
    loss_w,
    resting_state,
    shakedown_of,
    solve,
    thresholds_at,
)
from musclewire.wire._balance import LoadPoint, balance_at, contraction_of, decay, resistance_at, strain_at
from musclewire.wire._fronts import PhaseFractions, cumulative_at, fronts_after, phases_of_class

WIRES = {kind: constants(kind) for kind in ALLOYS}
kinds = st.sampled_from(sorted(ALLOYS))
temperatures = st.floats(290.0, 420.0)
stresses = st.floats(10e6, 500e6)
factors = st.floats(1.0, 1.4)
fractions = st.floats(0.0, 1.0)
# Steps of the difference quotients: temperature [K], stress [Pa], contraction.
DT_K, DS_PA, DC = 1e-4, 100.0, 1e-8
OVER = ShakedownEffects(1.0, 0.0, 1.0)
NO_PUSH = ConnectorForce(0.0, 0.0, 0.0)


def quotient(function: Callable[[float], float], at: float, step: float) -> float:
    """Return the slope of a function from both sides; leave out places where the sides disagree: kinks."""
    low, middle, high = function(at - step), function(at), function(at + step)
    left, right = (middle - low) / step, (high - middle) / step
    assume(abs(left - right) <= 1e-3 * max(abs(left), abs(right)) + 1e-300)
    return (high - low) / (2.0 * step)


def near(slope: float, scale: float) -> object:
    """What a slope must be, to the accuracy of a quotient of values of this size."""
    return pytest.approx(slope, rel=1e-4, abs=scale)


def differences(kind: str, temperature_k: float, stress_pa: float, factor: float, barrier_k: float) -> list[float]:
    """Return by how much each of the six changes lowers the free energy of a grain of no offset, less its barrier [K].

    Written down from the driving forces of A to M and A to R alone: every other change is one less the other.
    """
    wire = WIRES[kind]
    to_m = wire.martensite_temperature_k + stress_pa / wire.martensite_stress_rate_pa_per_k - temperature_k
    to_r = wire.r_phase_temperature_k + stress_pa / wire.r_phase_stress_rate_pa_per_k - temperature_k
    to_r *= wire.r_phase_entropy_ratio
    direct = max(factor * (wire.martensite_barrier_k + barrier_k + wire.martensite_barrier_per_pa * stress_pa), 0.0)
    between = min(wire.r_to_m_barrier_k, direct + wire.r_phase_barrier_k)
    return [
        to_m - direct, to_r - wire.r_phase_barrier_k, to_m - to_r - between, -to_m - direct,
        -to_r - wire.r_phase_barrier_k, to_r - to_m - between,
    ]  # fmt: skip


@given(kinds, temperatures, st.floats(0.0, 2e9), factors, st.floats(-3.0, 5.0))
def test_a_grain_at_a_threshold_gains_what_its_barrier_takes(
    kind: str, temperature_k: float, stress_pa: float, factor: float, barrier_k: float
) -> None:
    """Offsets widen the driving forces by the spreads: at its threshold the force of each change is 0."""
    wire = WIRES[kind]
    at = thresholds_at(wire.derived.record, temperature_k, stress_pa, factor, barrier_k)
    spread_m = wire.martensite_spread_k + wire.martensite_spread_per_pa * stress_pa
    spread_r = wire.r_phase_entropy_ratio * wire.r_phase_spread_k
    spreads = [spread_m, spread_r, spread_m - spread_r]
    gained = differences(kind, temperature_k, stress_pa, factor, barrier_k)
    for place, (threshold, gain) in enumerate(zip(at[:6], gained, strict=True)):
        # Cooling: grains above the threshold change; heating: those below it.
        order = [0, 1, 2, 0, 1, 2][place]
        sign = 1.0 if place < 3 else -1.0
        assert gain + sign * spreads[order] * threshold == pytest.approx(0.0, abs=1e-9)


@given(kinds, temperatures, stresses, factors, st.floats(-3.0, 5.0))
def test_thresholds_have_the_slopes_that_they_state(
    kind: str, temperature_k: float, stress_pa: float, factor: float, barrier_k: float
) -> None:
    record = WIRES[kind].derived.record

    def threshold(place: int) -> Callable[[float], float]:
        return lambda pascal: float(thresholds_at(record, temperature_k, pascal, factor, barrier_k)[place])

    at = thresholds_at(record, temperature_k, stress_pa, factor, barrier_k)
    per_pa = [at.austenite_martensite_per_pa, at.austenite_r_phase_per_pa, at.r_phase_martensite_per_pa,
              at.martensite_austenite_per_pa, at.austenite_r_phase_per_pa, at.martensite_r_phase_per_pa]  # fmt: skip
    per_k = [at.m_per_k, at.r_per_k, at.p_per_k] * 2
    warmer = thresholds_at(record, temperature_k + 1.0, stress_pa, factor, barrier_k)
    for place in range(6):
        assert warmer[place] - at[place] == pytest.approx(per_k[place], rel=1e-9)
        assert quotient(threshold(place), stress_pa, DS_PA) == near(per_pa[place], 1e-13)


starts = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)).map(lambda pair: (min(pair), max(pair)))


@pytest.mark.parametrize("kind", sorted(ALLOYS))
def test_the_density_of_the_grains_is_the_slope_of_their_fraction(kind: str) -> None:
    k, cells = (part[0] for part in WIRES[kind].step_arrays()[:2])
    # Between the sides of a skewed distribution, at 0, the density jumps.
    for offset in np.concatenate([np.linspace(-6.0, 6.0, 50), [-1e3, 1e3]]).tolist():
        below, density = cumulative_at(k, cells, 0, offset)
        step = 1e-6
        (low, _), (high, _) = (cumulative_at(k, cells, 0, offset + way * step) for way in (-1.0, 1.0))
        assert density == pytest.approx((high - low) / (2.0 * step), rel=1e-5, abs=1e-9)
        assert 0.0 <= low <= below <= high <= 1.0


class Point:
    """A wire of one class at a trial temperature and stress, put together from the functions of the kernel."""

    def __init__(self, wire: WireConstants, start: tuple[float, float], temperature_k: float, stress_pa: float) -> None:
        k, cells, load = (part[0] for part in wire.step_arrays())
        over = ShakedownEffects(1.1, 1e-3, 1.05)
        fronts = fronts_after(k, temperature_k, stress_pa, over.barrier_factor, 0.0, start)
        both = (cumulative_at(k, cells, 0, fronts.martensite), cumulative_at(k, cells, 0, fronts.austenite))
        self.phases: PhaseFractions = phases_of_class(1.0, fronts, *both)
        self.strain = strain_at(k, temperature_k, stress_pa, self.phases.martensite, self.phases.r_phase)
        self.contraction = float(contraction_of(k, over, self.strain))
        self.load: LoadPoint = load_at(k, load, self.contraction, (0.01, 0.0), ConnectorForce(0.1, 30.0, 0.005))
        self.balance = balance_at(k, over, self.phases, self.strain, self.load, (temperature_k, stress_pa, 0.01))


@given(kinds, st.floats(320.0, 400.0), st.floats(50e6, 300e6), starts)
def test_both_balances_have_the_slopes_that_they_state(
    kind: str, temperature_k: float, stress_pa: float, start: tuple[float, float]
) -> None:
    def value(of: Callable[[Point], float], kelvin: float, pascal: float) -> float:
        return float(of(Point(WIRES[kind], start, kelvin, pascal)))

    here = Point(WIRES[kind], start, temperature_k, stress_pa)
    balance, phases = here.balance, here.phases
    for of, per_k, per_pa, scale in (
        (lambda point: point.phases.martensite, phases.martensite_per_k, phases.martensite_per_pa, 1e-8),
        (lambda point: point.phases.r_phase, phases.r_phase_per_k, phases.r_phase_per_pa, 1e-8),
        (lambda point: point.contraction, balance.contraction_per_k, balance.contraction_per_pa, 1e-9),
        (lambda point: point.balance.heat_j, balance.heat_per_k, balance.heat_per_pa, 1e-8),
        (lambda point: point.balance.excess_pa, balance.excess_per_k, balance.excess_per_pa, 1.0),
    ):
        by_k = quotient(lambda kelvin, of=of: value(of, kelvin, stress_pa), temperature_k, 1e-3)
        by_pa = quotient(lambda pascal, of=of: value(of, temperature_k, pascal), stress_pa, 1e3)
        assert by_k == pytest.approx(per_k, rel=1e-3, abs=scale)
        assert by_pa == pytest.approx(per_pa, rel=1e-3, abs=1e-5 * scale)


@given(kinds, st.floats(320.0, 400.0), st.floats(50e6, 300e6), starts)
def test_newtons_step_solves_the_linear_equations(
    kind: str, temperature_k: float, stress_pa: float, start: tuple[float, float]
) -> None:
    balance = Point(WIRES[kind], start, temperature_k, stress_pa).balance
    jacobian = np.array([[balance.heat_per_k, balance.heat_per_pa], [balance.excess_per_k, balance.excess_per_pa]])
    step = np.linalg.solve(jacobian, [-balance.heat_j, -balance.excess_pa])
    assert [balance.rise_k, balance.rise_pa] == pytest.approx(step, rel=1e-9)
    assert balance.per_determinant == pytest.approx(1.0 / np.linalg.det(jacobian), rel=1e-9)


@given(st.floats(0.0, 60.0))
def test_the_decay_is_the_exponential_up_to_its_end(exponent: float) -> None:
    assert float(decay(exponent)) == pytest.approx(math.exp(-min(exponent, 32.0)), rel=1e-12)


@given(kinds, temperatures, stresses, fractions, fractions)
def test_strain_is_that_of_the_published_equations(
    kind: str, temperature_k: float, stress_pa: float, martensite: float, part: float
) -> None:
    wire, r_phase = WIRES[kind], (1.0 - martensite) * part
    k = wire.derived.record
    strain = strain_at(k, temperature_k, stress_pa, martensite, r_phase)
    h_0, h_sat, scale_pa = wire.strain_at_no_stress, wire.strain_saturated, wire.strain_stress_scale_pa
    oriented = h_0 + (h_sat - h_0) * (1.0 - math.exp(-stress_pa / scale_pa))
    assert strain.oriented == pytest.approx(oriented, rel=1e-9)
    assert strain.oriented_per_pa == pytest.approx((h_sat - oriented) / scale_pa, rel=1e-9, abs=1e-24)
    assert strain.transformation == pytest.approx(oriented * martensite + wire.r_phase_strain * r_phase, rel=1e-9)
    in_series = (
        1.0 - martensite
    ) * stress_pa / wire.austenite_modulus_pa + martensite * stress_pa / wire.martensite_modulus_pa
    assert strain.elastic == pytest.approx(in_series, rel=1e-9)
    expansion = (1.0 - martensite) * wire.austenite_expansion_per_k + martensite * wire.martensite_expansion_per_k
    assert strain.thermal == pytest.approx(expansion * (temperature_k - REFERENCE_TEMPERATURE_K), rel=1e-9, abs=1e-15)


@given(kinds, temperatures, stresses, fractions, fractions, st.floats(1.0, 1.2))
def test_resistance_is_that_of_the_published_equations(
    kind: str, temperature_k: float, stress_pa: float, martensite: float, part: float, factor: float
) -> None:
    wire, r_phase = WIRES[kind], (1.0 - martensite) * part
    k = wire.derived.record
    strain = strain_at(k, temperature_k, stress_pa, martensite, r_phase)
    found = resistance_at(k, ShakedownEffects(1.0, 0.0, factor), strain, temperature_k, martensite, r_phase)
    resistivity = sum(
        fraction * times * at_20_degc * (1.0 + per_k * (temperature_k - 293.15))
        for fraction, times, at_20_degc, per_k in (
            (martensite, factor, wire.martensite_resistivity_ohm_m, wire.martensite_resistivity_per_k),
            (r_phase, 1.0, wire.r_phase_resistivity_ohm_m, wire.r_phase_resistivity_per_k),
            (1.0 - martensite - r_phase, 1.0, wire.austenite_resistivity_ohm_m, wire.austenite_resistivity_per_k),
        )
    )
    # Transformation keeps the volume, elastic strain thins by Poisson's ratio, expansion widens as it lengthens.
    stretch, longer, wider = 1.0 + strain.transformation, 1.0 + strain.elastic, 1.0 + strain.thermal
    length_m = wire.austenite_length_m * stretch * longer * wider
    area_m2 = wire.area_m2 / stretch * (1.0 - 0.33 * strain.elastic) ** 2 * wider**2
    assert found == pytest.approx(resistivity * length_m / area_m2, rel=1e-9)


@given(st.floats(200.0, 900.0))
def test_convection_between_the_points_of_its_table_is_on_their_straight_line(temperature_k: float) -> None:
    wire = WIRES["round"]
    k = wire.derived.record
    table = np.asarray(k.convection_w_per_m2_k)
    places = k.convection_start_k + np.arange(table.size) / k.convection_per_k
    found = convection_w_per_m2_k(k, k, temperature_k)
    assert found == pytest.approx(float(np.interp(temperature_k, places, table)), rel=1e-9)
    lost_w = loss_w(k, 100.0, temperature_k)
    assert lost_w == pytest.approx(
        100.0 * wire.convection_factor * wire.surface_m2 * (temperature_k - wire.ambient_temperature_k),
        rel=1e-9,
        abs=1e-12,
    )


TABLE = ConnectorLoad(400.0, 5e-4, np.array([0.2, 0.3, 0.1, 1.5]), np.array([0.0, 0.1, -0.3, 0.4]))
LOADED = {
    "spring": constants(bench_values={"guide_friction_n": 0.2}),
    "table": constants(bench_values={"guide_friction_n": 0.2}, load=TABLE),
}


@pytest.mark.parametrize("name", LOADED)
@given(
    contraction=st.floats(-0.01, 0.06),
    before=st.floats(-0.01, 0.06),
    part=st.floats(-1.0, 1.0),
    push=st.floats(-0.5, 0.5),
)
def test_the_load_is_the_sum_of_its_parts_with_their_slopes(
    name: str, contraction: float, before: float, part: float, push: float
) -> None:
    wire = LOADED[name]
    k, _, load = (item[0] for item in wire.step_arrays())
    pushed = ConnectorForce(push, 25.0, 0.01)
    before_n = 0.2 * part
    at = load_at(k, load, contraction, (before, before_n), pushed)
    moved_m = contraction * wire.leg_length_m
    spring_n = wire.pretension_n + (400.0 if name == "table" else wire.spring_stiffness_n_per_m) * moved_m
    added_n, limit_n = 0.0, 0.2
    if name == "table":
        places = TABLE.step_m * np.arange(4)
        beyond_n = max(moved_m - places[-1], 0.0) * (1.5 - 0.1) / TABLE.step_m
        added_n = float(np.interp(moved_m, places, TABLE.force_n)) + beyond_n
        limit_n = max(0.2 + float(np.interp(moved_m, places, TABLE.friction_n)), 0.0)
    assert at.limit_n == pytest.approx(limit_n, abs=1e-12)
    elastic_n = before_n + limit_n * k.per_presliding * (contraction - before)
    friction_n = min(max(elastic_n, -limit_n), limit_n)
    assert at.friction_n == pytest.approx(friction_n, abs=1e-9)
    force_n = spring_n + added_n + push + 25.0 * (contraction - 0.01) + friction_n
    assert at.force_n == pytest.approx(force_n, abs=1e-9)

    def force(place: float) -> float:
        return float(load_at(k, load, place, (before, before_n), pushed).force_n)

    # With a table the limit of friction changes while the guide still sticks: there the slope is that of sticking.
    if name == "spring" or abs(elastic_n) > limit_n:
        assert quotient(force, contraction, DC) == pytest.approx(at.per_contraction_n, rel=1e-4, abs=1e-3)


@compiled
def solved_at(
    states: np.ndarray, constants: np.ndarray, cells: np.ndarray, load: np.ndarray, given: Array
) -> tuple[float, float, float, float, float, float, float, bool]:
    """Return a wire's equilibrium at an enthalpy, from a guess, with a push; the slopes, and whether it is solved."""
    wire = RunningWire(states[0], constants[0], cells[0], load[0])
    over = shakedown_of(constants[0], 0.0)
    found = solve(wire, over, given[0], (given[1], given[2]), ConnectorForce(given[3], 0.0, 0.0))
    return (
        found.wire.temperature_k, found.wire.stress_pa, found.wire.contraction, found.temperature_slope_k_per_j,
        found.stress_slope_pa_per_j, found.contraction_slope_per_j, found.stress_per_contraction_pa, found.solved,
    )  # fmt: skip


@given(kinds, st.floats(0.05, 0.6), st.floats(-0.05, 0.05))
def test_a_solution_has_the_slopes_over_heat_and_push_that_it_states(kind: str, heat_j: float, push_n: float) -> None:
    """From far below to far above the transformation; by Newton's method and where it needs its bracket."""
    wire = constants(kind, bench_values={"guide_friction_n": 0.0})
    rest = resting_state(wire)

    def at(enthalpy_j: float, force_n: float) -> tuple[float, ...]:
        given_numbers = np.array([enthalpy_j, rest.temperature_k, rest.stress_pa, force_n])
        return tuple(float(item) for item in solved_at(rest.copy().row, *wire.step_arrays(), given_numbers))

    enthalpy_j = rest.enthalpy_j + heat_j
    here = at(enthalpy_j, push_n)
    assert here[7]
    for place, slope in ((0, here[3]), (1, here[4]), (2, here[5])):
        by_heat = quotient(lambda joule, place=place: at(joule, push_n)[place], enthalpy_j, 1e-5)
        assert by_heat == pytest.approx(slope, rel=2e-3, abs=1e-3 * abs(here[3]) * (1e-4, 1e4, 1e-4)[place])
    # A push moves the wire along its own line: stress per contraction at constant enthalpy.
    low, high = at(enthalpy_j, push_n - 1e-4), at(enthalpy_j, push_n + 1e-4)
    assume(high[2] != low[2])
    assert (high[1] - low[1]) / (high[2] - low[2]) == pytest.approx(here[6], rel=2e-2)
