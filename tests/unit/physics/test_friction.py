from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.physics import friction_force_n

SETTINGS = settings(derandomize=True, deadline=None, max_examples=100)
MOVES_M = st.lists(st.floats(-1e-3, 1e-3), min_size=1, max_size=30)


def after(moves: list[float], limit_n: float = 0.03, presliding_m: float = 20e-6) -> float:
    friction = 0.0
    for move in moves:
        friction = friction_force_n(friction, move, limit_n, presliding_m)
    return friction


@SETTINGS
@given(moves=MOVES_M)
def test_friction_never_exceeds_its_limit(moves: list[float]) -> None:
    assert abs(after(moves)) <= 0.03


@SETTINGS
@given(moves=MOVES_M, parts=st.integers(2, 9))
def test_friction_depends_on_the_way_and_not_on_its_pace(moves: list[float], parts: int) -> None:
    in_parts = [move / parts for move in moves for _ in range(parts)]
    assert after(in_parts) == pytest.approx(after(moves), abs=1e-12)


def test_friction_is_elastic_first_then_coulombs_and_stays_at_rest() -> None:
    assert after([5e-6]) == pytest.approx(0.03 / 4)
    assert after([1.0]) == 0.03
    assert after([1.0, 0.0, 0.0]) == 0.03
    assert after([1.0, -40e-6]) == pytest.approx(-0.03)


def test_a_guide_without_friction_has_none() -> None:
    assert friction_force_n(0.01, 1e-3, 0.0, 20e-6) == 0.0


@SETTINGS
@given(moves=MOVES_M)
def test_friction_takes_work_over_a_closed_way(moves: list[float]) -> None:
    """It may give back what is stored elastically and no more: half of limit times presliding travel."""
    friction, work = 0.0, 0.0
    for move in moves:
        for _ in range(200):
            new = friction_force_n(friction, move / 200, 0.03, 20e-6)
            work += 0.5 * (friction + new) * move / 200
            friction = new
    # The rounded corner between elastic and sliding is cut by one of 200 parts of up to 1 mm.
    assert work >= -0.03 * 5e-6 * len(moves)
