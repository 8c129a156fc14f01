"""Friction along the tendon: the capstan law, and what it costs at the connector."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from musclewire_design._finger.chain import finger_chain
from musclewire_design._finger.friction import chord_tensions, friction_at, hole_turns_rad
from musclewire_design._finger.statics import equilibria, equilibrium
from packages.design.tests.unit.finger.fingers import CURVED, PLAIN

from musclewire.errors import CallerError, NumericsError

CHAIN = finger_chain(CURVED)
BENT = equilibria(CHAIN, CURVED.stiffness_n_m2, np.linspace(0.0, 1e-3, 9))[-1]


def test_tensions_fall_by_the_capstan_law_while_pulling_and_rise_while_easing() -> None:
    for sign in (1.0, -1.0):
        at, weights = chord_tensions(CHAIN, CURVED.stiffness_n_m2, 1e-3, sign * 0.15, BENT)
        assert weights == pytest.approx(np.exp(-sign * 0.15 * hole_turns_rad(at.placed, at.angles_rad)), rel=1e-9)
        assert at.travel_m == pytest.approx(1e-3)


@given(st.floats(0.01, 0.4))
def test_pulling_costs_more_and_easing_less(coefficient: float) -> None:
    found = friction_at(CHAIN, CURVED.stiffness_n_m2, BENT, coefficient)
    assert found.easing_n < BENT.tendon_force_n < found.pulling_n
    # To first order the mean of the turns up to each chord counts.
    first = coefficient * hole_turns_rad(BENT.placed, BENT.angles_rad).mean()
    assert found.fraction == pytest.approx(first, rel=0.06)


def test_one_column_alone_costs_exactly_what_its_one_edge_takes() -> None:
    finger = PLAIN.with_(columns=1)
    chain = finger_chain(finger)
    bent = equilibria(chain, finger.stiffness_n_m2, np.linspace(0.0, 0.8e-3, 9))[-1]
    found = friction_at(chain, finger.stiffness_n_m2, bent, 0.2)
    turned = hole_turns_rad(bent.placed, bent.angles_rad)[0]
    assert found.pulling_n / bent.tendon_force_n == pytest.approx(np.exp(0.2 * turned), rel=1e-9)
    assert found.easing_n / bent.tendon_force_n == pytest.approx(np.exp(-0.2 * turned), rel=1e-9)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(CallerError, match="0 or more"):
        friction_at(CHAIN, CURVED.stiffness_n_m2, BENT, -0.1)
    with pytest.raises(CallerError, match="travel above 0"):
        friction_at(CHAIN, CURVED.stiffness_n_m2, equilibrium(CHAIN, CURVED.stiffness_n_m2, 0.0), 0.1)
    with pytest.raises(NumericsError):
        friction_at(CHAIN, CURVED.stiffness_n_m2, BENT, 20.0)
