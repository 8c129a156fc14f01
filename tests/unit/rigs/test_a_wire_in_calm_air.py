"""A wire that loses less heat than in still air, in a sleeve or in foam, is heated no further than its limit."""

from __future__ import annotations

from contextlib import suppress

import pytest
from pydantic import ValidationError
from tests.unit.rigs.ideal_wire import LIMITS, IdealWire

from musclewire.rigs import GuardedRig, MountedWire, ProtectionTripError


def mounted(**keys: object) -> MountedWire:
    given = {"wire": "paper-100um", "wire_length": "14 cm", "shunt": "1 ohm", "sense_voltage": "0.3 V"}
    return MountedWire.model_validate({**given, **keys})


def test_the_stated_factor_is_that_of_the_heat_loss_and_holds_the_voltages_down() -> None:
    still, sleeve = mounted(), mounted(loss_factor=0.5)
    loss = {
        one.loss_factor: one.protection_limits(wire_range_v=5.0, shunt_range_v=1.0).heat_loss_w_per_k
        for one in (still, sleeve)
    }
    assert loss[0.5] == 0.5 * loss[1.0]
    assert sleeve.drive_amplitude < still.drive_amplitude


def test_more_loss_than_in_still_air_is_confirmed_or_refused() -> None:
    with pytest.raises(ValidationError, match=r"loss_factor 1\.3 is more than still air takes"):
        mounted(loss_factor=1.3)
    assert mounted(loss_factor=1.3, beyond_catalogue=True).loss_factor == 1.3


@pytest.mark.parametrize(("measured", "fraction"), [("2.7 V", 1.02 * 0.9), ("3 V", 1.0), ("3.2 V", 1.0)])
def test_what_a_multimeter_has_shown_of_an_order_counts_with_its_error(measured: str, fraction: float) -> None:
    wire = mounted(arrives={"ordered": "3 V", "measured": measured, "by": "multimeter"})
    assert wire.protection_limits(wire_range_v=5.0, shunt_range_v=1.0).arriving_fraction == pytest.approx(fraction)
    facts = wire.facts()
    assert facts["arriving_fraction_by"] == "multimeter"
    assert facts["arriving_fraction_least"] == pytest.approx(min(0.98 * float(measured.split()[0]) / 3.0, 1.0))


def test_the_rigs_own_channels_are_no_source_of_what_arrives() -> None:
    with pytest.raises(ValidationError, match="'multimeter', 'supply' or 'circuit'"):
        mounted(arrives={"ordered": "3 V", "measured": "2.7 V", "by": "channels"})


@pytest.mark.parametrize("resistance_ohm", [12.2, 17.0])
@pytest.mark.parametrize("drive_v", [3.0, 4.6])
@pytest.mark.parametrize("loss", [0.5, 0.7])
def test_what_is_lowered_holds_the_wire_at_its_limit(loss: float, drive_v: float, resistance_ohm: float) -> None:
    truth = LIMITS._replace(heat_loss_w_per_k=loss * LIMITS.heat_loss_w_per_k)
    device = IdealWire(limits=truth, resistance_ohm=resistance_ohm)
    device.believed(LIMITS)
    rig = GuardedRig(device)
    rig.lower_heat_loss(truth.heat_loss_w_per_k, "a test")
    with rig, suppress(ProtectionTripError):
        for _ in range(400):
            rig.exchange(drive_v)
    assert device.hottest_k > 400.0
    assert device.hottest_k <= LIMITS.maximum_temperature_k + 10.0
