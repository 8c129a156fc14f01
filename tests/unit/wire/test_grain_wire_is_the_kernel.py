"""The reference of tests/grain_wire does what the kernel does, to the bit: it is the same arithmetic."""

from __future__ import annotations

import numpy as np
import pytest
from wire_makers import Array, alloy, bench, slow_sine_v, wire_100um

from grain_wire import APART, OWN_SUPPLY, PARALLEL, SERIES, GrainWire, Grip, Pair, drive_pair, grain_wire
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.simulate.pairs import Grip as KernelGrip
from musclewire.simulate.pairs import Pair as KernelPair
from musclewire.simulate.pairs import advance_pair, no_grip
from musclewire.simulate.paths import drive_path, isobaric_path
from musclewire.wire.building import constants_of, resting_state
from musclewire.wire.loads import ConnectorLoad, with_table
from musclewire.wire.state import WireConstants

SLOW_V = np.array([slow_sine_v(t) for t in np.arange(0.05, 90.0, 0.1)])
JUMPS_V = np.repeat((0.3, 4.0, 0.3, 2.4, 1.6, 3.0, 0.0), 20)
WALL = with_table(300.0, lambda x: 2e5 * np.maximum(x - 1e-3, 0.0), lambda x: 0.02 + 10.0 * x, reach_m=7e-3)


def both(
    kind: str = "round", load: ConnectorLoad | None = None, new_wire: bool = False, grains: int = 160, **around: float
) -> tuple[WireConstants, GrainWire]:
    numbers = (alloy(kind).values(), wire_100um().values(), bench(grains=float(grains), **around).values())
    return (
        constants_of(*numbers, load=load, new_wire=new_wire),
        grain_wire(*numbers, load=load, new_wire=new_wire, grains=grains),
    )


CASES = {
    "round": {},
    "narrow": {"kind": "narrow", "guide_friction_n": 0.0},
    "broad on a wall": {"kind": "broad", "load": WALL},
    "late": {"kind": "late", "pretension_n": 3.0},
    "new": {"new_wire": True},
    "few grains": {"grains": 40},
    "many grains": {"grains": 640},
}


def assert_same_state(wire: GrainWire, state) -> None:
    names = [name for name in wire.state.dtype.names if name != "work_j"]
    assert [wire.value(name) for name in names] == [getattr(state, name) for name in names]
    assert np.array_equal(wire.grains.martensite, state.grain_martensite)
    assert np.array_equal(wire.grains.r_phase, state.grain_r_phase)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("drive", "dt_s", "steps"), [(SLOW_V, 5e-3, 20), (JUMPS_V, 1e-3, 50), (JUMPS_V, 1e-2, 5)])
def test_a_driven_wire_is_the_kernels_to_the_bit(case: str, drive: Array, dt_s: float, steps: int) -> None:
    constants, wire = both(**CASES[case])
    path, end = drive_path(constants, drive, dt_s=dt_s, steps=steps)
    found = wire.drive(drive, dt_s, steps)
    assert np.ptp(path.martensite_fraction) > 0.2, "the wire must transform"
    for name in path._fields:
        assert np.array_equal(getattr(path, name), getattr(found, name)), name
    assert_same_state(wire, end)


def test_the_shipped_wire_at_a_regulated_current_is_the_kernels_to_the_bit() -> None:
    numbers = [group.values() for group in (load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))]
    currents = 0.18 * np.sin(np.linspace(0.0, np.pi, 300))
    path, end = drive_path(constants_of(*numbers), currents, dt_s=2e-3, steps=5, regulated_current=True)
    wire = grain_wire(*numbers)
    assert np.array_equal(wire.drive(currents, 2e-3, 5, regulated_current=True).resistance_ohm, path.resistance_ohm)
    assert_same_state(wire, end)


@pytest.mark.parametrize("kind", ["round", "narrow", "broad", "late"])
def test_an_isobar_is_the_kernels_to_the_bit(kind: str) -> None:
    kelvin = np.concatenate([np.linspace(300.0, 420.0, 150), np.linspace(420.0, 335.0, 99), np.linspace(335.0, 380.0)])
    constants, wire = both(kind)
    wire.cool(300.0, 120e6)
    found = wire.walk(kelvin, 120e6)
    for name, wanted in isobaric_path(constants, 120e6, kelvin)._asdict().items():
        assert np.array_equal(getattr(found, name), wanted), name


X_M = np.linspace(0.0, 7e-3, 701)
GRIP = (150.0, 3e-3, float(X_M[1]), 6.0 * X_M, 2e-3 + 0.0 * X_M, 5.0 + 0.0 * X_M)


@pytest.mark.parametrize(
    ("pair", "grip"),
    [
        ((1.0, PARALLEL, 0.0, 1.0), None),
        ((-1.0, OWN_SUPPLY, 1.5, 1.0), None),
        ((APART, SERIES, 0.0, 1.0), GRIP),
    ],
)
def test_two_wires_that_meet_are_the_kernels_to_the_bit(pair: tuple, grip: tuple | None) -> None:
    firm, other = both(load=WALL, pretension_n=0.9), both("broad", load=WALL, pretension_n=0.9)
    factor = 2.0 if pair[1] == SERIES else 1.0
    states = resting_state(firm[0]), resting_state(other[0])
    seen = []
    between = KernelGrip(*grip) if grip else no_grip()
    for volts in factor * JUMPS_V:
        states, means = advance_pair(states, (firm[0], other[0]), KernelPair(*pair), between, volts, 1e-3, 50)
        seen.append(means)
    found = drive_pair(firm[1], other[1], Pair(*pair), Grip(*grip) if grip else None, factor * JUMPS_V, 1e-3, 50)
    assert np.array_equal(found.T, np.array(seen))
    for wire, state in zip((firm[1], other[1]), states, strict=True):
        assert_same_state(wire, state)
