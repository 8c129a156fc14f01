"""Published temperatures are those of the measured isobars, and what reads the curves is exact on known ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.special import ndtr
from studies.isobar_branches import (
    CLASSES_APART_K,
    MINOR_LOOP_PA,
    TWO_CLASSES,
    isobar_with,
    rest_after_turn_k,
    rests_after_turns,
    sample_with,
)
from studies.measured_isobars import (
    STRESSES_MPA,
    branches,
    distances_k,
    less_linear_strain,
    levelled,
    measured_isobar,
    rates_after_turns_per_k,
    temperatures_k,
)

from musclewire.identify import IsobaricLoop
from musclewire.parameters import read_published
from musclewire.wire import ONE_CLASS, BarrierClass, WireConstants, isobaric_path

PUBLISHED = read_published("flexinol_isobars")
# Three isobars were read off 500 points; where strain falls slowly a step of the extensometer is a kelvin.
READING_K = {"": (1.1, 0.2, 1.3), "held_out": (0.1, 0.1, 0.1)}


def straight_loop(distance_k: float) -> IsobaricLoop:
    """Branches of straight lines, 60 to 90 C on cooling."""
    up = np.linspace(300.0, 410.0, 1101)
    strain = np.concatenate([np.interp(up - shift, [333.15, 363.15], [0.04, 0.0]) for shift in (distance_k, 0.0)])
    strain[1101:] = strain[1101:][::-1]
    kelvin = np.concatenate([up, up[::-1]])
    return IsobaricLoop(100e6, kelvin, strain)


def normal_loop(distance_k: float, per_k: float = 0.0) -> IsobaricLoop:
    """Branches of a normal distribution around 75 C on cooling, and strain that falls by ``per_k`` per kelvin."""
    up = np.linspace(300.0, 410.0, 1101)
    heating, cooling = (0.04 * ndtr((348.15 + shift - up) / 6.0) for shift in (distance_k, 0.0))
    kelvin = np.concatenate([up, up[::-1]])
    return IsobaricLoop(100e6, kelvin, np.concatenate([heating, cooling[::-1]]) + per_k * (410.0 - kelvin))


@pytest.mark.parametrize("held_out", ["", "held_out"])
def test_the_published_temperatures_are_those_of_the_measured_curves(held_out: str) -> None:
    table = PUBLISHED[held_out] if held_out else PUBLISHED
    for place, stress_mpa in enumerate(table["stress_mpa"]):
        loop = measured_isobar(stress_mpa)
        assert 100.0 * np.ptp(loop.strain) == pytest.approx(table["stroke_pct"][place], abs=0.03)
        done = np.array([0.1, 0.5, 0.9])
        heating, cooling = branches(loop)
        for branch, name, left in ((heating, "heating", 1.0 - done), (cooling, "cooling", done)):
            degc = temperatures_k(branch, loop.strain.min() + left * np.ptp(loop.strain)) - 273.15
            off = np.abs(degc - table[f"{name}_degc"][place])
            assert (off <= READING_K[held_out]).all(), (stress_mpa, name, off)


def test_no_search_reads_a_held_out_isobar() -> None:
    assert not set(PUBLISHED["held_out"]["stress_mpa"]) & set(PUBLISHED["stress_mpa"])
    assert {*PUBLISHED["held_out"]["stress_mpa"], *PUBLISHED["stress_mpa"]} == set(STRESSES_MPA)


def test_the_distance_of_two_equal_branches_is_their_shift_at_every_part() -> None:
    assert distances_k(straight_loop(20.0)) == pytest.approx(20.0, abs=0.01)


@pytest.mark.parametrize("per_k", [0.0, 20e-6, 50e-6])
def test_a_strain_linear_in_temperature_is_found_and_taken_off(per_k: float) -> None:
    """Where branches are straight any such strain moves all distances alike, so the known loop has tails."""
    loop = normal_loop(20.0, per_k)
    found = levelled(loop)
    assert found.per_k == pytest.approx(per_k, abs=0.6e-6)
    assert (found.stroke, found.barrier_k) == pytest.approx((0.04, 10.0), rel=5e-3)
    assert less_linear_strain(loop, per_k).strain == pytest.approx(normal_loop(20.0).strain, abs=1e-12)
    assert rates_after_turns_per_k(loop) == pytest.approx((-per_k, -per_k), abs=2e-8)


# Grains of two phases that all have one expansion: what is left of the sample is its martensite and its barriers.
TWO_PHASES = {"r_phase_temperature_k": 100.0, "austenite_expansion_per_k": 0.0, "martensite_expansion_per_k": 0.0}


def of_two_phases(classes: Sequence[BarrierClass]) -> tuple[WireConstants, IsobaricLoop]:
    """Return the simulated sample of two phases with classes of barrier, and its isobar."""
    constants, kelvin = sample_with(classes).replace(**TWO_PHASES), isobar_with(classes).temperature_k
    return constants, IsobaricLoop(MINOR_LOOP_PA, kelvin, isobaric_path(constants, MINOR_LOOP_PA, kelvin).strain)


def rest_after_half_of_heating_k(classes: Sequence[BarrierClass]) -> float:
    """Return over how many kelvin of cooling the sample of two phases is at rest, half transformed before."""
    constants, loop = of_two_phases(classes)
    stroke = float(np.ptp(loop.strain))
    way_k = loop.temperature_k[: int(np.argmax(loop.strain - loop.strain.min() <= 0.5 * stroke)) + 1]
    return float(rest_after_turn_k(constants, way_k, way_k[::-1][1:], stroke)[0])


def test_of_two_phases_two_classes_of_barrier_show_after_a_turn_and_not_in_the_isobar() -> None:
    """Sums of a grain's temperature with a symmetric, independent barrier of either sign are of one shape."""
    one, two = (distances_k(of_two_phases(classes)[1]) for classes in (ONE_CLASS, TWO_CLASSES))
    assert np.abs(two - one).max() < 0.01
    assert rest_after_half_of_heating_k(TWO_CLASSES) < rest_after_half_of_heating_k(ONE_CLASS) - CLASSES_APART_K


