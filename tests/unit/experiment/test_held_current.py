"""The policy of a held current: its voltage stays within the limits, and samples without current end the run."""

from __future__ import annotations

import pytest

from musclewire.errors import RigError
from musclewire.experiment._drive import HeldCurrent
from musclewire.signals import Drive, RawSample


def test_the_voltage_never_leaves_its_limits() -> None:
    policy = HeldCurrent(10.0, 0.3, 3.6, 1.0, 0.05, 1.0)
    decision = policy.after(RawSample(0.05, 0.3, 0.28, 0.016), 0.05)
    assert decision.command == Drive(3.6)
    policy = HeldCurrent(0.001, 0.3, 3.6, 1.0, 0.05, 1.0)
    assert policy.after(RawSample(0.05, 0.3, 0.28, 0.016), 0.05).command == Drive(0.3)


def test_a_sample_without_current_keeps_the_drive_and_five_end_the_run() -> None:
    policy = HeldCurrent(0.1, 0.3, 3.6, 1.0, 0.05, 10.0)
    no_current = RawSample(0.05, 1.7, 1.7, 0.0)
    for _ in range(4):
        assert policy.after(no_current, 0.05).command == Drive(1.7)
    with pytest.raises(RigError, match="no current"):
        policy.after(no_current, 0.05)
