"""A resistance that jumps at a steady drive is a bad contact; one above all of the slow loop is none of its wire."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.experiment._first_heating import KnownB
from musclewire.experiment._health import does_not_hold, findings, health_warnings
from musclewire.experiment._odd_resistance import odd_in
from musclewire.sensing import Cause
from musclewire.signals import Recording

KNOWN = KnownB(b_ohm=20.0, c_ohm=17.0, rise_ohm=0.2, std_ohm=0.012, highest_ohm=20.0, sense_voltage_v=0.3)
SPAN_OHM = KNOWN.b_ohm - KNOWN.c_ohm
COUNT, PERIOD_S = 1200, 0.05
TIME_S = PERIOD_S * np.arange(1, COUNT + 1)


def followed(noise_ohm: float = 0.002, drive_v: float = 2.0, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Resistance and drive of a wire that is heated fast and cooled between two levels, every 10 s."""
    hot = (TIME_S % 10.0) < 5.0
    target_ohm = np.where(hot, 17.6, 19.0)
    resistance_ohm = np.empty(COUNT)
    now_ohm = 19.0
    for row in range(COUNT):
        now_ohm += (target_ohm[row] - now_ohm) * PERIOD_S / (0.1 if hot[row] else 0.6)
        resistance_ohm[row] = now_ohm
    drive = np.where(hot, drive_v, 0.6 * drive_v)
    noise = np.random.default_rng(seed).standard_normal(COUNT) * noise_ohm * drive_v / drive
    return resistance_ohm + noise, drive


def contact(resistance_ohm: np.ndarray, part: float, first_s: float, last_s: float) -> np.ndarray:
    """The same with a contact that adds a part of the span between two times."""
    return resistance_ohm + part * SPAN_OHM * ((first_s < TIME_S) & (last_s >= TIME_S))


def odd(resistance_ohm: np.ndarray, drive_v: np.ndarray) -> tuple[list[int], float, int, float]:
    found = odd_in(KNOWN, resistance_ohm, drive_v)
    return found.jumps.tolist(), found.largest_jump_pct, found.above.size, found.above_pct


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("noise_ohm", [0.0, 0.002, 0.02, 0.1])
def test_a_wire_that_moves_has_no_bad_contact_however_noisy(noise_ohm: float, seed: int) -> None:
    jumps, _, above, _ = odd(*followed(noise_ohm, seed=seed))
    assert (jumps, above) == ([], 0)


@pytest.mark.parametrize(("first_s", "last_s"), [(23.225, 23.9), (28.025, 28.5)])
def test_a_contact_that_comes_loose_is_a_jump_at_its_row(first_s: float, last_s: float) -> None:
    resistance_ohm, drive = followed()
    jumps, largest_pct, _, _ = odd(contact(resistance_ohm, 0.12, first_s, last_s), drive)
    assert jumps == [round(first_s / PERIOD_S)]
    assert largest_pct == pytest.approx(12.0, abs=1.0)


def test_a_reading_that_steps_with_the_current_is_no_jump() -> None:
    resistance_ohm, drive = followed()
    offset = np.where(drive > 1.9, 0.2 * SPAN_OHM, 0.0)
    assert odd(resistance_ohm - 0.5 + offset, drive)[0] == []


def test_noise_hides_a_jump_and_is_none() -> None:
    resistance_ohm, drive = followed(0.1)
    assert odd(contact(resistance_ohm, 0.08, 23.2, 23.9), drive)[0] == []


def test_a_resistance_above_all_of_the_loop_is_none_of_its_wire() -> None:
    resistance_ohm, drive = followed()
    _, _, above, above_pct = odd(resistance_ohm + 1.3, drive)
    assert above > 100
    assert above_pct == pytest.approx(100.0 * 0.3 / SPAN_OHM, abs=1.0)
    higher = KNOWN._replace(highest_ohm=20.5)  # a wire that turns higher when it cools
    assert odd_in(higher, resistance_ohm + 1.3, drive).above.size == 0
    assert odd(resistance_ohm + 1.3, np.full(COUNT, 0.5))[2] == 0  # read with little current


def test_few_rows_show_nothing() -> None:
    for count in range(8):
        found = odd_in(KNOWN, np.full(count, 18.0), np.full(count, 2.0))
        assert (found.jumps.size, found.above.size) == (0, 0)


def loop(resistance_ohm: np.ndarray, drive_v: np.ndarray) -> Recording:
    """A closed loop on a model whose slow loop is known."""
    current_a = drive_v / (resistance_ohm + 1.0)
    columns = {
        "time_s": TIME_S,
        "drive_voltage_v": drive_v,
        "wire_voltage_v": current_a * resistance_ohm,
        "wire_resistance_ohm": resistance_ohm,
        "target_strain": np.full(COUNT, 0.02),
        "estimated_strain": np.full(COUNT, 0.02),
        "valid": np.ones(COUNT),
    }
    facts = {
        "model_b_ohm": KNOWN.b_ohm,
        "model_c_ohm": KNOWN.c_ohm,
        "model_highest_ohm": KNOWN.highest_ohm,
        "model_rise_ohm": KNOWN.rise_ohm,
        "model_b_std_ohm": KNOWN.std_ohm,
        "limit_sense_voltage_v": KNOWN.sense_voltage_v,
        "sample_period_s": PERIOD_S,
        "approach_s": 0.0,
    }
    return Recording(columns, facts)


def test_a_loop_names_the_contact_from_its_first_jump_on_and_does_not_hold() -> None:
    resistance_ohm, drive = followed()
    twice = contact(contact(resistance_ohm, 0.12, 23.2, 23.9), 0.1, 44.0, 44.2)
    (found,) = findings(loop(twice, drive))
    assert (found.cause, round(found.from_s)) == (Cause.BAD_CONTACT, 23)
    assert "2 times, by up to 12 %" in health_warnings(loop(twice, drive))[0]
    assert does_not_hold(loop(twice, drive)) == "bad contact"
    assert not does_not_hold(loop(resistance_ohm, drive))


def test_a_loop_above_its_slow_loop_names_load_or_resistance() -> None:
    resistance_ohm, drive = followed()
    run = loop(resistance_ohm + np.clip(0.2 * (TIME_S - 12.0), 0.0, 2.0), drive)
    assert does_not_hold(run) == "changed load or resistance"
    assert "above all that the model's slow loop showed" in health_warnings(run)[0]
