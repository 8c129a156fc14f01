"""What every rig must do, simulated or real: one suite over all of them.

A rig joins by a subject in a module named ``*_rigs.py``, here or in the folder of an extra; its wire is assumed to be
cold and at rest when it has been opened.
"""

from __future__ import annotations

import logging
import math
import re
import signal
import threading
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from types import FrameType

import numpy as np
import pytest
from tests.contract.rig_subject import RigSubject
from tests.subjects import subjects_of

from musclewire.errors import CallerError, RigError
from musclewire.rigs import GuardedRig, HasStage, Rig, ability, open_rig
from musclewire.signals import REFERENCE_COLUMNS, RawSample

METADATA_KEYS = {
    "rig",
    "wire",
    "wire_diameter_m",
    "wire_length_m",
    "leg_length_m",
    "shunt_resistance_ohm",
    "maximum_force_n",
    "pretension_n",
    "sample_period_s",
}


SUBJECTS: list[RigSubject] = sorted(subjects_of("contract", "*_rigs.py", "SUBJECTS"), key=lambda subject: subject.name)


@pytest.fixture(params=[pytest.param(subject, id=subject.name, marks=subject.group) for subject in SUBJECTS])
def subject(request: pytest.FixtureRequest) -> RigSubject:
    found: RigSubject = request.param
    return found


@pytest.fixture
def rig(subject: RigSubject, request: pytest.FixtureRequest, tmp_path: Path) -> Rig:
    return subject.opened(request, tmp_path)


def test_time_rises_by_the_sample_period(rig: Rig) -> None:
    with rig:
        times = [rig.exchange(rig.sense_voltage_v).time_s for _ in range(20)]
    steps = [after - before for before, after in pairwise(times)]
    assert steps == pytest.approx([rig.sample_period_s] * 19, rel=1e-6)


def test_what_outlives_closing_has_an_identity_and_a_simulated_wire_has_none(rig: Rig, subject: RigSubject) -> None:
    with rig:
        identity = rig.device.facts.identity
    assert (identity is not None) == subject.emulated
    assert identity != ""


def test_the_drive_is_off_before_and_after(rig: Rig) -> None:
    assert rig.drive_voltage_v == 0.0
    with rig as entered:
        assert entered is rig
        rig.exchange(1.0)
        assert rig.drive_voltage_v > 0.0
    assert rig.drive_voltage_v == 0.0


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_the_drive_is_off_after_whatever_happened_inside(rig: Rig, error: type[BaseException]) -> None:
    def stop_in_the_middle() -> None:
        with rig:
            rig.exchange(1.0)
            raise error("anything")

    with pytest.raises(error):
        stop_in_the_middle()
    assert rig.drive_voltage_v == 0.0


def test_make_safe_goes_to_the_sense_voltage_at_once(rig: Rig) -> None:
    with rig:
        rig.exchange(rig.drive_amplitude_v)
        rig.make_safe()
        assert rig.drive_voltage_v == rig.sense_voltage_v
        rig.make_safe()
        assert rig.drive_voltage_v == rig.sense_voltage_v


def test_closing_switches_the_drive_off_and_may_be_done_twice(rig: Rig) -> None:
    rig.exchange(1.0)
    rig.close()
    rig.close()
    assert rig.drive_voltage_v == 0.0


@pytest.mark.parametrize("wrong", [-0.01, math.nan, math.inf, -math.inf, "above"])
def test_a_voltage_out_of_range_is_refused_and_leaves_the_drive_off(rig: Rig, wrong: float | str) -> None:
    voltage = rig.maximum_voltage_v + 0.01 if wrong == "above" else float(wrong)
    with rig:
        rig.exchange(1.0)
        with pytest.raises(RigError, match="drive voltage") as caught:
            rig.exchange(voltage)
        assert rig.drive_voltage_v == 0.0
    assert f"{rig.maximum_voltage_v}" in str(caught.value)


def test_both_ends_of_the_range_are_allowed(rig: Rig) -> None:
    with rig:
        assert rig.exchange(0.0).drive_voltage_v == 0.0
        assert rig.exchange(rig.maximum_voltage_v).drive_voltage_v == pytest.approx(rig.maximum_voltage_v, abs=1e-3)


