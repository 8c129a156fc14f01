"""The device around a wire in segments: instruments, conditions in time, rig file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from musclewire.errors import CallerError
from musclewire.extras.studies import (
    Conditions,
    InstrumentSettings,
    LocalDraughts,
    SegmentedDevice,
    SegmentedSpool,
    steady,
)
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.rigs import GuardedRig, HasStage, ability, open_rig, required_true_state
from musclewire.signals import RawSample

pytestmark = pytest.mark.slow

BENCH = load_bench("paper")
SETTINGS = InstrumentSettings.of_bench(BENCH.values())
SPOOL = SegmentedSpool(load_wire("paper-100um"), load_alloy("flexinol"), BENCH)


def samples(device: SegmentedDevice, drive_v: list[float]) -> list[RawSample]:
    with GuardedRig(device) as rig:
        return [rig.exchange(voltage) for voltage in drive_v]


def with_instruments(**changed: float) -> SegmentedDevice:
    return SegmentedDevice(SPOOL, instruments=SETTINGS._replace(**changed))


def test_one_seed_gives_the_same_samples_to_the_bit_and_another_only_other_noise() -> None:
    drive = [0.3, 2.0, 3.2, 0.3]
    first, again, other = (SegmentedDevice(SPOOL, seed=seed) for seed in (5, 5, 6))
    ours = samples(first, drive)
    assert ours == samples(again, drive)
    assert ours != samples(other, drive)
    assert first.wire_state.temperature_k == other.wire_state.temperature_k


def test_conditions_are_asked_before_each_sample_with_its_time() -> None:
    asked: list[float] = []

    def conditions(time_s: float) -> Conditions:
        asked.append(time_s)
        return Conditions(load_force_n=0.5 if time_s > 0.12 else 0.0)

    found = samples(SegmentedDevice(SPOOL, conditions=conditions), [0.3] * 6)
    assert asked == pytest.approx([0.0, 0.05, 0.1, 0.15, 0.2, 0.25])
    assert found[2].force_n == pytest.approx(1.9, abs=0.02)
    assert 2.2 < found[5].force_n < 2.4  # the spring gives in to it a little


def test_leads_add_to_the_measured_resistance() -> None:
    def ohm(device: SegmentedDevice) -> float:
        found = samples(device, [0.3] * 40)
        return sum(one.wire_voltage_v for one in found) / sum(one.shunt_voltage_v for one in found)

    assert ohm(with_instruments(lead_resistance_ohm=0.5)) - ohm(with_instruments()) == pytest.approx(0.5, abs=0.02)


def test_a_contact_jumps_between_two_resistances() -> None:
    device = with_instruments(contact_jump_ohm=0.4, contact_interval_s=0.5, voltage_noise_v=0.0, bits=24)
    found = samples(device, [0.3] * 200)
    ohm = np.array([one.wire_voltage_v / one.shunt_voltage_v for one in found])
    levels = ohm - ohm.min() > 0.2
    assert 5 < np.abs(np.diff(levels)).sum() < 60
    assert np.median(ohm[levels]) - np.median(ohm[~levels]) == pytest.approx(0.4, abs=0.02)


def test_jitter_moves_samples_about_a_clock_that_keeps_time() -> None:
    """Fifty periods end within the jitter of one: it does not add up; the stamps stay on the grid."""
    device = with_instruments(clock_jitter=0.05)
    found = samples(device, [0.3] * 50)
    assert found[-1].time_s == pytest.approx(2.5)
    true_s = device.wire.time_s
    assert true_s != 2.5
    assert true_s == pytest.approx(2.5, abs=3.0 * 0.05 * 0.05)


def test_coarse_converters_read_in_steps_and_clip() -> None:
    device = with_instruments(voltage_noise_v=0.0, bits=10, wire_range_v=5.0, shunt_range_v=0.25, bipolar=False)
    sample = samples(device, [2.0])[0]
    for voltage_v, step_v in ((sample.wire_voltage_v, 5.0 / 1024), (sample.shunt_voltage_v, 0.25 / 1024)):
        assert voltage_v / step_v == pytest.approx(round(voltage_v / step_v), abs=1e-6)
    assert not device.facts.limits.readings_noisy


def test_the_zero_is_kept_or_taken_again_and_the_true_strain_has_its_own() -> None:
    device = SegmentedDevice(SPOOL, conditions=steady(Conditions(load_force_n=0.9)))
    with GuardedRig(device) as rig:
        kept = [rig.exchange(0.3) for _ in range(20)][-1]
        strain = required_true_state(rig).wire_state.strain
        device.zero_displacement()
        taken = rig.exchange(0.3)
    assert kept.displacement_m == pytest.approx(strain * rig.leg_length_m, abs=5e-6)
    assert kept.displacement_m < -5e-5
    assert taken.displacement_m == pytest.approx(0.0, abs=5e-6)
    assert device.wire_state.strain == pytest.approx(strain, abs=1e-5)


def test_other_instruments_may_come_while_it_runs_unless_the_protection_depends_on_them() -> None:
    device = SegmentedDevice(SPOOL)
    device.exchange_instruments(SETTINGS._replace(voltage_noise_v=10.0 * SETTINGS.voltage_noise_v))
    assert device.instruments.voltage_noise_v == 10.0 * SETTINGS.voltage_noise_v
    with pytest.raises(CallerError, match="make the device with them"):
        device.exchange_instruments(SETTINGS._replace(voltage_noise_v=0.0))
    with pytest.raises(CallerError, match="make the device with them"):
        device.exchange_instruments(SETTINGS._replace(wire_range_v=5.0))
    with pytest.raises(CallerError, match="above 0"):
        SegmentedDevice(SPOOL, instruments=SETTINGS._replace(bits=0))


def test_the_stage_moves_and_zeroes_and_the_clock_goes_on() -> None:
    rig = GuardedRig(SegmentedDevice(SPOOL, instruments=SETTINGS._replace(displacement_noise_m=0.0, force_noise_n=0.0)))
    with rig:
        warm = [rig.exchange(3.2) for _ in range(40)][-1]
        ability(rig, HasStage).set_pretension(2.5)
        sample = rig.exchange(0.0)
    assert warm.displacement_m > 1e-4
    assert sample.displacement_m == pytest.approx(0.0, abs=1e-9)
    assert sample.force_n == pytest.approx(2.5, abs=1e-6)
    assert sample.time_s == pytest.approx(warm.time_s + 0.05)


def test_local_draughts_are_repeatable_differ_along_the_wire_and_have_the_stated_strength() -> None:
    def factors(seed: int) -> np.ndarray:
        draughts = LocalDraughts(steady(), 12, strength=0.1, lasting_s=1.0, seed=seed)
        return np.array([draughts(0.05 * number).convection_factor for number in range(4000)])

    found = factors(3)
    assert (found == factors(3)).all()
    assert found.std() == pytest.approx(0.1, rel=0.15)
    neighbours = np.corrcoef(found[:, 5], found[:, 6])[0, 1]
    assert 0.4 < neighbours < 0.9
    with pytest.raises(CallerError, match="cannot be"):
        LocalDraughts(steady(), 12, strength=0.5)


RIG_FILE = """
kind = "segmented"
segments = 10
seed = 7
temperature_spread = "1.2 K"
convection_spread = 0.07
pretension = "1.7 N"
[[grains]]
weight = 0.7
mean = 0.1
deviation = 0.9
[[grains]]
weight = 0.3
mean = -1.0
deviation = 2.0
[[barriers]]
weight = 0.5
barrier = "-1.5 K"
[[barriers]]
weight = 0.5
barrier = "1.5 K"
[ageing]
residual_strain = 1e-4
[conditions]
ambient = "30 degC"
draught = 0.1
[instruments]
lead_resistance = "0.5 ohm"
clock_jitter = 0.02
"""


def test_a_rig_file_says_all_of_it(tmp_path: Path) -> None:
    file = tmp_path / "segmented.toml"
    file.write_text(RIG_FILE, encoding="utf-8")
    with open_rig(file) as rig:
        device = rig.device
        assert isinstance(device, SegmentedDevice)
        rig.exchange(0.3)
        facts, conditions = rig.metadata(), device.conditions(0.0)
    assert (facts["segments"], facts["seed"], facts["pretension_n"]) == (10, 7, 1.7)
    assert device.instruments.lead_resistance_ohm == 0.5
    assert conditions.ambient_k == pytest.approx(303.15)
    assert np.asarray(conditions.convection_factor).shape == (10,)
    assert open_rig(file, seed=8).metadata()["seed"] == 8


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('kind = "segmented"\nsegmets = 4\n', "segments"),
        ('kind = "segmented"\n[[grains]]\nweight = 0.5\nmean = 0.0\ndeviation = 1.0\n', "add up to 0.5"),
    ],
)
def test_a_wrong_key_or_number_is_one_line(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "wrong.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(CallerError, match=message):
        open_rig(file)
