"""Faults of a simulated rig: what each does to the circuit, and that the protection ends it in time."""

from __future__ import annotations

import math

import pytest

from musclewire.controllers import Event
from musclewire.errors import CallerError
from musclewire.extras.instruments import SimulatedFaults
from musclewire.parameters import validated
from musclewire.rigs import ProtectionTripError, RigConfiguration, open_rig, uncompiled

WIRE_OHM, SHUNT_OHM = 14.0, 1.0


def faulty(**fault: object) -> SimulatedFaults:
    return SimulatedFaults(RigConfiguration(fault=[fault]).fault)


def test_without_a_fault_the_circuit_is_a_wire_and_a_shunt() -> None:
    circuit = SimulatedFaults([]).circuit(3.0, WIRE_OHM, SHUNT_OHM, 0.0)
    assert circuit == pytest.approx((0.2, 2.8, 0.2))


def test_a_broken_wire_carries_nothing_and_stands_at_the_whole_drive() -> None:
    assert faulty(kind="wire_open").circuit(3.0, WIRE_OHM, SHUNT_OHM, 0.0) == (0.0, 3.0, 0.0)


def test_a_short_takes_the_current_past_the_wire() -> None:
    circuit = faulty(kind="wire_short", resistance="1 ohm").circuit(3.0, WIRE_OHM, SHUNT_OHM, 0.0)
    bridged_ohm = 14.0 / 15.0
    assert circuit.shunt_voltage_v == pytest.approx(3.0 / (1.0 + bridged_ohm))
    assert circuit.wire_voltage_v == pytest.approx(3.0 - circuit.shunt_voltage_v)
    assert circuit.wire_current_a == pytest.approx(circuit.wire_voltage_v / WIRE_OHM)


@pytest.mark.parametrize(
    ("fault", "between_ohm"),
    [({"kind": "bad_contact", "resistance": 5.0}, 19.0), ({"kind": "clamp_slipped", "fraction": 0.5}, 7.0)],
)
def test_what_lies_between_the_terminals_decides_the_current(fault: dict[str, object], between_ohm: float) -> None:
    circuit = faulty(**fault).circuit(2.0, WIRE_OHM, SHUNT_OHM, 0.0)
    assert circuit.wire_current_a == pytest.approx(2.0 / (between_ohm + SHUNT_OHM))
    assert circuit.wire_voltage_v == pytest.approx(circuit.wire_current_a * between_ohm)


def test_a_fault_begins_at_its_time_and_ends_after_it() -> None:
    faults = faulty(kind="supply_missing", at="1 s", lasts="500 ms")
    assert [faults.output_v(2.0, time_s) for time_s in (0.99, 1.0, 1.49, 1.5)] == [2.0, 0.0, 0.0, 2.0]


def test_channels_freeze_saturate_swap_and_lose_their_numbers() -> None:
    frozen = faulty(kind="channel_frozen", channel="shunt", at=1.0)
    assert frozen.readings_v(1.0, 0.1, 0.5) == (1.0, 0.1)
    assert frozen.readings_v(2.0, 0.2, 1.5) == (2.0, 0.1)
    assert frozen.readings_v(3.0, 0.3, 1.6) == (3.0, 0.1)
    assert faulty(kind="channels_swapped").readings_v(1.0, 0.1, 0.0) == (0.1, 1.0)
    assert faulty(kind="channel_saturated", voltage="5 V").readings_v(1.0, 0.1, 0.0) == (5.0, 0.1)
    assert math.isnan(faulty(kind="reading_not_finite", channel="shunt").readings_v(1.0, 0.1, 0.0)[1])


def test_a_typo_in_a_fault_is_one_line_with_the_nearest_kind() -> None:
    with pytest.raises(CallerError, match="wire_open"):
        validated(RigConfiguration, {"fault": [{"kind": "wire_opn"}]}, "rig file")


CAUSES = {
    "wire_open": Event.WIRE_OPEN,
    "wire_short": Event.WIRE_SHORT,
    "bad_contact": Event.RESISTANCE_JUMP,
    "clamp_slipped": Event.RESISTANCE_OUTSIDE_WINDOW,  # 60 % of the wire: less than any of its length has
    "channel_frozen": Event.CHANNEL_FROZEN,
    "channel_saturated": Event.CHANNEL_SATURATED,
    "channels_swapped": Event.CHANNELS_SWAPPED,
    "reading_not_finite": Event.READING_NOT_FINITE,
    "output_stuck": Event.OUTPUT_STUCK,
    "supply_missing": Event.SUPPLY_MISSING,
    "device_lost": Event.DEVICE_LOST,
    "clock_jump": Event.CLOCK_BACKWARDS,
}


@pytest.mark.parametrize("kind", CAUSES)
@pytest.mark.parametrize("drive_v", [1.0, 2.0])
def test_each_fault_ends_with_its_cause_and_the_drive_off_within_half_a_second(kind: str, drive_v: float) -> None:
    began_s = 1.0
    rig = open_rig(RigConfiguration(fault=[{"kind": kind, "at": began_s}]))
    sampled = 0
    event = None
    with rig:
        try:
            for _ in range(60):
                rig.exchange(drive_v)
                sampled += 1
        except ProtectionTripError as tripped:
            event = tripped.event
        assert rig.drive_voltage_v == 0.0
    assert event is CAUSES[kind]
    assert sampled * rig.sample_period_s < began_s + 0.5


# What older rig files call a fault, in the order of CAUSES.
OLD_KINDS = ("broken wire", "short circuit", "contact", "slipped clamp", "frozen channel", "saturated channel",
             "swapped channels", "reading not finite", "output stuck", "supply lost", "device lost",
             "clock jump")  # fmt: skip


@pytest.mark.parametrize(("old", "new"), list(zip(OLD_KINDS, CAUSES, strict=True)))
def test_a_rig_file_with_a_faults_old_name_still_reads(old: str, new: str) -> None:
    assert RigConfiguration(fault=[{"kind": old}]) == RigConfiguration(fault=[{"kind": new}])  # type: ignore[list-item]
    left = [
        faulty(kind=kind, **{share: 0.5}).circuit(3.0, WIRE_OHM, SHUNT_OHM, 0.0)
        for kind, share in (("slipped clamp", "share"), ("clamp_slipped", "fraction"))
    ]
    assert left[0] == left[1]


def test_a_rig_with_faults_has_no_compiled_loop_and_says_why() -> None:
    with open_rig(RigConfiguration.model_validate({"fault": [{"kind": "wire_open", "at": "3 s"}]})) as rig:
        assert uncompiled(rig) == "the rig file lists faults"