def test_the_sample_says_the_drive_that_was_out(rig: Rig) -> None:
    """To the resolution of the output, under a millivolt."""
    with rig:
        for voltage in (rig.sense_voltage_v + 0.2, 1.5, rig.sense_voltage_v):
            sample = rig.exchange(voltage)
            assert sample.drive_voltage_v == pytest.approx(voltage, abs=1e-3)
            assert rig.drive_voltage_v == sample.drive_voltage_v


def test_the_cold_wire_has_the_resistance_of_its_size(rig: Rig, subject: RigSubject) -> None:
    """By Eq. 1, from a mean of samples at the sense voltage."""
    with rig:
        found = [rig.exchange(rig.sense_voltage_v) for _ in range(20)]
    wire_v = sum(sample.wire_voltage_v for sample in found)
    shunt_v = sum(sample.shunt_voltage_v for sample in found)
    low, high = subject.cold_ohm
    assert low < wire_v / shunt_v * rig.shunt_resistance_ohm < high


def test_wire_and_shunt_voltage_leave_no_more_than_the_drive(rig: Rig) -> None:
    with rig:
        for voltage in (rig.sense_voltage_v, 1.0, rig.drive_amplitude_v):
            sample = rig.exchange(voltage)
            # A millivolt for the noise of two channels.
            assert 0.0 < sample.shunt_voltage_v < sample.wire_voltage_v
            assert sample.wire_voltage_v + sample.shunt_voltage_v <= voltage + 1e-3


def test_without_drive_there_is_no_current(rig: Rig) -> None:
    with rig:
        sample = rig.exchange(0.0)
    assert sample.shunt_voltage_v == pytest.approx(0.0, abs=1e-3)


def test_the_amplitude_heats_the_wire_until_it_contracts_and_the_sense_voltage_does_not(
    rig: Rig, subject: RigSubject
) -> None:
    """By the LVDT: two percent of strain in ten seconds, against a hundredth of a percent; else by resistance.

    An emulated board takes two seconds of the processor for one: it has three seconds to heat the wire, not ten.
    """
    samples_at_rest, samples_driven = (40, 60) if subject.emulated else (100, 200)
    with rig:
        sensing = [rig.exchange(rig.sense_voltage_v) for _ in range(samples_at_rest)]
        driven = [rig.exchange(rig.drive_amplitude_v) for _ in range(samples_driven)]
    if sensing[-1].displacement_m is None:
        assert_resistance_tells(sensing, driven)
        return
    assert abs(sensing[-1].displacement_m) < 1e-4 * rig.leg_length_m + 5e-6
    assert driven[-1].displacement_m > subject.least_strain * rig.leg_length_m
    assert driven[-1].force_n is not None
    assert sensing[-1].force_n is not None
    assert driven[-1].force_n > sensing[-1].force_n + subject.least_force_n


def assert_resistance_tells(sensing: list[RawSample], driven: list[RawSample]) -> None:
    """A wire that contracts loses a tenth of its resistance and more; one at the sense voltage keeps it."""
    before, after = mean_ohm_per_shunt_ohm(sensing[:20]), mean_ohm_per_shunt_ohm(sensing[-20:])
    assert after == pytest.approx(before, rel=0.01)
    assert mean_ohm_per_shunt_ohm(driven[-20:]) < 0.9 * before


def mean_ohm_per_shunt_ohm(samples: list[RawSample]) -> float:
    return sum(sample.wire_voltage_v for sample in samples) / sum(sample.shunt_voltage_v for sample in samples)


def test_every_rig_is_the_one_guard_around_a_device(rig: Rig) -> None:
    """What keeps the wire safe is in GuardedRig.exchange: no script and no kind of device passes it by accident."""
    with rig:
        assert type(rig) is GuardedRig
        assert set(vars(rig)) == set(vars(open_rig("simulated")))


