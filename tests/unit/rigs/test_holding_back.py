"""A loop's drive that would heat the wire too far is held back and named; one that was chosen beforehand trips."""

from __future__ import annotations

import pytest

from musclewire.rigs import ProtectionTripError, open_rig

SAMPLES = 400


def test_a_loop_goes_on_where_an_open_loop_drive_trips() -> None:
    with open_rig("simulated", seed=1) as rig:
        high_v = rig.maximum_voltage_v
        rig.lower_heat_loss(0.3 * rig.protection_limits.heat_loss_w_per_k, "for this test")
        with rig.holding_back():
            drives = [rig.exchange(high_v).drive_voltage_v for _ in range(SAMPLES)]
            held_back = sum(drive_v < 0.5 * high_v for drive_v in drives)
            assert 0 < held_back < SAMPLES
            assert f" {held_back} samples" in str(rig.metadata()["held_back"])
        assert "held_back" not in rig.metadata()
        with pytest.raises(ProtectionTripError, match="over_temperature"):
            _ = [rig.exchange(high_v) for _ in range(SAMPLES)]
