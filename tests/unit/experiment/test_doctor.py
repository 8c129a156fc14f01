"""The doctor finds each fault of the wiring by its check, heats nothing, and has no complaint about a sound rig."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from tests.contract.altered_device import AlteredDevice

import musclewire as mw
from musclewire.app import document, text
from musclewire.errors import CallerError
from musclewire.experiment import Examination, examine
from musclewire.rigs import Answer, Arriving, GuardedRig, HasTrueState, ability
from musclewire.signals import RawSample

Altered = Callable[[RawSample, int], RawSample]
SHUNT_OHM = 1.0


def examined(altered: Altered | None = None, *, meters: dict[str, float] | None = None, **settings: Any) -> Examination:
    """The examination of a simulated rig whose readings are altered below its protection, as a real fault would."""
    with mw.open_rig("simulated", **settings) as rig:
        if altered is not None:
            alter(rig, altered)
        return examine(rig, **(meters or {}))


def alter(rig: Any, altered: Altered) -> None:
    count: Iterator[int] = iter(range(10**9))
    rig.device = AlteredDevice(rig.device, lambda sample: altered(sample, next(count)))


def scaled(wire: float = 1.0, shunt: float = 1.0, wire_v: float = 0.0, shunt_v: float = 0.0) -> Altered:
    return lambda sample, _: sample._replace(
        wire_voltage_v=wire * sample.wire_voltage_v + wire_v, shunt_voltage_v=shunt * sample.shunt_voltage_v + shunt_v
    )


def noisy(wire_v: float, shunt_v: float) -> Altered:
    random = np.random.default_rng(5)
    return lambda sample, _: sample._replace(
        wire_voltage_v=sample.wire_voltage_v + wire_v * random.standard_normal(),
        shunt_voltage_v=sample.shunt_voltage_v + shunt_v * random.standard_normal(),
    )


def humming(sample: RawSample, _: int) -> RawSample:
    hum = 1e-3 * np.sin(2 * np.pi * 50.0 * sample.time_s)
    return sample._replace(shunt_voltage_v=sample.shunt_voltage_v + float(hum))


def coarse(sample: RawSample, _: int) -> RawSample:
    step = 5e-3
    return sample._replace(
        wire_voltage_v=step * round(sample.wire_voltage_v / step),
        shunt_voltage_v=step * round(sample.shunt_voltage_v / step),
    )


def long_leads(sample: RawSample, _: int) -> RawSample:
    fraction = (17.28 + SHUNT_OHM) / (17.28 + SHUNT_OHM + 3.0)
    return scaled(fraction, fraction)(sample, 0)


def ends_at_3_mv(sample: RawSample, _: int) -> RawSample:
    return sample._replace(shunt_voltage_v=min(sample.shunt_voltage_v, 3e-3))


def losing_samples(sample: RawSample, index: int) -> RawSample:
    return sample._replace(time_s=sample.time_s + 0.05 * (index // 25))


# Beside those that a rig file can name, which tests/app/test_doctor.py asks the command about.
FAULTS: dict[str, tuple[Altered, str, str]] = {
    "wire's pair reversed": (scaled(wire=-1.0), "wire_polarity", "exchange the two leads"),
    "shunt's pair reversed": (scaled(shunt=-1.0), "shunt_polarity", "exchange the two leads"),
    "shunt of 2.2 ohm": (scaled(shunt=2.2), "wire_resistance_ohm", "a shunt of 2.2 ohm instead of 1 ohm"),
    "leads of 4 ohm counted as wire": (scaled(wire=1.23, shunt=0.82), "wire_resistance_ohm", "two-wire"),
    "leads of 3 ohm outside": (long_leads, "outside_resistance_ohm", "leads"),
    "offset of 8 mV at the wire": (scaled(wire_v=8e-3), "wire_offset_v", "write it into the rig file"),
    "offset of 1 mV at the shunt": (scaled(shunt_v=1e-3), "shunt_offset_v", "write it into the rig file"),
    "noise at the wire": (noisy(8e-3, 0.0), "wire_noise_v", "twist"),
    "noise at the shunt": (noisy(0.0, 1e-3), "shunt_noise_v", "twist"),
    "noise in strain": (noisy(0.0, 3e-4), "resistance_noise_strain", "Too much"),
    "coarse converter": (coarse, "resolution_bits", "smaller input range"),
    "saturated wire channel": (scaled(wire=0.0, wire_v=10.0), "rig_kept_going", "end of its range"),
    "shunt channel with a range of 3 mV": (ends_at_3_mv, "readings_are_measurements", "the end of a range"),
    "amplifier's gain 1.5": (scaled(1.5, 1.5), "output_gain", "too many"),
    "samples lost": (losing_samples, "sample_period_s", "lost"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_found_by_its_check_with_advice_and_nothing_is_heated(fault: str) -> None:
    altered, name, words = FAULTS[fault]
    put_out: list[float] = []

    def watching(sample: RawSample, index: int) -> RawSample:
        put_out.append(sample.drive_voltage_v)
        return altered(sample, index)

    found = examined(watching)
    assert not found.ok
    assert name in found.findings.failed, found.findings
    check = next(check for check in found.findings.checks if check.name == name)
    assert words in check.advice
    assert max(put_out) <= 0.3 + 2e-4
    assert found.highest_v <= 0.3
    if name in {"wire_polarity", "output_gain", "readings_are_measurements"}:
        assert max(put_out) < 0.15


@pytest.mark.parametrize(
    ("measured_v", "arrived", "holds"), [(2.7, 0.9, True), (2.7, 1.0, False), (2.7, 0.8, False), (2.4, 0.8, True)]
)
def test_what_arrives_by_a_multimeter_is_compared_with_the_channels(
    measured_v: float, arrived: float, holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A channel that is 10 % wrong, which no order shows, and an order of which only 80 % arrive, which no fault is."""
    stated = Arriving(ordered=3.0, measured=measured_v, by="multimeter")
    with mw.open_rig("simulated") as rig:
        alter(rig, scaled(arrived, arrived))
        facts = {**rig.metadata(), **stated.facts()}
        limits = rig.protection_limits._replace(arriving_fraction=stated.fractions[1])
        monkeypatch.setattr(GuardedRig, "protection_limits", limits)
        monkeypatch.setattr(GuardedRig, "metadata", lambda _: facts)
        found = examine(rig)
    check = next(check for check in found.findings.checks if check.name == "output_gain")
    assert check.ok is holds
    least, largest = 0.98 * measured_v / 3.0, 1.02 * measured_v / 3.0
    assert f"by multimeter {least:.3f} to {largest:.3f} ([arrives] of the rig file)" in check.advice
    assert ("measure again, and correct what differs" in check.advice) is not holds


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("step_v", [5e-4, 1e-3, 5e-3])
@pytest.mark.parametrize("is_open", [False, True])
def test_coarse_steps_are_not_taken_for_the_end_of_a_range(seed: int, step_v: float, *, is_open: bool) -> None:
    random = np.random.default_rng(seed)

    def coarsely(sample: RawSample, _: int) -> RawSample:
        wire_v = sample.drive_voltage_v if is_open else sample.wire_voltage_v
        shunt_v = 0.0 if is_open else sample.shunt_voltage_v
        wire_v, shunt_v = np.array([wire_v, shunt_v]) + 1e-4 * random.standard_normal(2)
        return sample._replace(
            wire_voltage_v=step_v * round(wire_v / step_v), shunt_voltage_v=step_v * round(shunt_v / step_v)
        )

    assert "readings_are_measurements" not in examined(coarsely, seed=seed).findings.failed


