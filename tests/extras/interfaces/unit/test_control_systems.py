"""The wire as systems of python-control, held to the simulator in time and to python-control's own linearisation."""

from __future__ import annotations

import math

import control
import numpy as np
import pytest

from musclewire.controllers import ControllerSetup, DriveLimits, PidSettings, pid_controller
from musclewire.errors import CallerError
from musclewire.extras.interfaces import linearise, simulated_wire
from musclewire.extras.interfaces._control_systems.linearisation import LinearWire, Motion, linearised
from musclewire.extras.interfaces._control_systems.loops import controller_system, loop_margins, sampled_system
from musclewire.extras.interfaces._control_systems.operating_points import Branch, OperatingPoint, operating_point
from musclewire.extras.interfaces._control_systems.systems import branch_system, linear_system, wire_system
from musclewire.rigs import open_rig
from musclewire.signals import Drive, QuantityEstimate
from musclewire.wire import WireState, advance, resting_state

BRANCHES: list[Branch] = ["heating", "cooling"]
MOTIONS: list[Motion] = ["branch", "minor loop"]
DISPLACEMENTS_M = (1e-3, 2e-3)


@pytest.fixture(scope="module")
def points() -> dict[tuple[float, str], OperatingPoint]:
    return {(at, branch): operating_point(at, branch=branch) for at in DISPLACEMENTS_M for branch in BRANCHES}


def held(state: WireState, point: OperatingPoint, drive_v: float, duration_s: float) -> WireState:
    """Return the simulated wire after a constant drive."""
    for _ in range(round(duration_s / 0.05)):
        state, _ = advance(state, point.wire.constants, drive_v, 0.05)
    return state


@pytest.mark.parametrize("at", DISPLACEMENTS_M)
@pytest.mark.parametrize("branch", BRANCHES)
def test_the_holding_voltage_leads_there_in_time_from_the_branchs_start(
    at: float, branch: Branch, points: dict[tuple[float, str], OperatingPoint]
) -> None:
    point = points[at, branch]
    state = resting_state(point.wire.constants)
    if branch == "cooling":
        state = held(state, point, point.wire.limits.maximum_voltage_v, 60.0)
    settled = held(state, point, point.drive_voltage_v, 60.0)
    assert settled.connector_contraction * point.wire.constants.leg_length_m == pytest.approx(at, rel=1e-5)
    assert settled.temperature_k == pytest.approx(point.temperature_k, abs=1e-3)
    assert settled.resistance_ohm == pytest.approx(point.resistance_ohm, rel=1e-6)


def test_the_heating_branch_needs_more_voltage_than_the_cooling_branch(
    points: dict[tuple[float, str], OperatingPoint],
) -> None:
    for at in DISPLACEMENTS_M:
        assert points[at, "heating"].drive_voltage_v > points[at, "cooling"].drive_voltage_v + 0.1


@pytest.mark.parametrize("branch", BRANCHES)
@pytest.mark.parametrize("motion", MOTIONS)
def test_the_linear_wire_is_what_python_control_linearises(
    branch: Branch, motion: Motion, points: dict[tuple[float, str], OperatingPoint]
) -> None:
    point = points[2e-3, branch]
    ours = linear_system(linearised(point, motion))
    onward = 1.0 if branch == "heating" else -1.0
    # python-control takes forward differences; back of the point both of their ends lie in the minor loop.
    aside_j = 0.0 if motion == "branch" else -onward * 1e-4
    theirs = control.linearize(
        branch_system(point, motion), [point.state.enthalpy_j + aside_j], [point.drive_voltage_v], eps=1e-6
    )
    np.testing.assert_allclose(ours.A, theirs.A, rtol=2e-3)
    np.testing.assert_allclose(ours.B, theirs.B, rtol=1e-4)
    np.testing.assert_allclose(ours.C, theirs.C, rtol=2e-3)


@pytest.mark.parametrize("branch", BRANCHES)
@pytest.mark.parametrize("motion", MOTIONS)
def test_a_small_step_of_the_drive_is_answered_as_the_linear_wire_does(
    branch: Branch, motion: Motion, points: dict[tuple[float, str], OperatingPoint]
) -> None:
    """The simulator in time, from the operating point: the only oracle that knows no slopes."""
    point = points[2e-3, branch]
    linear = linearised(point, motion)
    onward = 1.0 if (branch == "heating") == (motion == "branch") else -1.0
    step_v, state = onward * 2e-3, point.state
    for duration_s in (0.5, 1.0):
        state = held(state, point, point.drive_voltage_v + step_v, 0.5)
        grown = 1.0 - math.exp(linear.rate_per_s * duration_s)
        for found, before, slope in (
            (state.temperature_k, point.temperature_k, linear.temperature_k_per_j),
            (state.resistance_ohm, point.resistance_ohm, linear.resistance_ohm_per_j),
            (state.connector_contraction, point.strain, linear.strain_per_j),
        ):
            assert found - before == pytest.approx(grown * step_v * linear.steady_per_volt(slope), rel=0.02)


