"""The wire in segments against oracles: the simulated wire, a fin, the first law, itself with finer steps and grid."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtr

from musclewire.errors import CallerError, NumericsError
from musclewire.extras.studies import (
    Conditions,
    NormalMixture,
    SegmentedConfiguration,
    SegmentedWire,
    WireAgeing,
    WireStructure,
    fin_length_m,
    mixture_distribution,
)
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire import BarrierClass, OneWire, StepControl, constants_from

pytestmark = pytest.mark.slow

SAMPLE_S = 0.05
STROKE = 0.038
CLASSES = (BarrierClass(0.3, -2.0), BarrierClass(0.4, 0.0), BarrierClass(0.3, 2.5))
STEP_S: float = SegmentedConfiguration.model_fields["time_step"].default
GRAINS = mixture_distribution((NormalMixture(0.8, 0.0, 1.0), NormalMixture(0.2, -1.5, 2.0)))


def paper(structure: WireStructure, step_s: float = STEP_S) -> SegmentedWire:
    return SegmentedWire(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"), structure, step_s)


def drive_v(number: int) -> float:
    """Half a slow loop, then jumps of the drive: both kinds of turn, and the fastest heating."""
    time_s = number * SAMPLE_S
    if time_s < 20.0:
        return 0.3 + 2.9 * math.sin(math.pi * time_s / 20.0) ** 2
    return 3.2 if int(time_s) % 4 < 2 else 0.3


def strains_of(wire: SegmentedWire, samples: int = 600) -> np.ndarray:
    return np.array([wire.advance(drive_v(number), SAMPLE_S).strain for number in range(samples)])


def test_one_segment_without_clamps_is_the_simulated_wire() -> None:
    """By the kernel of one wire with a tenth of its tolerances: 0.01 % of stroke and 2e-5 of resistance."""
    alloy, wire, bench = load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper")
    known, ours = OneWire(constants_from(alloy, wire, bench)), paper(WireStructure(1, clamped=False))
    fine = StepControl(0.0, 5e-4, 3e-6, 1e-6)
    for number in range(600):
        expected = known.advance(drive_v(number), SAMPLE_S, fine)
        found = ours.advance(drive_v(number), SAMPLE_S)
        ratio = expected.wire_voltage_v / expected.shunt_voltage_v
        assert found.wire_voltage_v / found.shunt_voltage_v == pytest.approx(ratio, rel=2e-5)
        assert found.displacement_m == pytest.approx(expected.displacement_m, abs=1e-4 * STROKE * ours.leg_length_m)
        assert found.force_n == pytest.approx(expected.force_n, abs=1e-3)
        assert ours.state.temperature_k == pytest.approx(known.state.temperature_k, abs=5e-3)


def test_segments_that_are_all_alike_are_one() -> None:
    one = strains_of(paper(WireStructure(1, clamped=False, classes=CLASSES, grains=GRAINS)))
    many = strains_of(paper(WireStructure(10, clamped=False, classes=CLASSES, grains=GRAINS)))
    assert many == pytest.approx(one, abs=1e-9)


@given(seed=st.integers(0, 1000))
@settings(max_examples=5, deadline=None)
def test_energy_is_conserved_whatever_differs_along_the_wire(seed: int) -> None:
    """Enthalpy gained is electrical heat less what air and clamps took, to rounding, while conditions jump about."""
    random = np.random.default_rng(seed)
    shifts = tuple(random.normal(0.0, 2.0, 12))
    wire = paper(WireStructure(12, temperature_shifts_k=shifts, classes=CLASSES, grains=GRAINS))
    before_j = wire.enthalpy_j
    for _ in range(40):
        wire.surround(
            Conditions(
                ambient_k=float(random.uniform(280.0, 310.0)),
                convection_factor=random.uniform(0.5, 3.0, 12),
                load_force_n=float(random.uniform(-0.8, 0.9)),
                stiffness_factor=float(random.uniform(0.5, 2.0)),
                resistance_factor=float(random.uniform(0.95, 1.05)),
            )
        )
        for _ in range(5):
            wire.advance(float(random.uniform(0.0, 3.6)), SAMPLE_S)
    sums = wire.sums
    gained_j = sums["heat_in_j"] - sums["heat_to_air_j"] - sums["heat_to_clamps_j"]
    assert wire.enthalpy_j - before_j == pytest.approx(gained_j, abs=1e-11)
    assert sums["heat_to_clamps_j"] > 0.0


def jump(random: np.random.Generator, segments: int) -> Conditions:
    return Conditions(
        ambient_k=float(random.uniform(275.0, 315.0)),
        convection_factor=random.uniform(0.3, 4.0, segments),
        load_force_n=float(random.uniform(-2.2, 1.5)),
        stiffness_factor=float(random.uniform(0.0, 3.0)),
        pretension_force_n=float(random.uniform(-0.5, 0.5)),
        transformation_shift_k=float(random.normal(0.0, 5.0)),
    )


@given(seed=st.integers(0, 10_000), segments=st.sampled_from([1, 10, 20]))
@settings(max_examples=12, deadline=None)
def test_whatever_jumps_the_wire_is_in_balance_with_its_load(seed: int, segments: int) -> None:
    """Each step is solved, and stress is that of spring and conditions within the friction, or 0 for a slack wire.

    A prediction by rises over next to no heat once made errors of 200 K after a jump of the load.
    """
    random = np.random.default_rng(seed)
    shifts = tuple(random.normal(0.0, 2.0, segments))
    wire = paper(WireStructure(segments, temperature_shifts_k=shifts, classes=CLASSES, grains=GRAINS))
    bench = load_bench("paper").values()
    for _ in range(40):
        conditions = jump(random, segments)
        wire.surround(conditions)
        for _ in range(3):
            wire.advance(float(random.choice([0.0, 0.3, 1.0, 3.6])), SAMPLE_S)
            state = wire.state
            spring_n = conditions.stiffness_factor * bench["spring_stiffness_n_per_m"] * state.strain * 0.07
            load_n = 1.9 + conditions.load_force_n + conditions.pretension_force_n + spring_n
            if state.stress_pa > 0.0:
                assert state.force_n == pytest.approx(load_n, abs=1.01 * bench["guide_friction_n"])
            else:
                assert load_n < 1.01 * bench["guide_friction_n"]
    assert wire.sums["step_error_k"] < 1.0


def test_half_the_step_changes_less_than_a_thousandth_of_the_stroke() -> None:
    structure = WireStructure(12, classes=CLASSES, grains=GRAINS)
    coarse, fine, finest = (strains_of(paper(structure, step_s)) for step_s in (2.0 * STEP_S, STEP_S, 3.125e-4))
    assert np.abs(fine - finest).max() < 2e-4 * STROKE
    # Second order: half the step leaves a quarter of the error, on the mean over the run.
    assert np.abs(fine - finest).mean() < 0.4 * np.abs(coarse - finest).mean()


def test_more_segments_change_ever_less() -> None:
    """At most 0.4 % of stroke from 10 to 200 segments, at the fastest moment of a jump of the drive."""
    strains = [strains_of(paper(WireStructure(number))) for number in (10, 40, 200)]
    ten, forty = (np.abs(strain - strains[-1]).max() for strain in strains[:-1])
    assert ten < 4e-3 * STROKE
    assert forty < 1e-3 * STROKE


def held_warm(structure: WireStructure, coefficient: float) -> SegmentedWire:
    """Return a wire warmed by a few kelvins at a constant convection coefficient: nothing transforms."""
    wire = paper(structure)
    wire._derived["convection_w_per_m2_k"] = coefficient
    for _ in range(200):
        wire.advance(0.7, SAMPLE_S)
    return wire


@pytest.mark.parametrize("structure", [WireStructure(400, length_fractions=(1.0 / 400,) * 400), WireStructure(12)])
def test_cold_ends_are_those_of_a_fin(structure: WireStructure) -> None:
    """Closed form of a heated fin between cold ends: 1 - cosh(x / l) / cosh(L / 2 l), x from the middle.

    In the middle the wire does not know of its ends. Resistance varies by 0.5 % over so few kelvins; ten segments or so
    have each temperature to 3 %, and the mean over the length to 0.3 %.
    """
    length_m, coefficient = 0.14, 100.0
    wire = held_warm(structure, coefficient)
    factor = load_wire("paper-100um").convection_factor.value
    fin_m = fin_length_m(18.0, 100e-6, coefficient * factor)
    ends_m = np.concatenate(([0.0], np.cumsum(wire.weights))) * length_m - 0.5 * length_m
    whole = fin_m / math.cosh(0.5 * length_m / fin_m)
    means = 1.0 - whole * np.diff(np.sinh(ends_m / fin_m)) / np.diff(ends_m)
    excess_k = wire.state.segment_temperatures_k - 295.15
    assert 2.0 < excess_k.max() < 12.0
    assert excess_k / excess_k.max() == pytest.approx(means, abs=0.006 if structure.n_segments > 100 else 0.03)
    assert wire.weights @ excess_k / excess_k.max() == pytest.approx(1.0 - 2.0 * fin_m / length_m, abs=3e-3)


def test_a_mixture_has_its_own_cumulative_fractions() -> None:
    offsets = np.linspace(-5.0, 4.0, 37)
    expected = 0.8 * ndtr(offsets) + 0.2 * ndtr((offsets + 1.5) / 2.0)
    assert GRAINS.cumulative(offsets) == pytest.approx(expected, abs=3e-5)


def held(conditions: Conditions, voltage_v: float = 2.5) -> SegmentedWire:
    wire = paper(WireStructure(12))
    wire.surround(conditions)
    for _ in range(160):
        wire.advance(voltage_v, SAMPLE_S)
    return wire


@pytest.mark.parametrize(
    ("conditions", "warmer", "longer"),
    [
        (Conditions(ambient_k=310.15), True, False),
        (Conditions(ambient_k=280.15), False, True),
        (Conditions(convection_factor=3.0), False, True),
        (Conditions(convection_factor=0.5), True, False),
        (Conditions(load_force_n=0.95), None, True),
        (Conditions(pretension_force_n=-0.38), None, False),
        (Conditions(stiffness_factor=2.0), None, True),
        (Conditions(transformation_shift_k=5.0), None, True),
    ],
)
def test_conditions_act_in_the_direction_of_their_sign(
    conditions: Conditions, warmer: bool | None, longer: bool
) -> None:
    still, changed = held(Conditions()).state, held(conditions).state
    if warmer is not None:
        assert (changed.temperature_k > still.temperature_k) is warmer
    assert (changed.strain < still.strain) is longer


def test_resistance_scales_with_its_factor() -> None:
    """Of a cold wire, whose state the factor does not change."""
    wires = [held(Conditions(resistance_factor=factor), voltage_v=0.05) for factor in (1.0, 1.01)]
    ratio = wires[1].state.resistance_ohm / wires[0].state.resistance_ohm
    assert ratio == pytest.approx(1.01, rel=1e-4)


def test_a_draught_on_one_place_cools_that_place() -> None:
    factors = np.ones(12)
    factors[4] = 2.0
    still, blown = held(Conditions()).state, held(Conditions(convection_factor=factors)).state
    fallen_k = still.segment_temperatures_k - blown.segment_temperatures_k
    assert fallen_k.argmax() == 4
    assert fallen_k[4] > 5.0 * abs(fallen_k[8])


def test_three_segments_carry_one_force_jump_with_the_load_and_go_slack_together() -> None:
    """Few segments and samples, so that it can be run without compilation, too."""
    wire = paper(WireStructure(3, classes=CLASSES, grains=GRAINS))
    for force_n in (0.0, 1.0, -2.5, 0.0, 1.5):
        wire.surround(Conditions(load_force_n=force_n))
        for _ in range(3):
            means = wire.advance(2.8, SAMPLE_S)
        carried_n = wire.state.stress_pa * wire.section_m2
        assert carried_n == pytest.approx(wire.state.force_n, abs=1e-9)
        assert carried_n == pytest.approx(max(1.9 + force_n, 0.0), abs=0.9)
        assert means.force_n >= 0.0
        assert (wire.state.stress_pa == 0.0) is (force_n < -1.9)


def test_ageing_grows_with_the_logarithm_of_the_cycles() -> None:
    ageing = WireAgeing(cycles_scale=10.0, residual_strain=1e-3, resistance=0.01, temperature_k=2.0)
    strain, factor, shift_k = ageing.effects(10.0 * (math.e - 1.0))
    assert (strain, factor, shift_k) == pytest.approx((1e-3, 1.01, 2.0))
    trained = ageing._replace(cycles_before=1000.0)
    assert trained.effects(0.0) == pytest.approx((0.0, 1.0, 0.0))
    assert trained.effects(10.0)[0] < 0.02 * ageing.effects(10.0)[0]


def test_a_wire_that_ages_ends_longer_and_of_more_resistance_than_one_that_does_not() -> None:
    ageing = WireAgeing(cycles_scale=1.0, residual_strain=2e-3, resistance=0.01)
    plain, aged = paper(WireStructure(10)), paper(WireStructure(10, ageing=ageing))
    for number in range(400):
        for wire in (plain, aged):
            wire.advance(3.2 if number % 100 < 40 else 0.3, SAMPLE_S)
    assert aged.state.cycles > 2.0
    assert aged.state.strain - plain.state.strain == pytest.approx(-2e-3 * math.log1p(aged.state.cycles), rel=0.2)
    assert aged.state.resistance_ohm > 1.005 * plain.state.resistance_ohm


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: paper(WireStructure(3, temperature_shifts_k=(1.0, 2.0))), "each of the 3 segments"),
        (lambda: paper(WireStructure(2, length_fractions=(0.7, 0.7))), "add up to 1.4"),
        (lambda: mixture_distribution([NormalMixture(0.5, 0.0, 1.0)]), "add up to 1"),
    ],
)
def test_what_cannot_be_a_wire_is_refused(wrong: Callable[[], object], message: str) -> None:
    with pytest.raises(CallerError, match=message):
        wrong()


def test_conditions_that_are_no_numbers_end_the_simulation() -> None:
    wire = paper(WireStructure(10))
    wire.surround(Conditions(load_force_n=math.nan))
    with pytest.raises(NumericsError, match="does not resolve"):
        wire.advance(1.0, SAMPLE_S)
