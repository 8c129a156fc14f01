"""Rigs whose wire pulls something else than a spring: endpoint, stage, refusals, what a recording says of them."""

from __future__ import annotations

from typing import Any

import pytest

from musclewire.errors import CallerError, RigError
from musclewire.rigs._abilities import ability
from musclewire.rigs._configuration import RigConfiguration, open_rig, rig_names
from musclewire.rigs._device import HasStage, HasTrueState
from musclewire.rigs._guarded import GuardedRig
from musclewire.signals import RawSample

PRETENSIONER = {"part": "pretensioner", "stiffness": "386.2 N/m"}
FINGER = {"part": "finger", "finger": "lan-fan-2010"}
FOAM = {"part": "contact", "stiffness": "200 N/m", "clearance": "2 mm"}
BETWEEN = {"part": "contact", "stiffness": "200 N/m", "clearance": "4 mm"}
SPRING = {"part": "spring", "stiffness": "386.2 N/m"}
SILENT = {
    "displacement_noise_m": 0.0,
    "force_noise_n": 0.0,
    "endpoint_noise_m": 0.0,
    "endpoint_force_noise_n": 0.0,
    "acquisition_noise_v": 0.0,
}
TWO_FINGERS = [PRETENSIONER, FINGER, BETWEEN, {"part": "second finger"}]
LOADS: dict[str, list[dict[str, Any]]] = {
    "finger": [PRETENSIONER, FINGER],
    "contact": [PRETENSIONER, FINGER, FOAM],
    "antagonist": [SPRING, {"part": "antagonist", "voltage": "0.5 V"}],
    "parallel": [PRETENSIONER, {"part": "parallel wire"}],
    "two fingers": TWO_FINGERS,
}


def rig(*parts: dict[str, Any], seed: int = 1, new_wire: bool = False, **changed: float) -> GuardedRig:
    settings = {"drive_amplitude_v": 1.8, "maximum_voltage_v": 3.6, **changed}
    return open_rig(
        RigConfiguration(bench="finger", load=list(parts), settings=settings, seed=seed, new_wire=new_wire)  # type: ignore[arg-type]
    )


def held(opened: GuardedRig, drive_v: float, samples: int = 100) -> list[RawSample]:
    return [opened.exchange(drive_v) for _ in range(samples)]


def test_the_rig_finger_comes_along_and_says_what_its_wire_pulls() -> None:
    assert "finger" in rig_names()
    facts = open_rig("finger").metadata()
    assert (facts["wire"], facts["load"]) == ("finger-100um", "pretensioner, finger")
    assert (facts["leg_length_m"], facts["pretension_n"]) == (0.035, 0.71)
    assert "spring_stiffness_n_per_m" not in facts, "what it pulls is no straight line"
    assert "wires" not in facts
    assert rig(*TWO_FINGERS).metadata()["wires"] == 2
    with pytest.raises(CallerError, match="there is no rig 'fingr'; did you mean 'finger'"):
        open_rig("fingr")


@pytest.mark.parametrize("name", sorted(LOADS))
def test_one_seed_gives_the_same_samples_to_the_bit_on_any_load(name: str) -> None:
    drive_v = [0.3, 1.0, 1.8, 1.8, 0.3]
    runs = [[opened.exchange(v) for v in drive_v] for opened in (rig(*LOADS[name]), rig(*LOADS[name]))]
    assert runs[0] == runs[1]
    assert runs[0] != [rig(*LOADS[name], seed=2).exchange(v) for v in drive_v]


def test_the_endpoint_starts_at_nothing_and_its_force_is_read_only_where_it_can_touch_something() -> None:
    free, held_back, plain = rig(PRETENSIONER, FINGER, **SILENT), rig(*LOADS["contact"], **SILENT), rig(SPRING)
    first = free.exchange(0.0)
    assert first.endpoint_displacement_m == pytest.approx(0.0, abs=1e-9)
    assert first.endpoint_force_n is None
    assert held_back.exchange(0.0).endpoint_force_n == pytest.approx(0.0, abs=1e-12)
    sample = plain.exchange(0.0)
    assert (sample.endpoint_displacement_m, sample.endpoint_force_n) == (None, None)


def test_an_object_holds_the_endpoint_back_and_the_wire_pulls_harder() -> None:
    free, blocked = (held(rig(*LOADS[name], **SILENT), 1.8)[-1] for name in ("finger", "contact"))
    assert free.endpoint_displacement_m > blocked.endpoint_displacement_m > 2e-3
    assert blocked.endpoint_force_n == pytest.approx(200.0 * (blocked.endpoint_displacement_m - 2e-3), rel=1e-6)
    assert blocked.force_n > free.force_n + 0.5