def test_in_the_minor_loop_the_wire_is_faster_and_hardly_moves(points: dict[tuple[float, str], OperatingPoint]) -> None:
    for point in points.values():
        onward, back = (linearised(point, motion) for motion in MOTIONS)
        assert 0.0 < back.time_constant_s < onward.time_constant_s
        assert abs(back.strain_per_j) < 0.1 * onward.strain_per_j
        assert back.temperature_k_per_j == pytest.approx(1.0 / point.wire.constants.heat_capacity_j_per_k, rel=1e-6)


def test_the_wire_system_is_the_simulator_to_the_bit() -> None:
    system, x = wire_system("simulated")
    wire = simulated_wire("simulated")
    state, times = resting_state(wire.constants), system.dt * np.arange(101)
    drives = 1.5 + 1.5 * np.sin(0.3 * times) ** 2
    answer = control.input_output_response(system, times, drives, x)
    for sample, drive_v in enumerate(drives[:-1], 1):
        state, means = advance(state, wire.constants, float(drive_v), wire.sample_period_s, wire.stepping)
        assert answer.outputs[:, sample].tolist() == list(means[:4])
    assert answer.states[: state.numbers.size, -1].tolist() == state.numbers.tolist()


def test_a_wire_between_samples_is_the_continuous_one(points: dict[tuple[float, str], OperatingPoint]) -> None:
    """Means over samples against a fine integration of the state space."""
    linear = linearised(points[2e-3, "heating"])
    drives = np.array([1.0, -0.5, 0.25, 2.0])
    fine = 2000
    times = 0.05 / fine * np.arange(4 * fine + 1)
    held_v = np.repeat(drives, fine)
    state = control.forced_response(linear_system(linear), times, np.append(held_v, 0.0)).outputs[1]
    # A drive that is held: the response of python-control interpolates, so each sample is integrated by itself here.
    heat, means = 0.0, []
    for drive in drives:
        grown = np.exp(linear.rate_per_s * 0.05 * np.linspace(0.0, 1.0, fine + 1))
        path = heat * grown + (grown - 1.0) * linear.power_w_per_v / linear.rate_per_s * drive
        means.append(np.trapezoid(path, dx=1.0 / fine) * linear.strain_per_j)
        heat = path[-1]
    answer = control.forced_response(sampled_system(linear, 0.05), 0.05 * np.arange(5), np.append(drives, 0.0))
    np.testing.assert_allclose(answer.outputs.ravel()[1:], means, rtol=1e-6)
    assert heat * linear.strain_per_j == pytest.approx(state[-1], rel=1e-3)


def test_the_linear_controller_is_the_plain_pid_away_from_its_limits() -> None:
    settings, dt_s = PidSettings(), 0.05
    errors = 1e-5 * np.random.default_rng(1).standard_normal(40).cumsum()
    controller = pid_controller(ControllerSetup(DriveLimits(0.3, 3.6), settings=settings))
    state, drives = controller.start(2.0), []
    # From rest at zero error; the target is constant, so the error is the measured value turned round.
    state = controller.step(state, 0.0, QuantityEstimate(0.0, 0.0, True), dt_s).state
    for error in errors:
        step = controller.step(state, 0.0, QuantityEstimate(-float(error), 0.0, True), dt_s)
        state = step.state
        assert isinstance(step.command, Drive)
        drives.append(step.command.voltage_v - 2.0)
    answer = control.forced_response(controller_system(settings, dt_s), dt_s * np.arange(40), errors)
    np.testing.assert_allclose(answer.outputs.ravel(), drives, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("branch", BRANCHES)
def test_at_its_gain_margin_a_loop_has_a_pole_on_the_unit_circle(
    branch: Branch, points: dict[tuple[float, str], OperatingPoint]
) -> None:
    linear = linearised(points[2e-3, branch])
    margins = loop_margins(linear)
    assert margins.stable
    assert margins.gain_margin is not None
    raised = PidSettings(input_scale=margins.gain_margin * PidSettings().input_scale)
    loop = control.ss(controller_system(raised, 0.05)) * sampled_system(linear, 0.05)
    assert np.abs(control.feedback(loop, 1).poles()).max() == pytest.approx(1.0, abs=1e-4)
    assert not loop_margins(linear, PidSettings(input_scale=1.1 * raised.input_scale)).stable


def test_a_loop_by_a_model_takes_the_slope_of_its_curve() -> None:
    from musclewire.experiment import characterize
    from musclewire.identify import fit

    with open_rig("simulated") as rig:
        model = fit(characterize(rig, cycles=1))
    found = linearise(2e-3, model=model)
    for one in found.loops:
        linear: LinearWire = one.linear
        around = linear.point.resistance_ohm + np.array([-1e-5, 1e-5])
        slope = np.diff(model.curve().value(around))[0] / 2e-5
        assert linear.estimate_per_j(model) == pytest.approx(slope * linear.resistance_ohm_per_j, rel=1e-4)
    onward, back = found.loops[0], found.loops[1]
    assert onward.margins.stable
    # Back, resistance rises with temperature and reads as less strain: the loop drifts until the barrier is passed.
    assert not back.margins.stable


def test_what_has_no_operating_point_is_said_in_one_line() -> None:
    with pytest.raises(CallerError, match="choose a displacement between them"):
        linearise(displacement_m=0.02)
