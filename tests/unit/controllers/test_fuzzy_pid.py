"""The controller: Eq. 6, bumpless start, limits, anti-windup, missing measurements."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.controllers import (
    DriveLimits,
    FuzzyPidController,
    FuzzyPidSettings,
    infer_ratios,
    load_rule_base,
    rule_base_names,
)
from musclewire.controllers._kernels import PidState
from musclewire.controllers._rules import parse_rule_base
from musclewire.errors import CallerError, NumericsError
from musclewire.signals import ControlStep, QuantityEstimate, Reason

LIMITS = DriveLimits(sense_voltage_v=0.4, maximum_voltage_v=3.2)
DT_S = 0.05
NO_CURRENT = QuantityEstimate(0.0, 0.0, False, Reason.NO_CURRENT)

strains = st.floats(-0.01, 0.06)
measurements = st.lists(strains, min_size=1, max_size=60)


@cache
def controller(rule_base: str = "zhao-1993", derivative_filter_s: float = 0.1) -> FuzzyPidController:
    return FuzzyPidController(FuzzyPidSettings(rule_base=rule_base, derivative_filter_s=derivative_filter_s), LIMITS)


def constant_ratios(ratio: float) -> FuzzyPidController:
    rule_base = parse_rule_base(
        f'name = "c"\ntitle = "t"\nsource = "s"\nlicence = "l"\n'
        f'[rules]\ninference = "constant"\nkp = {ratio}\nki = {ratio}\nkd = {ratio}\n'
    )
    return FuzzyPidController(FuzzyPidSettings(), LIMITS, rule_base)


def at_rest(drive_v: float, measured: float, target: float) -> PidState:
    """The state at a drive, after a sample at which nothing moved."""
    return PidState(1.0, drive_v, target - measured, measured, 0.0, 0.0, 1.0)


def after(state: Any, target: float, measured: float, dt_s: float = DT_S, pid: Any = None) -> ControlStep:
    """The step from a state, by the default controller unless another is given."""
    done: ControlStep = (pid or controller()).step(tuple(state), target, QuantityEstimate(measured, 0.0, True), dt_s)
    return done


def run(pid: FuzzyPidController, state: Any, target: float, measured: list[float]) -> list[float]:
    drives = []
    for value in measured:
        state = after(state, target, value, pid=pid).state
        drives.append(PidState(*state).drive_voltage_v)
    return drives


@pytest.mark.parametrize(("ratio", "gains"), [(0.0, (0.01, 0.02, 0.0005)), (1.0, (0.11, 0.06, 0.001))])
def test_the_ends_of_the_ratios_are_the_ends_of_the_papers_gain_ranges(
    ratio: float, gains: tuple[float, float, float]
) -> None:
    pid = constant_ratios(ratio)
    assert after(at_rest(1.0, 0.0, 0.0), 0.003, 0.0, pid=pid).recorded == pytest.approx(gains, rel=1e-14)


def test_the_gains_follow_the_fuzzy_ratios_of_the_scaled_error_and_its_filtered_rate() -> None:
    result = after(at_rest(1.0, 0.0150, 0.0155), 0.0155, 0.0151)
    rate_pct_per_s = (0.04 - 0.05) / DT_S * (DT_S / (0.1 + DT_S))
    set_to = FuzzyPidSettings()
    ratios = infer_ratios(load_rule_base(), 0.04 / set_to.error_range, rate_pct_per_s / set_to.change_range)
    expected = (0.01 + 0.1 * ratios.kp, 0.02 + 0.04 * ratios.ki, 0.0005 + 0.0005 * ratios.kd)
    assert result.recorded == pytest.approx(expected, rel=1e-9)


def test_without_filter_and_with_a_constant_target_the_law_is_the_textbook_velocity_form() -> None:
    pid = controller("fixed", 0.0)
    measured = [0.0150, 0.0152, 0.0151, 0.0156, 0.0163, 0.0161]
    error_pct = [100.0 * (0.018 - value) for value in measured]
    drives = run(pid, at_rest(1.0, measured[0], 0.018), 0.018, measured[1:])
    expected, drive = [], 1.0
    history = [error_pct[0], *error_pct]
    for k in range(2, len(history)):
        e, e1, e2 = history[k], history[k - 1], history[k - 2]
        drive += 20.0 * (0.06 * (e - e1) + 0.04 * DT_S * e + 0.00075 / DT_S * (e - 2 * e1 + e2))
        expected.append(drive)
    assert min(expected) > LIMITS.sense_voltage_v
    assert max(expected) < LIMITS.maximum_voltage_v
    assert drives == pytest.approx(expected, rel=1e-9)


@given(st.floats(0.4, 3.2), strains, strains)
def test_the_first_step_after_start_moves_the_drive_by_its_integral_part_only(
    drive: float, measured: float, target: float
) -> None:
    result = after(controller().start(drive), target, measured)
    expected = drive + 20.0 * result.recorded[1] * DT_S * (target - measured) / 0.01
    assert PidState(*result.state).drive_voltage_v == pytest.approx(LIMITS.clamp(expected), abs=1e-12)
    assert result == after(at_rest(drive, measured, target), target, measured)


def test_a_target_step_gives_no_derivative_kick() -> None:
    state = PidState(*after(at_rest(1.0, 0.015, 0.015), 0.018, 0.015, pid=controller("fixed")).state)
    proportional_and_integral = 20.0 * (0.06 * 0.3 + 0.04 * DT_S * 0.3)
    assert state.drive_voltage_v == pytest.approx(1.0 + proportional_and_integral, rel=1e-12)
    assert state.measured_rate == 0.0


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=20), st.floats(1e-3, 1.0))
def test_absurd_but_finite_measurements_are_survived_or_refused_but_never_leave_the_limits(
    measured: list[float], dt_s: float
) -> None:
    state = controller().start(1.0)
    for value in measured:
        try:
            state = after(state, 0.0, value, dt_s).state
        except NumericsError:
            state = controller().step(state, 0.0, NO_CURRENT, dt_s).state
        assert LIMITS.sense_voltage_v <= PidState(*state).drive_voltage_v <= LIMITS.maximum_voltage_v
        assert all(math.isfinite(number) for number in state)


@pytest.mark.parametrize("rule_base", rule_base_names())
@pytest.mark.parametrize(("sign", "limit"), [(1.0, 3.2), (-1.0, 0.4)])
def test_after_a_minute_in_saturation_the_drive_leaves_the_limit_in_the_tick_the_error_changes_sign(
    rule_base: str, sign: float, limit: float
) -> None:
    pid = controller(rule_base)
    once = state = after(pid.start(limit), 0.02, 0.02 - sign * 0.01, pid=pid).state
    for _ in range(1200):
        state = after(state, 0.02, 0.02 - sign * 0.01, pid=pid).state
    assert state == once  # no memory but the clamped drive
    assert PidState(*state).drive_voltage_v == limit
    for target, measured in ((0.02, 0.02 + sign * 0.0001), (0.02 - sign * 0.0101, 0.02 - sign * 0.01)):
        left_v = PidState(*after(state, target, measured, pid=pid).state).drive_voltage_v
        assert sign * (limit - left_v) > 0.01


def test_without_current_the_drive_stays_the_rates_are_forgotten_and_the_proportional_part_catches_up() -> None:
    pid = controller("fixed")
    moved = PidState(*after(at_rest(1.0, 0.014, 0.018), 0.018, 0.015, pid=pid).state)
    bridged = pid.step(tuple(moved), 0.018, NO_CURRENT, DT_S)
    held = PidState(*bridged.state)
    assert held == moved._replace(measured_rate=0.0, error_rate=0.0, rates_known=0.0)
    assert bridged.recorded == (0.0, 0.0, 0.0)
    result = PidState(*after(held, 0.018, 0.016, pid=pid).state)
    change_v = 20.0 * (0.06 * -0.1 + 0.04 * DT_S * 0.2)
    assert result.drive_voltage_v == pytest.approx(held.drive_voltage_v + change_v, rel=1e-12)
    assert (result.measured_rate, result.rates_known) == (0.0, 1.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", ["target", "measured"])
def test_an_input_that_is_not_finite_is_refused(bad: float, place: str) -> None:
    with pytest.raises(NumericsError, match="finite"):
        after(at_rest(1.0, 0.015, 0.018), **{"target": 0.018, "measured": 0.015, place: bad})


def test_the_error_unit_makes_metres_control_like_strain() -> None:
    strain = controller()
    metres = FuzzyPidController(FuzzyPidSettings(error_unit=0.01 * 0.07, derivative_filter_s=0.1), LIMITS)
    in_strain = run(strain, at_rest(1.0, 0.015, 0.018), 0.018, [0.0152, 0.0158, 0.0169])
    in_metres = run(
        metres,
        at_rest(1.0, 0.015 * 0.07, 0.018 * 0.07),
        0.018 * 0.07,
        [x * 0.07 for x in (0.0152, 0.0158, 0.0169)],
    )
    assert in_metres == pytest.approx(in_strain, rel=1e-9)


def test_integers_are_numbers_too_and_compile_nothing() -> None:
    step: Any = controller()._step
    known = set(step.signatures)
    assert PidState(*after(controller().start(1), 0, 0, 1).state).drive_voltage_v == 1.0
    assert set(step.signatures) == known


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"input_scal": 20.0}, "FuzzyPidSettings: unknown key 'input_scal'; did you mean 'input_scale'"),
        ({"kp_range": (0.1, 0.01)}, "kp_range: the least gain comes first"),
        ({"error_unit": 0.0}, "error_unit"),
    ],
)
def test_wrong_settings_are_refused_with_the_key(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(CallerError, match=message) as raised:
        FuzzyPidSettings(**settings)
    assert "\n" not in str(raised.value)


def test_settings_default_to_the_paper() -> None:
    settings = FuzzyPidSettings()
    assert settings.kp_range == (0.01, 0.11)
    assert settings.ki_range == (0.02, 0.06)
    assert settings.kd_range == (0.0005, 0.001)
    assert settings.rule_base == "zhao-1993"


@pytest.mark.parametrize(
    ("sense", "maximum", "message"),
    [(0.0, 3.0, "Eq. 1"), (-1.0, 3.0, "above zero"), (3.0, 3.0, "must be below"), (0.4, math.nan, "finite")],
)
def test_limits_without_room_or_without_sense_current_are_refused(sense: float, maximum: float, message: str) -> None:
    with pytest.raises(CallerError, match=message):
        DriveLimits(sense, maximum)


@given(st.floats(allow_nan=False))
def test_clamp_returns_a_drive_inside_and_keeps_one_that_is(drive: float) -> None:
    clamped = LIMITS.clamp(drive)
    assert LIMITS.sense_voltage_v <= clamped <= LIMITS.maximum_voltage_v
    assert LIMITS.clamp(clamped) == clamped
    assert clamped == drive or not LIMITS.sense_voltage_v <= drive <= LIMITS.maximum_voltage_v