def test_beyond_the_fingers_curve_the_rig_stops_with_the_drive_off() -> None:
    opened = rig(FINGER)
    with pytest.raises(RigError, match=r"mm more than the finger's file covers \(1\.400 mm\)"):
        held(opened, 1.8, 200)
    assert opened.drive_voltage_v == 0.0
    with pytest.raises(RigError, match="stays off"):
        opened.exchange(0.3)


@pytest.mark.parametrize("name", sorted(LOADS))
def test_moving_the_stage_keeps_clock_and_cycles_of_every_wire(name: str) -> None:
    opened = rig(*LOADS[name], new_wire=True, **SILENT)
    held(opened, 3.2 if name == "two fingers" else 1.8)
    time_s, cycles = ability(opened, HasTrueState).wire_state.time_s, ability(opened, HasTrueState).wire_state.cycles
    partner = ability(opened, HasTrueState).partner_state
    ability(opened, HasStage).set_pretension(1.1)
    assert cycles > 0.1
    assert (ability(opened, HasTrueState).wire_state.time_s, ability(opened, HasTrueState).wire_state.cycles) == (
        time_s,
        cycles,
    )
    assert (partner is None) == (ability(opened, HasTrueState).partner_state is None)
    if partner is not None and ability(opened, HasTrueState).partner_state is not None:
        assert ability(opened, HasTrueState).partner_state.cycles == partner.cycles
        assert ability(opened, HasTrueState).partner_state.time_s == time_s
    sample = opened.exchange(0.0)
    assert sample.time_s == pytest.approx(time_s + opened.sample_period_s)
    assert sample.force_n == pytest.approx(1.1, rel=1e-3)
    assert sample.displacement_m == pytest.approx(0.0, abs=1e-7)


def test_a_refused_setting_leaves_the_rig_at_the_one_before() -> None:
    opened = rig(FINGER, **SILENT)
    with pytest.raises(CallerError, match="add a part 'pretensioner'"):
        ability(opened, HasStage).set_pretension(3.0)
    assert opened.metadata()["pretension_n"] == 0.71
    assert opened.exchange(0.0).force_n == pytest.approx(0.71, rel=1e-6)


def test_a_weight_beside_a_stage_counts_to_what_the_cold_wire_carries() -> None:
    opened = rig(SPRING, {"part": "weight", "force": 3.0}, **SILENT)
    assert opened.metadata()["pretension_n"] == pytest.approx(3.71)
    assert opened.exchange(0.0).force_n == pytest.approx(3.71, rel=1e-6)
    with pytest.raises(CallerError, match=r"N more than the 4\.601 N it allows"):
        ability(opened, HasStage).set_pretension(2.0)


def test_parallel_wires_are_read_as_one_of_half_the_resistance_and_twice_the_force() -> None:
    alone = rig({"part": "spring", "stiffness": 100.0}, pretension_n=0.5, shunt_resistance_ohm=2.0, **SILENT)
    both = rig({"part": "spring", "stiffness": 200.0}, {"part": "parallel wire"}, pretension_n=1.0, **SILENT)
    for voltage in [0.3] * 5 + [1.7] * 60:
        one, two = alone.exchange(voltage), both.exchange(voltage)
    assert one.displacement_m is not None
    assert one.displacement_m > 5e-4
    assert two.displacement_m == pytest.approx(one.displacement_m, rel=1e-3)
    assert two.force_n == pytest.approx(2.0 * one.force_n, rel=1e-3)
    # Half the resistance before half the shunt: the same divider.
    assert two.wire_voltage_v / two.shunt_voltage_v == pytest.approx(one.wire_voltage_v / one.shunt_voltage_v, rel=1e-3)


def test_the_antagonists_own_supply_pulls_the_connector_back() -> None:
    resting, pulling = (
        held(rig(SPRING, {"part": "antagonist", "voltage": voltage}, **SILENT), 1.2, 200)[-1].displacement_m
        for voltage in (0.0, 1.2)
    )
    assert resting > pulling + 5e-5


def test_two_fingers_close_on_what_is_between_them_and_both_wires_are_in_the_voltage() -> None:
    opened = rig(*TWO_FINGERS, **SILENT)
    single = rig(PRETENSIONER, FINGER, **SILENT).exchange(0.3)
    cold = opened.exchange(0.3)
    assert cold.wire_voltage_v / cold.shunt_voltage_v == pytest.approx(
        2.0 * single.wire_voltage_v / single.shunt_voltage_v, rel=0.01
    )
    closed = held(opened, 3.4, 200)[-1]
    # Each takes half of what is pressed in.
    pressed_m = 2.0 * closed.endpoint_displacement_m - 4e-3
    assert closed.endpoint_force_n == pytest.approx(200.0 * pressed_m, rel=1e-3)
    assert closed.endpoint_force_n > 0.2
