"""The first heating of a run is compared with the model's slow loop by the height at which its resistance turns."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.experiment import run_warnings
from musclewire.judge import JudgedLoop, judgement_of
from musclewire.judge._first_heating import SeenAtB, seen_at_b
from musclewire.signals import Recording

PERIOD_S = 0.05
MODEL = {"model_b_ohm": 20.0, "model_c_ohm": 17.0, "model_rise_ohm": 0.2, "model_b_std_ohm": 0.012}
FACTS = {"limit_sense_voltage_v": 0.3, "limit_maximum_voltage_v": 3.6, "approach_s": 0.0, "sample_period_s": PERIOD_S}


def heated(
    scale: float = 1.0, from_ohm: float = 19.8, per_s: float = 4.0, resting: int = 3, **stated: float | str
) -> Recording:
    """A run that rests and then heats past B at 20 ohm to 17.5 ohm, where it stays, with its resistance scaled."""
    rest_s = PERIOD_S * resting
    time_s = PERIOD_S * np.arange(1, 401)
    warmth = np.clip(per_s * (time_s - rest_s), 0.0, None)
    rise_ohm = 20.0 - from_ohm
    # Two parabolas that meet at B without a corner: up within a unit of warmth, and down to 17.5 ohm.
    ohm = np.where(warmth < 1.0, 20.0 - rise_ohm * (1.0 - warmth) ** 2, 20.0 - 0.5 * (warmth - 1.0) ** 2)
    columns = {
        "time_s": time_s,
        "drive_voltage_v": np.where(time_s <= rest_s + 0.5 * PERIOD_S, 0.3, 3.0),
        "wire_resistance_ohm": scale * np.maximum(ohm, 17.5),
        "target_strain": np.full(400, 0.02),
        "estimated_strain": np.full(400, 0.02),
        "valid": np.ones(400),
    }
    return Recording(columns, {**FACTS, **MODEL, **stated})


def at_b(run: Recording) -> SeenAtB | None:
    return seen_at_b(JudgedLoop(run))


@pytest.mark.parametrize("per_s", [0.4, 4.0, 12.0], ids=["slow", "as by default", "three samples around B"])
def test_a_scale_of_the_resistance_is_read_off_b_however_fast_the_wire_is_heated(per_s: float) -> None:
    same, other = at_b(heated(per_s=per_s)), at_b(heated(1.005, per_s=per_s))
    assert same is not None
    assert other is not None
    assert not same.is_away
    assert other.is_away
    # 0.5 % of 20 ohm is a thirtieth of the span.
    assert other.away_pct - same.away_pct == pytest.approx(100.0 * 0.005 * 20.0 / 3.0, abs=0.05)
    assert same.away_pct == pytest.approx(0.0, abs=0.5)


def test_a_cold_reading_that_noise_has_raised_does_not_make_a_cold_wire_warm() -> None:
    run = heated()
    ohm = run["wire_resistance_ohm"] + np.where(np.arange(400) == 2, 0.15, 0.0)
    assert at_b(Recording({**run.columns, "wire_resistance_ohm": ohm}, run.metadata)) == at_b(run)


def test_a_reading_of_little_current_above_b_is_noise_and_not_b() -> None:
    run = heated(resting=8)
    ohm = run["wire_resistance_ohm"] + np.where(np.arange(400) == 5, 0.5, 0.0)
    noisy, clean = at_b(Recording({**run.columns, "wire_resistance_ohm": ohm}, run.metadata)), at_b(run)
    assert noisy is not None
    assert clean is not None
    assert noisy[:2] == clean[:2]


def test_a_noisy_run_knows_its_b_less_well() -> None:
    run, noise = heated(resting=20), np.random.default_rng(1).standard_normal(400)
    at_drive_ohm = 0.03 * noise * 3.0 / run["drive_voltage_v"]
    noisy = at_b(
        Recording({**run.columns, "wire_resistance_ohm": run["wire_resistance_ohm"] + at_drive_ohm}, run.metadata)
    )
    assert noisy is not None
    # Four deviations of 0.012 ohm that the model states and of 0.03 ohm, of a span of 3 ohm.
    assert noisy.limit_pct == pytest.approx(100.0 * 4.0 * np.hypot(0.012, 0.03) / 3.0, rel=0.5)
    assert noisy.limit_pct > 2.0 * 100.0 * 4.0 * 0.012 / 3.0


@pytest.mark.parametrize("scale", [0.99, 1.01])
def test_a_b_at_another_height_is_named_with_its_number_and_does_not_hold(scale: float) -> None:
    run = heated(scale)
    (found,) = judgement_of(run).findings
    assert found.key == "other_height_of_b"
    assert found.from_s == pytest.approx(0.4, abs=0.1)
    assert judgement_of(run).does_not_hold
    side = "above" if scale > 1.0 else "below"
    assert judgement_of(run).metadata["health"].startswith("changed load or resistance at 0.4")
    assert f"% of the span from B to C {side} the model's, and repeats within 1.6 %" in run_warnings(run)[0]


def test_what_the_bench_repeats_to_is_no_finding() -> None:
    run = heated(1.002)
    assert judgement_of(run).findings == ()
    assert run_warnings(run) == ()
    assert not judgement_of(run).does_not_hold


@pytest.mark.parametrize(
    ("run", "why"),
    [
        (heated(0.99, from_ohm=19.98), "warm: on its way to B"),
        (heated(0.9), "hot: begins with austenite in it"),
        (heated(per_s=0.01), "ended before B"),
    ],
    ids=lambda given: given if isinstance(given, str) else "",
)
def test_a_run_that_did_not_pass_b_from_cold_says_that_it_is_not_compared(run: Recording, why: str) -> None:
    assert at_b(run) is None, why
    assert judgement_of(run).findings == ()
    assert "the wire did not pass B from cold" in run_warnings(run)[0]
    assert not judgement_of(run).does_not_hold


def test_a_rise_without_heat_is_a_cooling_wire_and_no_b() -> None:
    cooling = heated(0.97, resting=3)
    drive_v = np.where(cooling["time_s"] < 0.45, 0.3, 3.0)
    run = Recording({**cooling.columns, "drive_voltage_v": drive_v}, cooling.metadata)
    assert at_b(run) is None


def test_a_model_that_states_no_b_is_quoted_and_compared_with_nothing() -> None:
    run = heated(0.9)
    facts = {name: value for name, value in run.metadata.items() if name not in MODEL}
    silent = Recording(dict(run.columns), {**facts, "b_not_compared": "states no loop"})
    assert run_warnings(silent) == ("states no loop",)
    assert run_warnings(Recording(dict(run.columns), facts)) == ()
