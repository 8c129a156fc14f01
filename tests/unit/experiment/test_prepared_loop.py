"""What a closed loop is made of before it runs."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fake_rig import FakeRig, straight_model

from musclewire.controllers import FuzzyPidSettings
from musclewire.experiment import LoopChoice
from musclewire.experiment._closed_loop import prepared_loop


def test_the_controllers_error_unit_is_fitted_to_the_quantity_unless_the_caller_gave_one() -> None:
    metres = replace(straight_model(), quantity="displacement")
    for given, unit in ((None, pytest.approx(0.04 / 3.0)), (FuzzyPidSettings(error_unit=0.123), 0.123)):
        loop = prepared_loop(FakeRig(), metres, None, LoopChoice(settings=given))
        assert loop.controller.settings.error_unit == unit