def test_hum_is_found_where_the_samples_come_fast_enough() -> None:
    found = examined(humming, sample_period_s=1e-3, acquisition_readings=10)
    check = next(check for check in found.findings.checks if check.name == "mains_hum_v")
    assert not check.ok
    assert check.value == pytest.approx(1e-3 / np.sqrt(2), rel=0.05)
    assert "50 Hz" in check.advice


@pytest.mark.parametrize("seed", range(1, 9))
@pytest.mark.parametrize("wire", ["paper-100um", "paper-125um", "paper-200um", "finger-100um", "flexinol-0.15-lt"])
def test_a_sound_rig_passes_every_check(wire: str, seed: int) -> None:
    found = examined(wire=wire, seed=seed)
    assert found.findings.failed == frozenset()
    assert found.ok
    assert len(found.findings.checks) >= 24


def test_a_sound_rig_of_a_thousand_samples_a_second_passes_too() -> None:
    found = examined(sample_period_s=1e-3, acquisition_readings=1)
    assert found.findings.failed == frozenset()
    assert "mains_hum_v" in {check.name for check in found.findings.checks}


def test_the_wire_stays_cold_as_the_examination_says_and_the_rig_is_left_at_its_sense_voltage() -> None:
    with mw.open_rig("simulated") as rig:
        start_k = ability(rig, HasTrueState).wire_state.temperature_k
        found = examine(rig)
        warmer_k = ability(rig, HasTrueState).wire_state.temperature_k - start_k
        assert rig.drive_voltage_v == pytest.approx(0.3, abs=2e-4)
    assert warmer_k < 1.5
    said = next(check.value for check in found.findings.checks if check.name == "sense_warming_k")
    assert said == pytest.approx(warmer_k, rel=0.15)


