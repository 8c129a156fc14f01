"""Cycles of a wire, by which shakedown is counted: one for each full transformation and back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from wire_makers import constants, slow_sine_v

from musclewire.wire import StepControl, WireBatch, drive_path, fixed_steps, resting_state, shakedown_of

SAMPLE_S = 0.05
ONE_CYCLE_V = np.array([slow_sine_v(time_s, 6.0, 10.0) for time_s in np.arange(0.0, 10.0, SAMPLE_S)])
COOLING_V = np.zeros(round(10.0 / SAMPLE_S))


@pytest.mark.parametrize("new_wire", [False, True], ids=["after shakedown", "new"])
@pytest.mark.parametrize("stepping", [StepControl(), fixed_steps(0.01)], ids=["chosen", "10 ms"])
def test_a_wire_heated_through_and_cooled_again_has_made_one_cycle(new_wire: bool, stepping: StepControl) -> None:
    wire = constants(new_wire=new_wire, bench_values={"ambient_temperature_k": 260.0})
    path, state = drive_path(wire, np.concatenate([ONE_CYCLE_V, COOLING_V]), sample_s=SAMPLE_S, stepping=stepping)
    assert path.martensite_fraction.min() < 1e-3
    assert path.martensite_fraction[-1] > 0.99
    assert state.cycles == pytest.approx(1.0, abs=0.01)


def test_every_wire_of_a_batch_counts_the_cycles_that_it_makes() -> None:
    wires = [constants(bench_values={"pretension_n": force_n}) for force_n in np.linspace(1.0, 2.0, 17)]
    batch = WireBatch(wires, stepping=fixed_steps(0.01))
    batch.drive(ONE_CYCLE_V, SAMPLE_S, [])
    for wire, counted in zip(wires, batch.states["cycles"], strict=True):
        path, alone = drive_path(wire, ONE_CYCLE_V, sample_s=SAMPLE_S, stepping=fixed_steps(0.01))
        travelled = np.abs(np.diff(path.martensite_fraction, prepend=resting_state(wire).martensite_fraction)).sum()
        assert counted == pytest.approx(0.5 * travelled, abs=1e-3)
        assert counted == pytest.approx(alone.cycles, rel=1e-12)


def test_after_the_alloys_number_of_cycles_one_part_in_e_of_the_shakedown_is_left() -> None:
    wire = constants(new_wire=True)
    k = wire.derived.record
    new, worn, done = (shakedown_of(k, cycles) for cycles in (0.0, k.shakedown_cycles, math.inf))
    for at_first, later, at_last in zip(new, worn, done, strict=True):
        assert later - at_last == pytest.approx(math.exp(-1.0) * (at_first - at_last), rel=1e-3, abs=1e-12)
    # A wire grows longer while it settles; barrier and resistance come down to those of the settled wire.
    assert new[1] == 0.0 < worn[1] < done[1]
    for place in (0, 2):
        assert new[place] >= worn[place] >= done[place] == 1.0
    assert new[0] > 1.0
