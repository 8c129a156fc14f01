"""Rigs with two wires: parts that fit, what one reads and may pull, refusals, and what has no compiled form."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import musclewire as mw
from musclewire.errors import CallerError
from musclewire.experiment import characterize
from musclewire.parameters import validated
from musclewire.rigs import (
    GuardedRig,
    HasStage,
    HasTrueState,
    RigConfiguration,
    ability,
    open_rig,
    rig_configuration,
    uncompiled,
)
from musclewire.signals import RawSample

PRETENSIONER = {"part": "pretensioner", "stiffness": "386.2 N/m"}
FINGER = {"part": "finger", "finger": "lan-fan-2010"}
CONTACT = {"part": "contact", "stiffness": "200 N/m", "clearance": "2 mm"}
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


def on_the_papers_bench(*parts: dict[str, object]) -> GuardedRig:
    return open_rig(RigConfiguration(load=list(parts)))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ([{"part": "antagonist"}, {"part": "parallel wire"}], "room for one second wire: give one of antagonist, para"),
        ([{"part": "second finger"}], "a second finger needs a part 'finger'"),
        ([PRETENSIONER, FINGER, {"part": "second finger"}], "a 'contact' between them"),
        ([PRETENSIONER, CONTACT, {"part": "parallel wire"}], "not simulated: leave one out"),
        ([{"part": "antagonist", "wire": "paper-100"}], "no wire called 'paper-100'; did you mean 'paper-100um'?"),
        ([{"part": "antagonist", "voltage": "40 V"}], "40 V is above the 3.6 V that wire paper-100um allows"),
    ],
)
def test_second_wires_that_do_not_fit_are_refused_with_the_reason(parts: list[dict[str, Any]], reason: str) -> None:
    with pytest.raises(CallerError) as refused:
        open_rig(validated(RigConfiguration, {"load": parts}, "rig file my_rig.toml"))
    assert reason in str(refused.value)


def test_an_antagonist_carries_the_pretension_and_its_wire_file_lies_beside_the_rig_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with on_the_papers_bench({"part": "weight", "force": 0.5}, {"part": "antagonist"}) as rig:
        assert ability(rig, HasStage) is not None
    (tmp_path / "rig.toml").write_text('[[load]]\npart = "antagonist"\nwire = "mine.toml"\n', "utf-8")
    monkeypatch.chdir("/")
    with pytest.raises(CallerError, match=str(tmp_path / "mine.toml")):
        open_rig(tmp_path / "rig.toml")


@pytest.mark.parametrize("name", sorted(LOADS))
def test_one_seed_gives_the_same_samples_to_the_bit_on_any_load(name: str) -> None:
    drive_v = [0.3, 1.0, 1.8, 1.8, 0.3]
    runs = [[opened.exchange(v) for v in drive_v] for opened in (rig(*LOADS[name]), rig(*LOADS[name]))]
    assert runs[0] == runs[1]
    assert runs[0] != [rig(*LOADS[name], seed=2).exchange(v) for v in drive_v]


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
    after = ability(opened, HasTrueState).partner_state
    assert (after.cycles, after.time_s) == (partner.cycles, time_s)
    sample = opened.exchange(0.0)
    assert sample.time_s == pytest.approx(time_s + opened.sample_period_s)
    assert sample.force_n == pytest.approx(1.1, rel=1e-3)
    assert sample.displacement_m == pytest.approx(0.0, abs=1e-7)


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


def test_the_limit_of_the_load_cell_is_that_of_the_weakest_wire_of_the_rig() -> None:
    spring = {"part": "spring", "stiffness": 100.0}
    limits = {
        "alone": open_rig("simulated"),
        "against": on_the_papers_bench({"part": "antagonist"}),
        "against a stronger one": on_the_papers_bench({"part": "antagonist", "wire": "paper-200um"}),
        "next to its like": on_the_papers_bench(spring, {"part": "parallel wire"}),
        "next to a thicker one": on_the_papers_bench(spring, {"part": "parallel wire", "wire": "paper-200um"}),
    }
    found = {name: rig.metadata()["force_limit_n"] for name, rig in limits.items()}
    assert found["alone"] == found["against"] == found["against a stronger one"] == 4.601
    assert found["next to its like"] == pytest.approx(2 * 4.601)
    # Four times the section takes four fifths of the force, and may take 18.247 N of it.
    assert found["next to a thicker one"] == pytest.approx(min(5 * 4.601, 18.247 * 5 / 4), rel=1e-6)


def test_the_gripper_keeps_its_voltages_and_two_wires_in_series_need_twice_that_of_one() -> None:
    with open_rig("gripper") as rig:
        assert (rig.drive_amplitude_v, rig.maximum_voltage_v, rig.metadata()["wires"]) == (3.4, 5.5, 2)
    gripper, _ = rig_configuration("gripper")
    left_out = {key: value for key, value in gripper.model_dump(exclude_unset=True).items() if "voltage" not in key}
    with open_rig(RigConfiguration.model_validate({**left_out, "drive_amplitude": None})) as rig:
        assert rig.drive_amplitude_v == pytest.approx(1.65678 * (2 * 7.08 + 1.0) / (7.08 + 1.0), rel=0.01)


def test_a_loop_of_two_wires_runs_in_python_and_says_why(caplog: pytest.LogCaptureFixture) -> None:
    with open_rig("gripper") as rig:
        assert uncompiled(rig) == "the rig has two wires"
        loop = characterize(rig, cycles=1, period_s=12.0)
    assert loop.metadata["not_compiled"] == "the rig has two wires"
    assert "passed B" not in caplog.text  # its air is still


@pytest.mark.slow
@pytest.mark.parametrize(
    ("part", "least_strain", "most_mae_pct"),
    # Cold martensite of an antagonist takes most of the stroke; both wires leave a gap of their own.
    [({"part": "antagonist", "voltage": "0.3 V"}, 0.004, 12.0), ({"part": "parallel wire"}, 0.85 * 0.033, 15.0)],
    ids=["antagonist", "parallel wire"],
)
def test_characterize_fit_and_control_run_on_two_wires(
    part: dict[str, Any], least_strain: float, most_mae_pct: float
) -> None:
    with open_rig(RigConfiguration(wire="finger-100um", bench="finger", load=[SPRING, part])) as opened:  # type: ignore[list-item]
        model = mw.fit(characterize(opened, cycles=2, period_s=60.0))
        low, high = model.quantity_min, model.quantity_max
        start, stop = low + 0.45 * (high - low), low + 0.75 * (high - low)
        run = mw.control(opened, model, mw.staircase(start, stop, (stop - start) / 2.0, hold_s=4.0))
    assert high - low > least_strain
    assert run.metrics.valid_share == 1.0
    assert run.metrics.mae_mean_approached_pct is not None
    assert run.metrics.mae_mean_approached_pct < most_mae_pct
