"""What the driver's errors become: one line that says what, where and what to do."""

from __future__ import annotations

import pytest
from nidaqmx.error_codes import DAQmxErrors
from nidaqmx.errors import DaqError

from musclewire.extras.board._nidaq.driver import LATE_WRITE, MEANINGS, STALLED, daq_fault


def test_every_number_is_one_that_the_driver_knows() -> None:
    known = {int(item) for item in DAQmxErrors}
    assert known >= set(MEANINGS)
    assert {LATE_WRITE, STALLED} <= known


@pytest.mark.parametrize("code", sorted(MEANINGS))
def test_each_meaning_is_one_line_with_the_number_and_what_to_do(code: int) -> None:
    fault = daq_fault(DaqError("Many\nlines\nof NI's own", code), "Dev1")
    assert str(fault).startswith("Dev1 ")
    assert str(code) in str(fault)
    assert ": " in str(fault)
    assert "\n" not in str(fault)
    assert (fault.code, fault.exit_code) == (code, 3)


def test_a_setting_that_the_card_refuses_is_named() -> None:
    said = "Requested value is not supported.\n\nProperty: DAQmx_AI_TermCfg\nRequested Value: DAQmx_Val_NRSE"
    assert "(NI-DAQmx -200077, DAQmx_AI_TermCfg)" in str(daq_fault(DaqError(said, -200077), "Dev1"))


def test_an_unknown_number_keeps_the_drivers_first_line() -> None:
    fault = daq_fault(DaqError("Something rare happened.\n\nProperty: X", -200999), "Dev1")
    assert str(fault).startswith("Dev1: Something rare happened (NI-DAQmx -200999)")
    assert "\n" not in str(fault)
