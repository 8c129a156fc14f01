"""Rigs whose wire pulls something else than a spring: endpoint, stage, refusals, what a recording says of them."""

from __future__ import annotations

from typing import Any

import pytest

from musclewire.errors import CallerError, RigError
from musclewire.rigs import GuardedRig, HasStage, HasTrueState, RigConfiguration, ability, open_rig, rig_names
from musclewire.signals import RawSample

PRETENSIONER = {"part": "pretensioner", "stiffness": "386.2 N/m"}
FINGER = {"part": "finger", "finger": "lan-fan-2010"}
FOAM = {"part": "contact", "stiffness": "200 N/m", "clearance": "2 mm"}
SPRING = {"part": "spring", "stiffness": "386.2 N/m"}
SILENT = {
    "displacement_noise_m": 0.0,
    "force_noise_n": 0.0,
    "endpoint_noise_m": 0.0,
    "endpoint_force_noise_n": 0.0,
    "acquisition_noise_v": 0.0,
}
LOADS: dict[str, list[dict[str, Any]]] = {
    "finger": [PRETENSIONER, FINGER],
    "contact": [PRETENSIONER, FINGER, FOAM],
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
def test_moving_the_stage_keeps_clock_and_cycles_of_the_wire(name: str) -> None:
    opened = rig(*LOADS[name], new_wire=True, **SILENT)
    held(opened, 1.8)
    time_s, cycles = ability(opened, HasTrueState).wire_state.time_s, ability(opened, HasTrueState).wire_state.cycles
    ability(opened, HasStage).set_pretension(1.1)
    assert cycles > 0.1
    assert (ability(opened, HasTrueState).wire_state.time_s, ability(opened, HasTrueState).wire_state.cycles) == (
        time_s,
        cycles,
    )
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
