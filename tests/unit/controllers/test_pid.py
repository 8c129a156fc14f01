"""The plain PID: the fuzzy-tuned one with its tuning off, without a rule base and without compiled code."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.controllers._controller import ControllerSetup
from musclewire.controllers._drive_limits import DriveLimits
from musclewire.controllers._fuzzy_pid import FuzzyPid, FuzzyPidController, FuzzyPidSettings
from musclewire.controllers._pid import PidController, PidSettings, pid_controller
from musclewire.errors import CallerError
from musclewire.signals import QuantityEstimate, Reason

LIMITS = DriveLimits(0.4, 3.2)
PLAIN = PidController(PidSettings(), LIMITS)
FIXED = FuzzyPidController(FuzzyPid(FuzzyPidSettings(rule_base="fixed"), LIMITS))
strains = st.floats(0.0, 0.05)


@given(strains, st.lists(st.one_of(strains, st.none()), min_size=1, max_size=30))
def test_it_is_the_fuzzy_tuned_one_with_fixed_rules(target: float, measured: list[float | None]) -> None:
    plain, fixed = PLAIN.start(1.5), FIXED.start(1.5)
    for value in measured:
        reason = Reason.NO_CURRENT if value is None else Reason.OK
        estimate = QuantityEstimate(value or 0.0, 0.0, value is not None, reason)
        mine, theirs = PLAIN.step(plain, target, estimate, 0.05), FIXED.step(fixed, target, estimate, 0.05)
        assert mine.command.voltage_v == pytest.approx(theirs.command.voltage_v, abs=1e-9)  # type: ignore[union-attr]
        assert mine.recorded == pytest.approx(theirs.recorded, rel=1e-12)
        plain, fixed = mine.state, theirs.state


def test_its_error_unit_is_the_loops_unless_the_settings_name_one() -> None:
    assert pid_controller(ControllerSetup(LIMITS, 0.003)).settings.error_unit == 0.003
    assert pid_controller(ControllerSetup(LIMITS, 0.003, PidSettings(error_unit=0.1))).settings.error_unit == 0.1


def test_a_key_nobody_knows_is_an_error() -> None:
    with pytest.raises(CallerError, match="did you mean 'kp'"):
        PidSettings(kpp=1.0)