def test_a_wire_that_is_still_hot_shows_by_its_drift() -> None:
    with mw.open_rig("simulated", sense_voltage_v="0.3 V", wire="flexinol-0.38-lt", pretension_n=5.0) as rig:
        for _ in range(60):
            rig.exchange(0.6 * rig.maximum_voltage_v)
        found = examine(rig)
    assert "sense_drift" in found.findings.failed or "wire_resistance_ohm" in found.findings.failed


def test_a_fault_that_trips_the_protection_is_a_finding_beside_what_was_seen_before() -> None:
    def lost_at_sense(sample: RawSample, _: int) -> RawSample:
        return scaled(shunt=0.0)(sample, 0) if sample.drive_voltage_v > 0.2 else sample

    found = examined(lost_at_sense)
    assert found.trouble is not None
    assert "no current through the wire" in str(found.trouble)
    assert found.highest_v == 0.3
    assert not found.ok
    assert "wire_resistance_ohm" in {check.name for check in found.findings.checks}


def test_offsets_and_a_meter_give_a_calibration_that_puts_the_readings_right() -> None:
    wrong = scaled(wire=1.02, shunt=0.97, wire_v=4e-3, shunt_v=-3e-4)
    true = {"wire": 0.3 * 17.28 / 18.28, "shunt": 0.3 / 18.28}
    found = examined(wrong, meters={"meter_wire_v": true["wire"], "meter_shunt_v": true["shunt"]})
    wire, shunt = found.calibration
    assert (wire.channel, shunt.channel) == ("wire", "shunt")
    assert wire.offset_v == pytest.approx(4e-3, abs=5e-5)
    assert shunt.offset_v == pytest.approx(-3e-4, abs=5e-5)
    assert wire.gain == pytest.approx(1 / 1.02, rel=0.003)
    assert shunt.gain == pytest.approx(1 / 0.97, rel=0.01)


def test_a_meter_that_measures_something_else_is_refused() -> None:
    with pytest.raises(CallerError, match="check where the meter was"):
        examined(meters={"meter_wire_v": 3.0})


def test_a_clock_that_runs_at_another_pace_is_found() -> None:
    with mw.open_rig("simulated") as rig:
        seconds = [0.0]
        paced = PacedInName(rig)

        def slow(answer: Answer) -> Answer:
            seconds[0] += 1.08 * rig.sample_period_s
            return answer

        rig.device = AlteredDevice(rig.device, slow)
        found = examine(paced, clock=lambda: seconds[0])
    assert "clock_rate" in found.findings.failed
    assert next(c.value for c in found.findings.checks if c.name == "clock_rate") == pytest.approx(1.08, rel=1e-3)


class PacedInName:
    """A rig that says that a clock paces it, for tests that bring their own clock."""

    paced = True

    def __init__(self, rig: Any) -> None:
        self._rig = rig

    def __getattr__(self, name: str) -> Any:
        return getattr(self._rig, name)


@pytest.mark.parametrize("seed", range(120))
def test_whatever_the_channels_say_the_answer_is_plain_numbers_and_nothing_is_heated(seed: int) -> None:
    random = np.random.default_rng(seed)
    kinds = (0.0, 1.0, -1.0, 1e3, 1e-6, float("nan"), float("inf"), 1e300)
    factors, offsets = random.choice(kinds, 2), random.choice((0.0, 0.0, 1e-3, 0.1, 11.0, -3.0, float("nan")), 2)
    noise = random.choice((0.0, 1e-3, 1.0))

    def garbled(sample: RawSample, _: int) -> RawSample:
        wire, shunt = random.standard_normal(2) * noise
        return sample._replace(
            wire_voltage_v=float(factors[0] * sample.wire_voltage_v + offsets[0] + wire),
            shunt_voltage_v=float(factors[1] * sample.shunt_voltage_v + offsets[1] + shunt),
        )

    found = examined(garbled)
    json.dumps(document("rig", found, None).model_dump(mode="json"), allow_nan=False)
    assert text(found)
    assert found.highest_v <= 0.3


def test_an_examination_that_is_interrupted_leaves_the_rig_safe() -> None:
    def interrupted(_: RawSample) -> None:
        raise KeyboardInterrupt

    with mw.open_rig("simulated") as rig:
        with pytest.raises(KeyboardInterrupt):
            examine(rig, on_sample=interrupted)
        assert rig.drive_voltage_v <= 0.3 + 2e-4
