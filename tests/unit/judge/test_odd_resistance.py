"""A resistance that jumps at a steady drive is a bad contact; one above all of the slow loop is none of its wire."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.judge import JudgedLoop, KnownB, judgement_of, odd_resistance
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


def loop(resistance_ohm: np.ndarray, drive_v: np.ndarray, known: KnownB = KNOWN, **columns: np.ndarray) -> Recording:
    """A closed loop on a model whose slow loop is known."""
    count = resistance_ohm.size
    usual = {
        "time_s": PERIOD_S * np.arange(1, count + 1),
        "drive_voltage_v": drive_v,
        "wire_resistance_ohm": resistance_ohm,
        "target_strain": np.full(count, 0.02),
        "estimated_strain": np.full(count, 0.02),
        "valid": np.ones(count),
    }
    facts = {
        "model_b_ohm": known.b_ohm,
        "model_c_ohm": known.c_ohm,
        "model_highest_ohm": known.highest_ohm,
        "model_rise_ohm": known.rise_ohm,
        "model_b_std_ohm": known.std_ohm,
        "limit_sense_voltage_v": known.sense_voltage_v,
        "sample_period_s": PERIOD_S,
        "approach_s": 0.0,
    }
    return Recording({**usual, **columns}, facts)


def odd(resistance_ohm: np.ndarray, drive_v: np.ndarray, known: KnownB = KNOWN) -> tuple[list[int], float, int, float]:
    found = odd_resistance(JudgedLoop(loop(resistance_ohm, drive_v, known)))
    return found.jumps.tolist(), found.largest_jump_pct, found.above.size, found.above_pct


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("noise_ohm", [0.0, 0.002, 0.02, 0.1])
def test_a_wire_that_moves_has_no_bad_contact_however_noisy(noise_ohm: float, seed: int) -> None:
    jumps, _, above, _ = odd(*followed(noise_ohm, seed=seed))
    assert (jumps, above) == ([], 0)


@pytest.mark.parametrize("within", [0.0, 0.25, 0.5, 0.75], ids=lambda part: f"at {part:g} of a sample")
@pytest.mark.parametrize("first", [465, 562], ids=["hot", "cooling"])
def test_a_contact_that_comes_loose_is_a_jump_whenever_in_its_sample(first: int, within: float) -> None:
    resistance_ohm, drive = followed()
    resistance_ohm[first + 1 : first + 12] += 0.12 * SPAN_OHM
    resistance_ohm[first] += (1.0 - within) * 0.12 * SPAN_OHM  # a reading is a mean over its sample
    jumps, largest_pct, _, _ = odd(resistance_ohm, drive)
    assert len(jumps) == 1
    assert abs(jumps[0] - first) <= 1
    assert largest_pct == pytest.approx(12.0, abs=1.5)


def test_a_reading_that_steps_with_the_current_is_no_jump() -> None:
    resistance_ohm, drive = followed()
    offset = np.where(drive > 1.9, 0.2 * SPAN_OHM, 0.0)
    assert odd(resistance_ohm - 0.5 + offset, drive)[0] == []


def test_a_single_odd_reading_is_a_spike_and_no_jump() -> None:
    for row in range(440, 560, 3):
        resistance_ohm, drive = followed()
        resistance_ohm[row] += 0.3 * SPAN_OHM
        assert odd(resistance_ohm, drive)[0] == []


def test_the_steps_of_a_coarse_converter_are_no_jumps() -> None:
    resistance_ohm, drive = followed()
    for step in (0.02, 0.05, 0.1):
        coarse = np.round(resistance_ohm / (step * SPAN_OHM)) * step * SPAN_OHM
        assert odd(coarse, drive)[0] == []


def test_nothing_is_compared_across_rows_that_are_missing() -> None:
    resistance_ohm, drive = followed()
    there = np.ones(COUNT, dtype=bool)
    there[470:490] = there[520:521] = False
    resistance_ohm[490:] += 0.2 * SPAN_OHM * (np.arange(COUNT)[490:] < 520)
    run = loop(resistance_ohm, drive)
    lost = Recording({name: values[there] for name, values in run.columns.items()}, run.metadata)
    silent = loop(np.where(there, resistance_ohm, 0.0), drive)
    assert [odd_resistance(JudgedLoop(one)).jumps.size for one in (lost, silent)] == [0, 0]


def test_noise_hides_a_jump_and_is_none() -> None:
    resistance_ohm, drive = followed(0.1)
    assert odd(contact(resistance_ohm, 0.08, 23.225, 23.9), drive)[0] == []


def test_a_resistance_above_all_of_the_loop_is_none_of_its_wire() -> None:
    resistance_ohm, drive = followed()
    _, _, above, above_pct = odd(resistance_ohm + 1.3, drive)
    assert above > 100
    assert above_pct == pytest.approx(100.0 * 0.3 / SPAN_OHM, abs=1.0)
    # A wire that turns higher when it cools; readings with little current; a noisy run.
    assert odd(resistance_ohm + 1.3, drive, KNOWN._replace(highest_ohm=20.5))[2] == 0
    assert odd(resistance_ohm + 1.3, np.full(COUNT, 0.5))[2] == 0
    at_b = 20.0 + 0.06 * np.random.default_rng(1).standard_normal(2000)
    assert odd(at_b, np.full(2000, 2.0))[2] == 0


def test_few_rows_or_no_span_show_nothing() -> None:
    for count in range(10):
        assert odd(np.full(count, 18.0), np.full(count, 2.0)) == ([], 0.0, 0, 0.0)
    assert odd(*followed(), KNOWN._replace(c_ohm=20.0)) == ([], 0.0, 0, 0.0)
    endless = np.where(np.arange(COUNT) == 500, np.inf, followed()[0])
    assert odd(endless, followed()[1])[0] == []


def test_a_loop_names_the_contact_from_its_first_jump_on_and_does_not_hold() -> None:
    resistance_ohm, drive = followed()
    twice = contact(contact(resistance_ohm, 0.12, 23.2, 23.9), 0.1, 44.0, 44.2)
    (found,) = judgement_of(loop(twice, drive)).findings
    assert (found.key, round(found.from_s)) == ("bad_contact", 23)
    assert "2 times, by up to 12 %" in judgement_of(loop(twice, drive)).warnings[0]
    assert judgement_of(loop(twice, drive)).does_not_hold == "bad contact"
    assert not judgement_of(loop(resistance_ohm, drive)).does_not_hold


def test_a_loop_above_its_slow_loop_names_load_or_resistance() -> None:
    resistance_ohm, drive = followed()
    run = loop(resistance_ohm + np.clip(0.2 * (TIME_S - 12.0), 0.0, 2.0), drive)
    assert judgement_of(run).does_not_hold == "changed load or resistance"
    assert "above all that the model's slow loop showed" in judgement_of(run).warnings[0]