def test_limits_and_sizes_make_sense(rig: Rig) -> None:
    assert 0.0 < rig.sense_voltage_v < rig.drive_amplitude_v <= rig.maximum_voltage_v
    assert rig.shunt_resistance_ohm > 0.0
    assert rig.leg_length_m > 0.0
    assert 0.0 < rig.sample_period_s <= 1.0


def test_the_metadata_say_what_a_recording_needs(rig: Rig) -> None:
    facts = rig.metadata()
    assert facts.keys() >= METADATA_KEYS
    assert all(value is None or isinstance(value, (str, int, float, bool)) for value in facts.values())
    assert facts["sample_period_s"] == rig.sample_period_s
    assert facts["leg_length_m"] == rig.leg_length_m
    assert facts["shunt_resistance_ohm"] == rig.shunt_resistance_ohm


def test_a_rig_with_a_stage_takes_another_pretension(rig: Rig, subject: RigSubject) -> None:
    """Rigs without a stage that software can move say so, or one whose parts leave none by refusing."""
    stage = ability(rig, HasStage)
    if stage is None:
        return
    if subject.fixed_pretension:
        before = rig.metadata()
        with pytest.raises(CallerError, match="is the pretension"):
            stage.set_pretension(2.5)
        assert rig.metadata() == before
        return
    stage.set_pretension(2.5)
    assert rig.metadata()["pretension_n"] == pytest.approx(2.5)


def test_a_closed_rig_stays_off_whatever_is_asked_of_it(rig: Rig) -> None:
    rig.close()
    rig.make_safe()
    assert rig.drive_voltage_v == 0.0
    with pytest.raises(RigError, match="stays off"):
        rig.exchange(rig.drive_amplitude_v)
    assert rig.drive_voltage_v == 0.0


def test_a_refused_voltage_latches_the_drive_off(rig: Rig) -> None:
    with pytest.raises(RigError, match="the drive is off"):
        rig.exchange(2.0 * rig.maximum_voltage_v)
    rig.make_safe()
    assert rig.drive_voltage_v == 0.0


def test_moving_the_stage_switches_the_drive_off_and_more_than_the_wire_allows_is_refused(
    rig: Rig, subject: RigSubject
) -> None:
    stage = ability(rig, HasStage)
    if subject.fixed_pretension or stage is None:
        return
    with rig:
        rig.exchange(rig.drive_amplitude_v)
        stage.set_pretension(1.5)
        assert rig.drive_voltage_v == 0.0
        for pretension_n in (-0.1, 20.0, math.nan):
            with pytest.raises(CallerError, match="pretension"):
                stage.set_pretension(pretension_n)


def test_another_thread_may_close_a_rig_that_exchanges_and_the_exchange_ends_with_an_error(rig: Rig) -> None:
    """At whatever moment: nothing is applied after it."""
    exchanges, begun, ended = 0, threading.Event(), []

    def exchange_until_it_fails() -> None:
        nonlocal exchanges
        try:
            while True:
                rig.exchange(1.0)
                exchanges += 1
                if exchanges == 5:
                    begun.set()
        except RigError as error:
            ended.append(error)

    thread = threading.Thread(target=exchange_until_it_fails)
    thread.start()
    assert begun.wait(60.0)
    rig.close()
    assert rig.drive_voltage_v == 0.0
    thread.join(5.0)
    assert not thread.is_alive()
    assert len(ended) == 1
    assert rig.drive_voltage_v == 0.0
    with pytest.raises(RigError, match="stays off"):
        rig.exchange(1.0)


def test_a_device_confirms_0_v_once_and_for_all_and_puts_nothing_out_after_it(rig: Rig) -> None:
    """By the device's own door, as the guard uses it."""
    assert isinstance(rig, GuardedRig)
    rig.exchange(1.0)
    assert rig.device.off() is rig.device.off() is True
    assert rig.drive_voltage_v == 0.0
    with pytest.raises(RigError):
        rig.exchange(1.0)
    assert rig.drive_voltage_v == 0.0


