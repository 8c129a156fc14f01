"""Many wires in one call: the bits of each one alone, whatever its place in the batch and the number of threads."""

from __future__ import annotations

import numpy as np
import pytest
from wire_makers import Array, constants

from musclewire.errors import CallerError, NumericsError
from musclewire.wire import (
    StepControl,
    WireBatch,
    WireConstants,
    advance,
    drive_many,
    drive_path,
    fixed_steps,
    resting_state,
    with_table,
)

SAMPLE_S, SAMPLES = 0.05, 60
TEN_MS, CHOSEN = fixed_steps(0.01), StepControl()


def wall(displacement_m: Array) -> Array:
    return np.asarray(1e5 * np.maximum(displacement_m - 1e-3, 0.0))


def wires(count: int, seed: int = 1) -> list[WireConstants]:
    """Return wires with different springs, pretensions and frictions; every fifth meets a wall."""
    random = np.random.default_rng(seed)
    found = []
    for index in range(count):
        bench = {
            "spring_stiffness_n_per_m": random.uniform(100.0, 1500.0),
            "pretension_n": random.uniform(0.5, 3.0),
            "guide_friction_n": random.uniform(0.0, 0.5),
        }
        load = None
        if index % 5 == 4:
            load = with_table(bench["spring_stiffness_n_per_m"], wall, np.zeros_like, reach_m=5e-3)
        found.append(constants(bench_values=bench, load=load))
    return found


def drives(count: int, seed: int = 2) -> Array:
    """Return random staircases of the drive, which heat through and cool again."""
    random = np.random.default_rng(seed)
    levels = random.uniform(0.3, 4.0, (count, SAMPLES // 10))
    return np.repeat(levels, 10, axis=1)


@pytest.mark.parametrize("stepping", [TEN_MS, fixed_steps(0.05), CHOSEN], ids=["10 ms", "50 ms", "chosen"])
@pytest.mark.parametrize("threads", [1, 2, 3])
def test_each_wire_has_the_bits_of_itself_alone(stepping: StepControl, threads: int) -> None:
    many, drive = wires(37), drives(37)
    alone = [drive_path(wire, drive[place], sample_s=SAMPLE_S, stepping=stepping)[0] for place, wire in enumerate(many)]
    found = drive_many(many, drive, sample_s=SAMPLE_S, stepping=stepping, keep=alone[0]._fields, threads=threads)
    for name in alone[0]._fields:
        for place, path in enumerate(alone):
            assert np.array_equal(found[name][place], getattr(path, name)), (place, name)


def test_sample_by_sample_equals_the_whole_drive_in_means_and_in_every_field_of_the_state() -> None:
    many, drive = wires(18), drives(18)
    batch = WireBatch(many, stepping=TEN_MS)
    alone = [resting_state(wire) for wire in many]
    for sample in range(SAMPLES):
        means = batch.advance(drive[:, sample], SAMPLE_S)
        for place, wire in enumerate(many):
            alone[place], own = advance(alone[place], wire, drive[place, sample], SAMPLE_S, TEN_MS)
            assert own[:4] == tuple(column[place] for column in means)  # one wire grips nothing
    for place, state in enumerate(alone):
        for name, value in batch.state(place).values().items():
            if name != "front_trial":
                assert np.array_equal(value, getattr(state, name)), (place, name)


def test_some_wires_begin_again_and_the_others_go_on() -> None:
    many, drive = wires(20), drives(20)
    batch, fresh = WireBatch(many, stepping=TEN_MS), WireBatch(many, stepping=TEN_MS)
    for sample in range(SAMPLES):
        batch.advance(drive[:, sample], SAMPLE_S)
    before = batch.states
    again = np.arange(20) % 3 == 0
    batch.rest(again)
    assert np.array_equal(batch.states["temperature_k"][again], fresh.states["temperature_k"][again])
    assert np.array_equal(batch.states["enthalpy_j"][~again], before["enthalpy_j"][~again])
    after, first = batch.advance(drive[:, 0], SAMPLE_S), fresh.advance(drive[:, 0], SAMPLE_S)
    assert np.array_equal(after.wire_voltage_v[again], first.wire_voltage_v[again])


def test_energy_is_kept_to_rounding_in_every_wire() -> None:
    many, drive = wires(40), drives(40)
    batch = WireBatch(many, stepping=TEN_MS)
    start = batch.states
    batch.drive(drive, SAMPLE_S, ())
    end = batch.states
    gained = end["enthalpy_j"] + end["carried_heat_j"] - start["enthalpy_j"]
    assert np.abs(gained - (end["heat_in_j"] - end["heat_out_j"])).max() < 1e-12
    assert not end["unsolved_steps"].any()


def test_wrong_requests_are_the_callers_errors() -> None:
    many = wires(2)
    with pytest.raises(CallerError, match="no column 'force'"):
        drive_many(many, drives(2), sample_s=SAMPLE_S, keep=("force",))
    with pytest.raises(CallerError, match=r"drive of shape \(3, 60\) for 2 wires"):
        drive_many(many, drives(3), sample_s=SAMPLE_S)
    with pytest.raises(CallerError, match="at least one"):
        WireBatch([])
    with pytest.raises(CallerError, match="must divide a sample"):
        drive_many(many, drives(2), sample_s=SAMPLE_S, stepping=fixed_steps(0.03))
    with pytest.raises(CallerError, match="as many voltages"):
        WireBatch(many).advance(np.zeros(3), SAMPLE_S)


def test_steps_too_long_for_what_happens_are_named_as_numerics() -> None:
    jump = np.full((2, 3), 5.5)
    with pytest.raises(NumericsError, match=r"steps of 1000 ms leave an error of .* set time_step_s to 0"):
        drive_many(wires(2), jump, sample_s=1.0, stepping=fixed_steps(1.0))
