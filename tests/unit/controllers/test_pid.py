"""The plain PID: the fuzzy-tuned one with constant gains."""

from __future__ import annotations

from musclewire.controllers import ControllerSetup, DriveLimits, PidSettings, pid_controller
from musclewire.signals import QuantityEstimate

LIMITS = DriveLimits(0.4, 3.2)


def test_its_gains_are_those_of_its_settings_whatever_the_error_is() -> None:
    pid = pid_controller(ControllerSetup(LIMITS, settings=PidSettings(kp=0.1, ki=0.03, kd=0.002)))
    state = pid.start(1.0)
    for value in (0.01, 0.02, 0.05):
        _, state, gains = pid.step(state, 0.018, QuantityEstimate(value, 0.0, True), 0.05)
        assert gains == (0.1, 0.03, 0.002)


def test_its_error_unit_is_the_loops_unless_the_settings_name_one() -> None:
    assert pid_controller(ControllerSetup(LIMITS, 0.003)).settings.error_unit == 0.003
    assert pid_controller(ControllerSetup(LIMITS, 0.003, PidSettings(error_unit=0.1))).settings.error_unit == 0.1
