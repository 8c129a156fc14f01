"""Classes of barrier: an ensemble each, of which a wire is the weighted sum."""

from __future__ import annotations

import numpy as np
import pytest
from wire_makers import Array, alloy, bench, slow_sine_v, wire_100um

from musclewire.wire import (
    BarrierClass,
    WireConstants,
    constants_of,
    drive_many,
    drive_path,
    fixed_steps,
    isobaric_path,
    tabulated_distribution,
)

DRIVE_V = np.array([slow_sine_v(time_s) for time_s in 0.05 * np.arange(1800)])
THERE_AND_BACK_K = np.concatenate([np.linspace(290.0, 430.0, 400), np.linspace(430.0, 290.0, 400)])
SMALL_LOOPS_K = np.concatenate(
    [np.linspace(290.0, 345.0, 200), np.linspace(345.0, 335.0, 80), np.linspace(335.0, 350.0, 80)]
)
STRESS_PA = 150e6


def wire_of(*classes: tuple[float, float], table: tuple[Array, Array] | None = None) -> WireConstants:
    """Return the test wire with classes of (weight, barrier beyond the alloy's [K])."""
    return constants_of(
        alloy().values(),
        wire_100um().values(),
        bench().values(),
        classes=[BarrierClass(*item) for item in classes],
        distribution=None if table is None else tabulated_distribution(*table),
    )


@pytest.mark.parametrize("path_k", [THERE_AND_BACK_K, SMALL_LOOPS_K], ids=["loop", "small loops"])
def test_along_prescribed_temperatures_a_wire_is_the_weighted_sum_of_its_classes(path_k: Array) -> None:
    early = isobaric_path(wire_of((1.0, -4.0)), STRESS_PA, path_k)
    late = isobaric_path(wire_of((1.0, 3.0)), STRESS_PA, path_k)
    both = isobaric_path(wire_of((0.25, -4.0), (0.75, 3.0)), STRESS_PA, path_k)
    for name in ("martensite_fraction", "r_phase_fraction"):
        summed = 0.25 * getattr(early, name) + 0.75 * getattr(late, name)
        assert getattr(both, name) == pytest.approx(summed, abs=1e-14)


def test_an_inner_loop_has_a_memory_that_one_barrier_has_not() -> None:
    """A turn narrower than the common barrier moves nothing in one class, and something in a class of a low one."""
    turn_k = np.concatenate([np.linspace(290.0, 352.0, 300), np.linspace(352.0, 340.0, 100)])
    narrow = isobaric_path(wire_of((1.0, 0.0)), STRESS_PA, turn_k).martensite_fraction
    mixed = isobaric_path(wire_of((0.5, -8.0), (0.5, 2.0)), STRESS_PA, turn_k).martensite_fraction
    assert np.ptp(narrow[300:]) < 1e-12
    assert np.ptp(mixed[300:]) > 1e-3


@pytest.mark.slow
def test_energy_is_kept_and_a_batch_has_the_bits_of_one_with_classes_too() -> None:
    wires = [wire_of((0.3, -2.0), (0.7, shift)) for shift in np.linspace(0.0, 3.0, 20)]
    many = drive_many(wires, DRIVE_V[:400], sample_s=0.05, stepping=fixed_steps(0.01), keep=("resistance_ohm",))
    for place in (0, 7, 19):
        path, state = drive_path(wires[place], DRIVE_V[:400], sample_s=0.05, stepping=fixed_steps(0.01))
        assert np.array_equal(many["resistance_ohm"][place], path.resistance_ohm)
        rest_j = drive_path(wires[place], DRIVE_V[:1], sample_s=1e-9)[1].enthalpy_j
        gained_j = state.enthalpy_j + state.carried_heat_j - rest_j
        assert gained_j == pytest.approx(state.heat_in_j - state.heat_out_j, abs=1e-8)