def test_a_devices_facts_do_not_change_while_it_is_open(rig: Rig) -> None:
    assert isinstance(rig, GuardedRig)
    before = rig.device.facts
    with rig:
        rig.exchange(1.0)
        assert rig.device.facts == before
        assert set(before.reference_columns) <= set(REFERENCE_COLUMNS)


class AlarmedExchange:
    """Whether Ctrl-C came while the rig was in an exchange of which something had run."""

    def __init__(self) -> None:
        self.inside = False

    def __call__(self, _number: int, frame: FrameType | None) -> None:
        first = GuardedRig.exchange.__code__.co_firstlineno
        while frame is not None:
            self.inside |= frame.f_code is GuardedRig.exchange.__code__ and frame.f_lineno > first
            frame = frame.f_back
        raise KeyboardInterrupt


def interrupted(rig: Rig, drive_v: float, random: np.random.Generator) -> bool:
    """Let Ctrl-C come at a random moment of some exchanges; return whether that was inside of one."""
    alarm, main = AlarmedExchange(), threading.main_thread().ident
    assert main is not None
    longest_s = 2.0 * rig.sample_period_s if rig.paced else 2e-3
    before = signal.signal(signal.SIGUSR1, alarm)
    try:
        timer = threading.Timer(random.uniform(1e-4, longest_s), signal.pthread_kill, (main, signal.SIGUSR1))
        timer.start()
        while timer.is_alive():
            rig.exchange(drive_v)
        return False  # it came where Python cannot raise it, in a finaliser for one: nothing was interrupted
    except (KeyboardInterrupt, SystemError):  # what compiled code makes of Ctrl-C that comes while it is entered
        return alarm.inside
    finally:
        timer.cancel()
        timer.join()
        signal.signal(signal.SIGUSR1, before)


def interruptions(rig: Rig, moments: int, random: np.random.Generator, by_the_clock: bool) -> int:
    """Interrupt a rig at so many random moments, or until one of them has switched it off; return how many counted.

    At once if it came inside an exchange, anywhere after 0.2 s if the rig is paced, the sense voltage or less is out.
    """
    counted, anywhere = 0, rig.paced and by_the_clock
    with rig:
        while counted < moments:
            try:
                inside = interrupted(rig, min(5.0 * rig.sense_voltage_v, rig.maximum_voltage_v), random)
            except RigError as error:
                # A replay has come to its end, or Ctrl-C came in the middle of what a card and its host said.
                if not re.search("the recording|is closed or has failed", str(error)):
                    raise
                assert rig.drive_voltage_v == 0.0
                return counted
            if anywhere and not inside:
                time.sleep(0.2)
            if anywhere or inside:
                assert rig.drive_voltage_v <= rig.sense_voltage_v + 0.01
                counted += 1
    return counted


def interrupt_at(moments: int, rig: Rig, opened: Callable[[], Rig], *, by_the_clock: bool) -> None:
    random, left = np.random.default_rng(41), moments
    while True:
        left -= interruptions(rig, left, random, by_the_clock)
        if left <= 0 or rig.metadata()["rig"] == "replay":
            return
        rig = opened()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_ctrl_c_at_a_random_moment_leaves_no_drive_on(
    rig: Rig, subject: RigSubject, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    interrupt_at(20, rig, lambda: subject.opened(request, tmp_path), by_the_clock=subject.by_the_clock)


def test_a_rig_that_nobody_talks_to_rests_and_the_next_exchange_says_so_and_runs(
    rig: Rig, subject: RigSubject, caplog: pytest.LogCaptureFixture
) -> None:
    rests = rig.paced and subject.by_the_clock
    with rig:
        drive_v = 3.0 * rig.sense_voltage_v
        for _ in range(3):
            rig.exchange(drive_v)
        time.sleep(rig.sample_period_s + 0.3)
        assert rig.drive_voltage_v <= (rig.sense_voltage_v if rests else drive_v) + 0.01
        with caplog.at_level(logging.WARNING, logger="musclewire.rigs"):
            samples = [rig.exchange(drive_v) for _ in range(3)]
        assert ("nobody talked to the rig" in caplog.text) is rests
        assert samples[-1].drive_voltage_v == pytest.approx(drive_v, abs=0.05)
