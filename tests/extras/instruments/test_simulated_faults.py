"""The rows of the fault matrix that a simulated rig can show: ended in their stated time, with their cause."""

from __future__ import annotations

import pytest
from tests.faults.table import FaultRow, fault_matrix

from musclewire.rigs import ProtectionTripError, RigConfiguration, open_rig


@pytest.mark.parametrize("row", [pytest.param(row, id=row.name) for row in fault_matrix() if row.run == "simulated"])
def test_a_fault_of_a_simulated_rig(row: FaultRow) -> None:
    began_s = 1.0
    rig = open_rig(RigConfiguration(fault=[{**row.arguments, "at": began_s}]))
    event, last_s = "", 0.0
    with rig:
        try:
            for _ in range(60):
                last_s = rig.exchange(row.drive_v).time_s
        except ProtectionTripError as tripped:
            event = tripped.event.name.lower()
        assert rig.drive_voltage_v == 0.0
    assert event in row.event
    assert last_s + rig.sample_period_s <= began_s + row.within_s + 1e-6
