"""What changed in mid-run is seen in the cooling after the loop, against the model's slow loop."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.experiment import run_warnings
from musclewire.judge import JudgedLoop, judgement_of
from musclewire.judge._cooling import seen_cooling
from musclewire.signals import COOLING_FROM, Recording

PERIOD_S, LOOP_S, COOLING_S = 0.05, 4.0, 8.0
LOOP, COOLING = round(LOOP_S / PERIOD_S), round(COOLING_S / PERIOD_S)
HIGHEST_OHM = 19.9
FACTS = {
    "model_b_ohm": 20.0,
    "model_c_ohm": 17.0,
    "model_rise_ohm": 0.2,
    "model_b_std_ohm": 0.012,
    "model_cooling_ohm": HIGHEST_OHM,
    "shunt_resistance_ohm": 1.0,
    "sample_period_s": PERIOD_S,
    "approach_s": 0.0,
    "limit_sense_voltage_v": 0.3,
    "limit_maximum_voltage_v": 3.6,
    COOLING_FROM: LOOP_S,
}


def run(scale: float = 1.0, lag_s: float = 0.8, from_ohm: float = 18.0, noise_ohm: float = 0.0) -> Recording:
    """A loop that ends at a resistance and a wire that then cools, with its resistance scaled since mid-run."""
    time_s = PERIOD_S * np.arange(1, LOOP + COOLING + 1)
    cooling_s = np.maximum(time_s - LOOP_S, 0.0)
    ohm = scale * (HIGHEST_OHM - (HIGHEST_OHM - from_ohm) * np.exp(-cooling_s / lag_s))
    ohm += noise_ohm * np.random.default_rng(1).standard_normal(ohm.size)
    of_loop = np.where(cooling_s > 0.0, np.nan, 1.0)
    drive_v = np.where(cooling_s > 0.0, 0.3, 2.0)
    columns = {
        "time_s": time_s,
        "drive_voltage_v": drive_v,
        "wire_voltage_v": drive_v * ohm / (ohm + 1.0),
        "shunt_voltage_v": drive_v / (ohm + 1.0),
        "wire_resistance_ohm": ohm,
        "target_strain": 0.02 * of_loop,
        "estimated_strain": 0.02 * of_loop,
        "valid": of_loop,
    }
    return Recording(columns, FACTS)


@pytest.mark.parametrize("noise_ohm", [0.0, 0.03])
@pytest.mark.parametrize(("scale", "side"), [(1.01, "above"), (0.99, "below")])
def test_a_resistance_that_drifted_while_the_wire_was_hot_is_named_and_the_run_does_not_hold(
    scale: float, side: str, noise_ohm: float
) -> None:
    found = run(scale, noise_ohm=noise_ohm)
    (finding,) = judgement_of(found).findings
    assert finding.key == "other_height_of_b"
    assert judgement_of(found).does_not_hold
    assert "cooling after the loop, the highest resistance is" in run_warnings(found)[0]
    assert f"% of the span from B to C {side} the model's" in run_warnings(found)[0]


@pytest.mark.parametrize("noise_ohm", [0.0, 0.03, 0.1])
def test_a_wire_that_is_still_the_models_is_not_named(noise_ohm: float) -> None:
    seen = seen_cooling(JudgedLoop(run(noise_ohm=noise_ohm)))
    assert seen is not None
    assert not seen.is_away
    assert judgement_of(run(noise_ohm=noise_ohm)).findings == ()


def test_a_slow_wire_that_still_rises_is_not_taken_for_one_that_is_lower() -> None:
    assert judgement_of(run(lag_s=4.0)).findings == ()
    assert judgement_of(run(1.01, lag_s=2.0)).findings != ()


def test_a_wire_that_was_cold_by_the_end_of_its_loop_has_nothing_to_show() -> None:
    assert seen_cooling(JudgedLoop(run(0.99, from_ohm=HIGHEST_OHM - 0.03))) is None


def test_a_wire_that_was_hardly_hot_of_b_is_seen_to_turn() -> None:
    """As a gripper's at two fifths of its stroke, where the resistance has fallen by a twelfth."""
    seen = [seen_cooling(JudgedLoop(run(scale, from_ohm=19.65))) for scale in (1.0, 0.99, 1.01)]
    assert [one is not None and one.is_away for one in seen] == [False, True, True]
    assert None not in seen


def test_nobody_looked_or_the_model_does_not_say_it() -> None:
    found = run(1.01)
    without = {name: value for name, value in FACTS.items() if name != "model_cooling_ohm"}
    assert judgement_of(Recording(found.whole_columns, without)).findings == ()
    assert judgement_of(Recording(found.columns, FACTS)).findings == ()
