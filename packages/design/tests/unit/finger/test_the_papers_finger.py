"""The included finger: printed numbers, its curve from its dimensions, comparison with finite elements."""

from __future__ import annotations

import math

import numpy as np
import pytest
from musclewire_design._finger.chain import finger_chain
from musclewire_design._finger.comparison import compare_schemes
from musclewire_design._finger.curve import beam_stress_pa, max_free_travel_m
from musclewire_design._finger.finger_file_text import finger_geometry, recomputed_curve
from musclewire_design._finger.plane_stress import finger_body, plane_stress_path
from musclewire_design._finger.statics import equilibria
from musclewire_design._finger.wire import wire_on_finger
from packages.design.tests.unit.finger.fingers import CURVED

from musclewire.errors import CallerError
from musclewire.parameters import FingerCurve, load_finger

FINGER = load_finger("lan-fan-2010")
GEOMETRY = finger_geometry(FINGER)
NEEDED_M = float(np.interp(6e-3, FINGER.curve.endpoint_displacement_m, FINGER.curve.tendon_travel_m))


def test_it_has_the_printed_lengths_stiffness_and_endpoint_and_does_not_yield() -> None:
    assert (GEOMETRY.overall_length_m, GEOMETRY.plate_length_m, GEOMETRY.columns) == (0.010, 0.005, 4)
    assert FINGER.curve.stiffness_n_per_m == pytest.approx(1084.4, rel=0.01)
    assert NEEDED_M <= 0.03 * 35e-3  # of the wire's leg
    at = equilibria(finger_chain(GEOMETRY), GEOMETRY.stiffness_n_m2, np.linspace(0.0, NEEDED_M, 9))[-1]
    assert beam_stress_pa(GEOMETRY, at).max() < 65e6


@pytest.mark.parametrize("column", FingerCurve.model_fields)
def test_its_curve_follows_from_its_dimensions(column: str) -> None:
    again = recomputed_curve(FINGER)
    assert getattr(again, column) == pytest.approx(getattr(FINGER.curve, column), rel=1e-7, abs=1e-12)


def test_plane_stress_agrees_within_a_few_percent() -> None:
    meshed = finger_body(GEOMETRY, 0.35)
    chain = finger_chain(GEOMETRY)
    for point in plane_stress_path(meshed, 1.07, np.array([0.02, 0.5, 1.0])):
        ours = equilibria(chain, GEOMETRY.stiffness_n_m2, np.linspace(0.0, point.travel_m, 9))[-1]
        assert ours.tendon_force_n == pytest.approx(point.tendon_force_n, rel=0.02)
        assert ours.endpoint_displacement_m == pytest.approx(point.endpoint_displacement_m, rel=0.005)
        assert beam_stress_pa(GEOMETRY, ours).max() == pytest.approx(point.stress_pa, rel=0.05)


def test_distributed_actuation_reaches_further_for_its_length() -> None:
    distributed, chord, segment = compare_schemes(GEOMETRY, 1.05e-3, 65e6)
    assert distributed.range_over_length > 1.1 * chord.range_over_length > 2.0 * segment.range_over_length
    assert (distributed.limit, chord.limit, segment.limit) == ("travel", "travel", "stress")
    assert distributed.travel_m == pytest.approx(1.05e-3)
    assert segment.stress_pa <= 65e6


def test_the_curve_ends_before_columns_touch_or_the_endpoint_turns_back() -> None:
    assert max_free_travel_m(GEOMETRY, 1.4e-3) == pytest.approx(1.4e-3)
    assert max_free_travel_m(CURVED, 5e-3) < 2.5e-3


def test_the_papers_wire_gives_stroke_and_force_with_the_papers_pretensioner() -> None:
    found = wire_on_finger(
        FINGER.curve,
        "paper-100um",
        wire_length_m=0.07,
        pretension_n=0.71,
        pretensioner_n_per_m=386.2,
        needed_travel_m=NEEDED_M,
    )
    assert found.travel_m == pytest.approx(found.contraction * 35e-3)
    assert found.reserve_m == pytest.approx(found.travel_m - NEEDED_M)
    assert found.endpoint_m > 6e-3
    assert found.wire_force_n == pytest.approx(0.71 + 386.2 * found.travel_m + found.tendon_force_n)
    assert found.wire_stress_pa == pytest.approx(found.wire_force_n / (2 * 0.25 * math.pi * 1e-8))


def test_a_wire_that_is_overloaded_is_refused_with_the_excess() -> None:
    asked = {"wire_length_m": 0.07, "pretensioner_n_per_m": 386.2, "needed_travel_m": NEEDED_M}
    with pytest.raises(CallerError, match=r"would bear 6\.\d+ N .* 1\.\d\d times the 4\.6 N it is allowed"):
        wire_on_finger(FINGER.curve, "paper-100um", pretension_n=4.0, **asked)