def rests_of_the_sample() -> list[tuple[float, float]]:
    """Return how long the sample's strain rests after each turn, with one class of barrier and with two [K]."""
    rests = {(each.classes, each.branch, each.left): each.kelvin[0] for each in rests_after_turns()}
    turns = [(branch, left) for classes, branch, left in rests if classes == "one"]
    return [(rests["one", branch, left], rests["two", branch, left]) for branch, left in turns]


def test_of_the_sample_two_classes_of_barrier_show_after_a_turn_and_hardly_in_the_isobar() -> None:
    """With R-phase on the way in cooling the distances differ, by less than those of the measured isobar vary."""
    constants = sample_with(ONE_CLASS)
    barrier_k = constants.martensite_barrier_k + constants.martensite_barrier_per_pa * MINOR_LOOP_PA
    assert barrier_k > CLASSES_APART_K
    one, two = (distances_k(isobar_with(classes)) for classes in (ONE_CLASS, TWO_CLASSES))
    assert np.abs(two - one).max() < 2.0 * levelled(measured_isobar(1e-6 * MINOR_LOOP_PA)).spread_k
    for one_k, two_k in rests_of_the_sample():
        assert two_k < one_k


@pytest.mark.xfail(
    strict=True,
    reason="0.3 to 1.6 K at four of the six turns: R-phase and expansion move the strain by a hundredth of the stroke "
    "before any martensite turns back, whatever its barrier",
)
def test_of_the_sample_every_turn_shows_two_classes_by_their_distance() -> None:
    for one_k, two_k in rests_of_the_sample():
        assert two_k < one_k - CLASSES_APART_K
