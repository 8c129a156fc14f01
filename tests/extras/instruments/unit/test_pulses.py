"""A wire heated by pulses: what is read in a pulse is its resistance, what is read at a wrong time is named."""

from __future__ import annotations

from math import exp
from typing import Any

import numpy as np
import pytest

from musclewire import open_rig
from musclewire.errors import CallerError
from musclewire.experiment import run_warnings
from musclewire.extras.instruments import PulsedDevice, PulseWidth, unsettled_error
from musclewire.extras.instruments._pulse_width import duty_of, pulse_width_problems
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.rigs import HasTrueState, RigConfiguration, SimulatedSpool, ability, uncompiled
from musclewire.signals import Drive, RawSample, Recording

QUIET = {"acquisition_noise_v": 0.0, "acquisition_bits": 24.0}
DRIVES_V = [0.3] * 5 + [2.0] * 20 + [2.8] * 30 + [1.0] * 20


def ran(pwm: PulseWidth | None, settings: dict[str, float] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
    """Return read and true resistance, true temperature, displacement, power and drive of each sample; and metadata."""
    with open_rig(RigConfiguration(pwm=pwm, settings=settings or {})) as rig:
        rows, truth = [], ability(rig, HasTrueState)
        assert truth is not None
        for drive_v in DRIVES_V:
            sample, state = rig.exchange(Drive(drive_v)), truth.wire_state
            read_ohm = sample.wire_voltage_v / sample.shunt_voltage_v
            power_w = sample.wire_voltage_v * sample.shunt_voltage_v
            rows.append((read_ohm, state.resistance_ohm, state.temperature_k, sample.displacement_m, power_w,
                         sample.drive_voltage_v))  # fmt: skip
        return np.array(rows), dict(rig.metadata())


@pytest.mark.parametrize("window", ["on", "off"])
def test_resistance_read_in_a_settled_window_is_the_true_one(window: Any) -> None:
    pwm = PulseWidth(frequency=2000.0, supply=5.0, window=window, sample_delay=60e-6)
    rows, stated = ran(pwm, QUIET)
    # What a 24-bit converter and a resistance that moves within the last pulses leave over.
    assert rows[:, 0] == pytest.approx(rows[:, 1], rel=1e-3)
    assert "pwm_problem" not in stated


def test_with_a_converters_noise_the_error_is_the_noise() -> None:
    pwm = PulseWidth(frequency=1000.0, supply=5.0, shunt_gain=1.0)
    rows, _ = ran(pwm)
    error = (rows[:, 0] - rows[:, 1]) / rows[:, 1]
    # Readings of 0.244 mV at the shunt's 0.27 V, four of them; Eq. 1 divides by it.
    expected = 0.244e-3 / (5.0 / 18.3) / 4**0.5
    assert abs(error.mean()) < 4 * expected / len(error) ** 0.5 + 2e-4
    assert error.std() < 1.5 * expected


def test_pulses_heat_as_the_steady_voltage_of_the_same_mean_square_does() -> None:
    steady, _ = ran(None, QUIET)
    pulsed, stated = ran(PulseWidth(frequency=1000.0, supply=5.0), QUIET)
    heated = slice(5, None)  # while only sensing, pulses long enough to read heat more
    assert pulsed[heated, 2] == pytest.approx(steady[heated, 2], abs=1.0)
    assert pulsed[heated, 3] == pytest.approx(steady[heated, 3], abs=5e-5)
    assert pulsed[heated, 4] == pytest.approx(steady[heated, 4], rel=0.04)  # four of fifty pulses are longer at 1 V
    assert 0.02 < stated["pwm_ripple_k"] < 0.3


def test_the_ripple_is_the_pulses_energy_over_the_heat_capacity() -> None:
    _, stated = ran(PulseWidth(frequency=100.0, supply=5.0), QUIET)
    pulse_s = (2.8 / 5.0) ** 2 / 100.0
    adiabatic_k = 5.0**2 * 15.0 / 17.0**2 * pulse_s / 4.39e-3
    assert 0.3 * adiabatic_k < stated["pwm_ripple_k"] < 1.2 * adiabatic_k  # latent heat takes its part


@pytest.mark.parametrize(("delay_s", "shunt_s"), [(5e-6, 20e-6), (20e-6, 20e-6), (100e-6, 30e-6)])
def test_sampling_too_early_is_wrong_by_what_the_filters_leave(delay_s: float, shunt_s: float) -> None:
    at_once = {"wire_settling": 0.0, "conversion_time": 0.0}
    pwm = PulseWidth(frequency=500.0, supply=5.0, sample_delay=delay_s, shunt_settling=shunt_s, **at_once)
    error = 1.0 / (1.0 - exp(-(delay_s + 2e-6) / shunt_s)) - 1.0
    assert unsettled_error(pwm, 0.3) == pytest.approx(error)
    around = load_bench("paper")
    quiet = {name: getattr(around, name).model_copy(update={"value": value}) for name, value in QUIET.items()}
    spool = SimulatedSpool(load_wire("paper-100um"), load_alloy("flexinol"), around.model_copy(update=quiet))
    device = PulsedDevice(pwm, spool)
    for _ in range(3):
        sample = device.exchange(Drive(2.0))
    assert isinstance(sample, RawSample)
    read_ohm = sample.wire_voltage_v / sample.shunt_voltage_v
    assert read_ohm / device.wire_state.resistance_ohm - 1.0 == pytest.approx(error, rel=0.05, abs=2e-3)
    assert "sampled too early" in pulse_width_problems(pwm, 0.3)[0]


def test_conversions_that_run_free_of_the_pulses_alias() -> None:
    pwm = PulseWidth(frequency=1000.0, supply=5.0, trigger="free", conversion_time=104e-6)
    spool = SimulatedSpool(load_wire("paper-100um"), load_alloy("flexinol"), load_bench("paper"))
    device = PulsedDevice(pwm, spool)
    shunts = []
    for _ in range(20):
        sample = device.exchange(Drive(2.0))
        assert isinstance(sample, RawSample)
        shunts.append(sample.shunt_voltage_v)
    assert np.std(shunts) > 0.1 * abs(np.mean(shunts))


def test_a_small_error_of_early_sampling_is_a_warning() -> None:
    pwm = PulseWidth(frequency=1000.0, supply=5.0, sample_delay=25e-6, shunt_settling=8e-6)
    with open_rig(RigConfiguration(pwm=pwm)) as rig:
        stated = rig.metadata()
    assert any("sampled too early" in text for text in run_warnings(Recording({"time_s": np.arange(2.0)}, stated)))


@pytest.mark.parametrize(
    ("pwm", "message"),
    [
        ({"frequency": 30.0, "supply": 5.0}, "pulses in a sample"),
        ({"frequency": 25000.0, "supply": 5.0}, "a period is only"),
        ({"frequency": 1000.0, "supply": 3.0}, "below maximum_voltage"),
        ({"frequency": 1000.0, "supply": 12.0}, "converter's range"),
        ({"frequency": 1000.0, "supply": 5.0, "trigger": "free"}, "aliasing"),
        (
            {"frequency": 1000.0, "supply": 5.0, "sample_delay": 5e-6, "shunt_settling": 20e-6},
            "sampled too early: 5 us",
        ),
    ],
)
def test_pulses_that_cannot_be_and_sampling_of_no_use_are_refused(pwm: dict[str, Any], message: str) -> None:
    with pytest.raises(CallerError, match=message):
        open_rig(RigConfiguration(pwm=PulseWidth(**pwm)))


def test_a_duty_is_the_ratio_of_mean_squares_in_steps_of_the_timer() -> None:
    pwm = PulseWidth(frequency=1000.0, supply=5.0, timer_bits=10)
    assert duty_of(2.5, 0.0, pwm) == 0.25
    assert duty_of(5.0, 0.0, pwm) == 1.0
    assert duty_of(0.1, 0.3, pwm) == 0.0
    assert duty_of(2.0, 0.0, pwm) * 1024 == round(duty_of(2.0, 0.0, pwm) * 1024)


def test_pulses_have_no_compiled_loop_and_do_not_go_with_faults() -> None:
    pwm: dict[str, Any] = {"frequency": 1000.0, "supply": 5.0}
    with open_rig(RigConfiguration(pwm=pwm)) as rig:
        assert uncompiled(rig) == "the rig heats by pulse width"
    with pytest.raises(CallerError, match=r"\[\[fault\]\] and \[pwm\] do not go together"):
        RigConfiguration(pwm=pwm, fault=[{"kind": "wire_open"}])
