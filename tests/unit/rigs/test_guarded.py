"""What stands between every rig and its output: pauses and interruptions."""

from __future__ import annotations

import pytest
from tests.contract.altered_device import AlteredDevice

from musclewire.controllers import State
from musclewire.rigs import Answer, HasStage, ability, open_rig


def test_a_wire_that_was_cooled_between_two_runs_has_not_jumped() -> None:
    with open_rig("simulated") as rig:
        for _ in range(60):
            hot = rig.exchange(rig.drive_amplitude_v)
        ability(rig, HasStage).set_pretension(1.0)
        cold = rig.exchange(rig.sense_voltage_v)
        ratio = cold.wire_voltage_v / cold.shunt_voltage_v / (hot.wire_voltage_v / hot.shunt_voltage_v)
        assert ratio > 1.0 + rig.protection_limits.jump_share
        assert rig.protection.state is State.RUN


@pytest.mark.parametrize("raised", [KeyboardInterrupt, ZeroDivisionError])
def test_whatever_breaks_into_an_exchange_leaves_the_sense_voltage(
    raised: type[BaseException],
) -> None:
    with open_rig("simulated") as rig:
        rig.exchange(rig.drive_amplitude_v)

        def broken(_answer: Answer) -> Answer:
            raise raised

        rig.device = AlteredDevice(rig.device, broken)
        with pytest.raises(raised):
            rig.exchange(rig.drive_amplitude_v)
        assert rig.drive_voltage_v == rig.sense_voltage_v
