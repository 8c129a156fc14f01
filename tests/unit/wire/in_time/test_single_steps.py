"""A few steps at a time, of wires in the middle of their transformation, held to conservation laws and to finer steps.

Short enough for plain Python: with compilation off (``NUMBA_DISABLE_JIT=1``) each test takes about a second.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wire_makers import constants, stored_heat_j

from musclewire.wire import (
    StepControl,
    WireBatch,
    WireConstants,
    WireMeans,
    WireState,
    advance,
    drive_path,
    fixed_steps,
    heated_state,
)

WIRE = constants()
NEW = constants(new_wire=True, bench_values={"lead_resistance_ohm": 0.2, "shunt_resistance_ohm": 1.5})
STARTS_K = (310.0, 352.0, 365.0, 378.0, 420.0)
starts = st.sampled_from([(wire, heated_state(wire, kelvin)) for wire in (WIRE, NEW) for kelvin in STARTS_K])
drives = st.sampled_from([0.0, 0.5, 2.5, 3.6])


def loss_w(wire: WireConstants, temperature_k: float) -> float:
    """Return the heat that a wire loses to the air, by the table of its coefficient."""
    table = np.asarray(wire.derived.record.convection_w_per_m2_k)
    places = wire.convection_table_start_k + wire.convection_table_step_k * np.arange(table.size)
    coefficient = wire.convection_factor * np.interp(temperature_k, places, table)
    return float(coefficient * wire.surface_m2 * (temperature_k - wire.ambient_temperature_k))


def in_circuit(wire: WireConstants, state: WireState, drive_v: float) -> tuple[float, float]:
    """Return current [A] and electrical power [W]: wire, shunt and leads are in series."""
    current_a = drive_v / (state.resistance_ohm + wire.series_resistance_ohm)
    return current_a, current_a**2 * state.resistance_ohm


@given(starts, drives, st.sampled_from([1e-3, 1e-2]))
def test_one_step_keeps_energy_and_its_means_are_those_of_both_ends(
    start: tuple[WireConstants, WireState], drive_v: float, step_s: float
) -> None:
    wire, before = start
    after, means = advance(before, wire, drive_v, step_s, fixed_steps(step_s))
    circuit = [in_circuit(wire, state, drive_v) for state in (before, after)]
    power_w = [power for _, power in circuit]
    lost_w = [loss_w(wire, state.temperature_k) for state in (before, after)]
    assert after.heat_in_j - before.heat_in_j == pytest.approx(step_s * np.mean(power_w), rel=1e-9, abs=1e-15)
    assert after.heat_out_j - before.heat_out_j == pytest.approx(step_s * np.mean(lost_w), rel=1e-9, abs=1e-15)
    gained_j = after.enthalpy_j + after.carried_heat_j - before.enthalpy_j - before.carried_heat_j
    heat_j = step_s * (np.mean(power_w) - np.mean(lost_w))
    assert gained_j == pytest.approx(heat_j, rel=1e-9, abs=1e-13)
    volts = [current * state.resistance_ohm for (current, _), state in zip(circuit, (before, after), strict=True)]
    assert means.wire_voltage_v == pytest.approx(np.mean(volts), rel=1e-12)
    assert means.shunt_voltage_v == pytest.approx(
        wire.shunt_resistance_ohm * np.mean([a for a, _ in circuit]), rel=1e-12
    )
    moved_m = wire.leg_length_m * np.mean([state.connector_contraction for state in (before, after)])
    assert means.displacement_m == pytest.approx(moved_m, rel=1e-12)
    force_n = wire.legs * wire.area_m2 * np.mean([state.stress_pa for state in (before, after)])
    assert means.force_n == pytest.approx(force_n, rel=1e-12)
    assert after.time_s - before.time_s == pytest.approx(step_s)


@given(starts, drives)
def test_after_a_step_the_wire_carries_its_load_at_the_enthalpy_of_its_phases(
    start: tuple[WireConstants, WireState], drive_v: float
) -> None:
    wire, before = start
    after, _ = advance(before, wire, drive_v, 0.02, fixed_steps(0.01))
    load_n = (
        wire.pretension_n + wire.spring_stiffness_n_per_m * wire.leg_length_m * after.contraction + after.friction_n
    )
    assert wire.legs * wire.area_m2 * after.stress_pa == pytest.approx(load_n, abs=1e-6)
    assert after.enthalpy_j == pytest.approx(stored_heat_j(after, wire), abs=1e-12)
    assert abs(after.friction_n) <= wire.friction_n * (1.0 + 1e-12)


def answer(
    before: WireState, wire: WireConstants, drive_v: float, stepping: StepControl
) -> tuple[np.ndarray, WireState]:
    """Return temperature [K], resistance [ohm] and strain [1e-3] after 80 ms."""
    after, _ = advance(before, wire, drive_v, 0.08, stepping)
    return np.array([after.temperature_k, after.resistance_ohm, 1e3 * after.contraction]), after


@pytest.mark.parametrize("drive_v", [0.3, 3.0])
def test_half_the_step_leaves_a_quarter_of_the_error(drive_v: float) -> None:
    """Of wires on their way already, so that the slopes of the last step hold: 80 ms in 4, 8 and 16 steps."""
    errors = np.zeros((3, 3))
    for kelvin in STARTS_K:
        on_its_way, _ = advance(heated_state(WIRE, kelvin), WIRE, drive_v, 0.04, fixed_steps(1e-3))
        finest, _ = answer(on_its_way, WIRE, drive_v, fixed_steps(2.5e-4))
        for row, count in enumerate((4, 8, 16)):
            errors[row] += np.abs(answer(on_its_way, WIRE, drive_v, fixed_steps(0.08 / count))[0] - finest)
    # A front that begins or ends to move within a step costs its order there.
    assert (errors[2] <= 0.3 * errors[0]).all(), errors
    assert (errors[2] < [0.02, 1e-3, 0.01]).all(), errors


@pytest.mark.parametrize("tight", ["temperature_k", "resistance", "strain"])
@pytest.mark.parametrize("drive_v", [0.0, 3.4])
def test_each_tolerance_alone_keeps_its_quantity(tight: str, drive_v: float) -> None:
    before = heated_state(WIRE, 366.0)
    finest, _ = answer(before, WIRE, drive_v, fixed_steps(2.5e-4))
    loose = {"temperature_k": 1e3, "resistance": 1e3, "strain": 1e3}
    coarse, once = answer(before, WIRE, drive_v, StepControl(**loose))
    tolerance = {"temperature_k": 2e-3, "resistance": 1e-5, "strain": 3e-6}[tight]
    found, kept = answer(before, WIRE, drive_v, StepControl(**{**loose, tight: tolerance}))
    assert kept.evaluations > once.evaluations
    assert (np.abs(found - finest) < np.abs(coarse - finest)).all()
    place, scale = {"temperature_k": (0, 1.0), "resistance": (1, before.resistance_ohm), "strain": (2, 1e3)}[tight]
    assert abs(found[place] - finest[place]) < 10.0 * tolerance * scale
    if tight == "temperature_k":
        assert kept.step_error_k <= tolerance
        assert once.step_error_k > tolerance


def test_the_estimated_error_is_near_the_error_of_the_step() -> None:
    """Within a factor of three, once slopes are known; what a step owes is made good by the next."""
    for kelvin in (352.0, 366.0, 378.0):
        before, _ = advance(heated_state(WIRE, kelvin), WIRE, 3.0, 0.04, fixed_steps(1e-3))
        before = before.replace(step_error_k=0.0)
        after, _ = advance(before, WIRE, 3.0, 0.03, fixed_steps(0.03))
        fine, _ = advance(before, WIRE, 3.0, 0.03, fixed_steps(1e-4))
        error_k = abs(after.temperature_k - fine.temperature_k)
        assert error_k / 3.0 - 1e-4 < after.step_error_k < 3.0 * error_k + 1e-2


def test_chosen_steps_go_on_with_the_length_that_suits_and_grow_again() -> None:
    state, lengths = heated_state(WIRE, 366.0), []
    for drive_v in (3.4,) * 4 + (0.6,) * 4:
        state, _ = advance(state, WIRE, drive_v, 0.05, StepControl())
        lengths.append(state.step_s)
    assert all(1e-5 <= length_s <= 3.0 * 0.05 for length_s in lengths)
    assert min(lengths) < 0.05
    assert lengths[-1] > min(lengths)


WIRES = [
    constants(kind, bench_values={"pretension_n": force_n, "guide_friction_n": friction_n})
    for kind, force_n, friction_n in (
        ("round", 1.0, 0.0), ("round", 2.0, 0.1), ("round", 1.5, 0.3), ("round", 0.6, 0.0), ("round", 2.6, 0.02),
        ("round", 1.2, 0.0), ("round", 1.8, 0.05), ("round", 0.9, 0.2), ("round", 2.2, 0.0),
    )
]  # fmt: skip


@pytest.mark.parametrize("drive_v", [0.0, 3.6])
def test_a_batch_in_the_middle_of_the_transformation_has_the_bits_of_each_wire(drive_v: float) -> None:
    """All fields of all states; with one wire more than lie side by side."""
    heated = [heated_state(wire, 340.0 + 8.0 * place) for place, wire in enumerate(WIRES)]
    wires, states = [*WIRES, *WIRES[:8]], [*heated, *heated[:8]]
    drive = np.array([1.5, drive_v])
    batch = WireBatch(wires, states=states, stepping=fixed_steps(0.01), threads=1)
    shown = batch.drive(
        drive, 0.01, ("wire_voltage_v", "shunt_voltage_v", "displacement_m", "force_n", "resistance_ohm")
    )
    for place, (wire, state) in enumerate(zip(wires, states, strict=True)):
        path, after = drive_path(wire, drive, sample_s=0.01, stepping=fixed_steps(0.01), state=state)
        for name, found in shown.items():
            assert np.array_equal(found[place], getattr(path, name)), (place, name)
        for name, value in batch.state(place).values().items():
            if name != "front_trial":
                assert np.array_equal(value, getattr(after, name)), (place, name)


def test_a_current_source_heats_by_its_current_whatever_the_resistance() -> None:
    before = heated_state(WIRE, 366.0)
    path, after = drive_path(
        WIRE, np.array([0.15, 0.15]), sample_s=0.01, stepping=fixed_steps(0.01), state=before, regulated_current=True
    )
    assert path.shunt_voltage_v == pytest.approx(0.15 * WIRE.shunt_resistance_ohm, rel=1e-12)
    first, _ = drive_path(
        WIRE, np.array([0.15]), sample_s=0.01, stepping=fixed_steps(0.01), state=before, regulated_current=True
    )
    ohm = [before.resistance_ohm, *path.resistance_ohm.tolist()]
    heat_j = 0.01 * 0.15**2 * (0.5 * ohm[0] + ohm[1] + 0.5 * ohm[2])
    assert after.heat_in_j - before.heat_in_j == pytest.approx(heat_j, rel=1e-12)
    assert first.resistance_ohm[0] == path.resistance_ohm[0]


def test_means_of_a_sample_of_many_steps_are_those_of_its_steps() -> None:
    before = heated_state(WIRE, 366.0)
    whole, means = advance(before, WIRE, 3.0, 0.05, fixed_steps(0.01))
    state, parts = before, list[WireMeans]()
    for _ in range(5):
        state, part = advance(state, WIRE, 3.0, 0.01, fixed_steps(0.01))
        parts.append(part)
    assert means[:4] == pytest.approx(np.mean([part[:4] for part in parts], axis=0), rel=1e-12)
    assert whole.temperature_k == state.temperature_k
