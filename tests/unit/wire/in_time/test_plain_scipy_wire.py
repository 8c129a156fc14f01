"""Whole loops of the kernel beside the same equations in plain SciPy: circuit, heat, phases, spring, guide."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from plain_scipy_wire import PlainWire
from wire_makers import Array, alloy, bench, constants, driven, slow_sine_v, wire_100um

OFF_S = 3.0


def fast_step_v(time_s: float) -> float:
    return 3.2 if time_s < OFF_S else 0.3


class Course(NamedTuple):
    """A drive, and the times at which both are compared: close where the wire turns."""

    drive_v: Callable[[float], float]
    times_s: Array


SLOW = Course(slow_sine_v, np.arange(1, 226) * 0.4)
FAST = Course(
    fast_step_v,
    np.concatenate((np.arange(1, 61) * 0.05, OFF_S + np.arange(1, 41) * 0.01, OFF_S + 0.4 + np.arange(1, 41) * 0.05)),
)
# Slow with the friction of the guide, fast with and without; "narrow" starts its R-phase all at once.
CASES = {
    "slow": (SLOW, "round", 0.03),
    "fast": (FAST, "round", 0.03),
    "fast without friction": (FAST, "broad", 0.0),
    "fast with a sudden start": (FAST, "narrow", 0.0),
}
FAST_CASES = [
    "fast without friction",
    pytest.param("fast", marks=pytest.mark.slow),
    pytest.param("fast with a sudden start", marks=pytest.mark.slow),
]
COLUMNS = ("temperature_k", "strain", "resistance_ohm", "force_n")


@cache
def plain(case: str) -> Array:
    """Return the columns by SciPy, (n_times, 4)."""
    course, kind, friction_n = CASES[case]
    wire = PlainWire(alloy(kind), wire_100um(), bench(guide_friction_n=friction_n))
    return wire.run(course.drive_v, course.times_s)[:, [0, 2, 3, 4]]


def ours(case: str, step_s: float) -> Array:
    """Return the columns by the kernel, which is given the drive of the middle of each of its steps, (n_times, 4).

    A path shows the mean contraction of each step: at its end it is half way to that of the next.
    """
    course, kind, friction_n = CASES[case]
    wire = constants(kind, bench_values={"guide_friction_n": friction_n})
    middles = (np.arange(round(course.times_s[-1] / step_s) + 1) + 0.5) * step_s
    path, _ = driven(wire, np.array([course.drive_v(t) for t in middles.tolist()]), step_s, 1)
    strain = 0.5 * (path.displacement_m[1:] + path.displacement_m[:-1]) / wire.leg_length_m
    force_n = path.stress_pa[:-1] * wire.legs * wire.area_m2
    columns = (path.temperature_k[:-1], strain, path.resistance_ohm[:-1], force_n)
    return np.array(columns).T[np.round(course.times_s / step_s).astype(int) - 1]


@cache
def off(case: str, step_s: float) -> dict[str, Array]:
    """Return by how much each column differs, each (n_times,)."""
    return dict(zip(COLUMNS, np.abs(ours(case, step_s) - plain(case)).T, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("step_s", [50e-3, 1e-3])
def test_the_slow_loop_is_that_of_scipy_even_in_one_step_a_sample(step_s: float) -> None:
    """The convection table, linear every 2 K, is worth a hundredth of a kelvin near the temperature of the air."""
    found = off("slow", step_s)
    assert np.ptp(plain("slow")[:, 1]) > 0.03, "the wire must contract for this to say anything"
    assert found["temperature_k"].max() < 0.012
    assert found["strain"].max() < 5e-6
    assert found["resistance_ohm"].max() < 0.5e-3
    assert found["force_n"].max() < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("case", FAST_CASES)
def test_a_fast_step_in_steps_of_10_ms_is_that_of_scipy_at_every_time(case: str) -> None:
    """No exception where a transformation starts; only strain is worse, within a step of where the drive jumps."""
    found = off(case, 10e-3)
    assert np.ptp(plain(case)[:, 1]) > 0.02, "the wire must contract for this to say anything"
    assert found["temperature_k"].max() < 5e-3
    assert np.sqrt(np.mean(found["strain"] ** 2)) < 2e-5
    assert found["strain"].max() < 1e-4
    assert found["resistance_ohm"].max() < 1e-3
    assert found["force_n"].max() < 1e-3


@pytest.mark.parametrize("case", FAST_CASES)
def test_in_steps_of_1_ms_what_is_left_is_the_accuracy_of_scipys_classes(case: str) -> None:
    found = off(case, 1e-3)
    assert found["temperature_k"].max() < 5e-3
    assert found["strain"].max() < 5e-6
    assert found["resistance_ohm"].max() < 1e-3
    assert found["force_n"].max() < 1e-3


@pytest.mark.slow
def test_the_distance_to_scipy_falls_with_the_square_of_the_step() -> None:
    """So SciPy's is the limit of small steps. Order two gives 4; finer steps are below what SciPy's classes resolve."""
    coarse, middle, fine = (float(np.sqrt(np.mean(off("slow", step_s)["strain"] ** 2))) for step_s in (0.4, 0.2, 0.1))
    assert coarse / middle > 3.5
    assert middle / fine > 3.2
