"""What a page is sent of a bench's rows: thinned by the clock, completed by Eq. 1, and the rules that fired."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import musclewire as mw
from musclewire.controllers import ConstantRules, ZhaoRules, infer_ratios, load_rule_base, rule_base_names
from musclewire.extras.live._server.fired_rules import FiredRules, InputRatios, fired
from musclewire.extras.live._server.frames import COMPUTED, FrameMaker, thinned, with_computed
from musclewire.extras.live._server.json_texts import MAX_BYTES, compact, read_json

COLUMNS = ("time_s", "wire_voltage_v", "shunt_voltage_v")


@pytest.mark.parametrize(
    ("rate_hz", "clock_speed", "kept_per_s"), [(20, 1, 20), (100, 1, 100), (1000, 1, 100), (20, 10, 10)]
)
def test_at_most_100_rows_a_second_of_the_wall_clock_are_kept_and_every_one_of_a_slow_loop(
    rate_hz: int, clock_speed: int, kept_per_s: int
) -> None:
    time_s = np.arange(5 * rate_hz) / rate_hz
    assert thinned(time_s, 0.01 * clock_speed, -np.inf).sum() == 5 * kept_per_s


@pytest.mark.parametrize(("state", "kept_per_s"), [({}, 100), ({"clock_speed": None}, 100), ({"clock_speed": 10}, 10)])
def test_a_frame_is_thinned_by_the_speed_of_the_benchs_clock(state: dict[str, float | None], kept_per_s: int) -> None:
    time_s = np.arange(5000) / 1000.0
    frame = FrameMaker().frame(0, ("time_s",), time_s[:, np.newaxis], state)
    assert len(frame.rows) == 5 * kept_per_s


@given(st.lists(st.integers(1, 50), min_size=1, max_size=40))
def test_what_is_kept_does_not_depend_on_the_portions_in_which_rows_come(sizes: list[int]) -> None:
    time_s = 0.3 + np.arange(sum(sizes)) * 0.001
    whole, kept, last = thinned(time_s, 0.01, -np.inf), [], -np.inf
    for portion in np.split(time_s, np.cumsum(sizes)[:-1]):
        kept.append(thinned(portion, 0.01, last))
        last = portion[-1]
    assert np.array_equal(np.concatenate(kept), whole)


def test_current_power_and_resistance_are_those_of_ohms_law() -> None:
    rows = np.array([[0.0, 3.0, 0.5], [0.1, 1.0, 0.0]])
    names, complete = with_computed(COLUMNS, rows, 2.0)
    assert names == (*COLUMNS, *COMPUTED)
    assert complete[0, 3:] == pytest.approx([0.25, 0.75, 12.0])
    assert complete[1, 3:5] == pytest.approx([0.0, 0.0])
    assert np.isnan(complete[1, 5])


@given(st.lists(st.lists(st.floats(), min_size=2, max_size=2), max_size=10))
def test_rows_as_json_have_null_for_what_is_not_finite_and_else_the_same_numbers(rows: list[list[float]]) -> None:
    array = np.array(rows, float).reshape(-1, 2)
    back = np.array(json.loads(compact(array.tolist())), float).reshape(-1, 2)
    assert np.array_equal(back, np.where(np.isfinite(array), array, np.nan), equal_nan=True)


@pytest.mark.parametrize("name", rule_base_names())
@given(error=st.floats(-1.5, 1.5), change=st.floats(-1.5, 1.5))
def test_the_fired_rules_give_the_gains_that_the_controllers_kernel_infers(
    name: str, error: float, change: float
) -> None:
    """The kernel is the oracle: from weights and cells alone the same K_p ratio must follow (Zhao's closed form)."""
    base = load_rule_base(name)
    rules = fired(base, InputRatios(error, change))
    if isinstance(base.rules, ConstantRules):
        assert rules == []
    elif isinstance(base.rules, ZhaoRules):
        # Where a rule fires with weight mu, Small says exp(-4 mu) and Big 1 - exp(-4 mu), each weighted by mu.
        mu = np.array([rule.weight for rule in rules])
        small = np.exp(-4 * mu)
        says = np.where([rule.kp == "B" for rule in rules], 1 - small, small)
        assert mu.sum() == pytest.approx(1.0)
        assert (mu * says).sum() == pytest.approx(infer_ratios(base, error, change).kp, abs=1e-9)
    else:
        assert [rule.weight for rule in rules] == sorted((rule.weight for rule in rules), reverse=True)
        assert rules


def test_the_inputs_followed_from_recorded_rows_give_the_gains_that_were_recorded() -> None:
    """Of a real closed loop every gain in the recording is recomputed from targets and estimates alone."""
    with mw.open_rig("simulated") as rig:
        model = mw.fit(mw.characterize(rig, cycles=1, period_s=30.0))
        run = mw.control(rig, model, mw.staircase(stop=0.018, hold_s=2.0), controller="fuzzy-pid")
    names = [name for name in run.names if name != "time_s"]
    rows = np.column_stack([run[name] for name in names])
    settings = mw.FuzzyPidSettings()
    follower, gain = FiredRules(settings, 0.05), run["proportional_gain"]
    compared = 0
    for index in range(1, len(rows)):
        follower.follow(names, rows[index - 1 : index + 1] if index == 1 else rows[index : index + 1])
        before = gain[index - 1]
        if follower.inputs is not None and before > 0.0:
            ratio = infer_ratios(follower.rule_base, *follower.inputs).kp
            low, high = settings.kp_range
            assert low + ratio * (high - low) == pytest.approx(before, rel=1e-6)
            compared += 1
    assert compared > 200


def test_no_rule_has_fired_before_two_rows_and_then_those_of_the_inputs_followed() -> None:
    follower = FiredRules(mw.FuzzyPidSettings(), 0.05)
    follower.add_sample(0.01, 0.004, held=False)
    assert follower.rules() == []
    follower.add_sample(0.01, 0.005, held=False)
    assert follower.inputs is not None
    assert follower.rules() == fired(follower.rule_base, follower.inputs) != []
    follower.forget()
    assert follower.rules() == []


def test_a_frame_has_no_rules_without_a_fuzzy_pid() -> None:
    state = {"rig": {"shunt_resistance_ohm": 2.0, "sample_period_s": 0.05}, "clock_speed": 1.0, "gains": None}
    frame = FrameMaker().frame(1, COLUMNS, np.array([[0.0, 1.0, 0.5], [0.05, 1.0, 0.5]]), state)
    assert frame.rules is None
    assert frame.rows.shape == (2, 6)


@pytest.mark.parametrize("text", ["NaN", "[1e999999, Infinity]", "[" * 100_000, "{", "\ud800", "9" * 10_000])
def test_what_is_no_json_or_has_no_end_is_one_line(text: str) -> None:
    with pytest.raises(mw.MusclewireError) as caught:
        read_json(text)
    assert len(str(caught.value).splitlines()) == 1


def test_a_text_that_is_too_long_is_not_even_looked_at() -> None:
    with pytest.raises(mw.MusclewireError, match="at most"):
        read_json(" " * (MAX_BYTES + 1))
