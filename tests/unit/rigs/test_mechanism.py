"""What the parts at a connector do together, held to the finger's own curve and to algebra on a straight one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from musclewire.errors import CallerError
from musclewire.parameters import FingerCurve, load_finger
from musclewire.rigs import Contact, FingerTendon, Parts, SimulatedLoad, Spring, mechanism_of
from musclewire.rigs._load_parts import Blocked, Finger, Pretensioner, Weight
from musclewire.wire import ElasticObject

LEG_M, BESIDE_N_PER_M = 0.035, 386.2
CURVE = load_finger("lan-fan-2010").curve
TRAVEL, FORCE, ENDPOINT = (
    np.array(getattr(CURVE, name)) for name in ("tendon_travel_m", "tendon_force_n", "endpoint_displacement_m")
)
FINGER = Finger(part="finger", finger="lan-fan-2010")
PRETENSIONER = Pretensioner(part="pretensioner", stiffness=BESIDE_N_PER_M)
# A finger that is a straight line in everything: 1000 N/m, 6 mm for 1 mm, 5 N at the tendon and 2 mm for a newton.
STRAIGHT = FingerCurve(
    tendon_travel_m=list(np.linspace(0.0, 2e-3, 5)),
    tendon_force_n=list(np.linspace(0.0, 2.0, 5)),
    endpoint_displacement_m=list(np.linspace(0.0, 12e-3, 5)),
    tendon_force_per_endpoint_force=[5.0] * 5,
    endpoint_compliance_m_per_n=[2e-3] * 5,
    friction_share=[0.1] * 5,
)


def mechanism(*parts: Any, pretension_n: float = 0.71, **options: Any) -> SimulatedLoad:
    return mechanism_of(parts, pretension_n=pretension_n, leg_length_m=LEG_M, **options)


def table(of: SimulatedLoad) -> tuple[np.ndarray, np.ndarray]:
    return of.load.step_m * np.arange(of.load.force_n.size), of.load.force_n


def tendon_of(found: SimulatedLoad) -> FingerTendon:
    assert found.tendon is not None
    return found.tendon


def test_a_straight_fingers_contact_is_two_springs_in_series_through_its_lever() -> None:
    """By hand at 1 mm, 3 mm of clearance, 500 N/m: 3 mm inside, 1 / (1/500 + 2e-3) = 250 N/m, 0.75 N, 3.75 N more."""
    held = FingerTendon(STRAIGHT, 0.0, 0.0, ElasticObject(500.0, 3e-3))
    force = float(held.endpoint_force_n(1e-3))
    assert force == pytest.approx(0.75)
    assert float(held.endpoint_m(1e-3, force)) == pytest.approx(6e-3 - 2e-3 * 0.75)
    assert float(held.force_n(1e-3, force)) == pytest.approx(1.0 + 5.0 * 0.75)
    # The foam is pressed in by what the endpoint is beyond the clearance.
    assert float(held.endpoint_m(1e-3, force)) - 3e-3 == pytest.approx(force / 500.0)


def test_the_force_of_a_finger_starts_at_nothing_and_follows_its_curve() -> None:
    x, force = table(mechanism(PRETENSIONER, FINGER))
    assert force[0] == 0.0
    inside = x <= TRAVEL[-1]
    assert force[inside] == pytest.approx(np.interp(x[inside], TRAVEL, FORCE), abs=1e-12)
    beyond = np.diff(force[~inside]) / np.diff(x[~inside])
    assert beyond == pytest.approx([(FORCE[-1] - FORCE[-2]) / (TRAVEL[-1] - TRAVEL[-2])] * beyond.size, rel=1e-6)
    assert mechanism(PRETENSIONER, FINGER).load.stiffness_n_per_m == BESIDE_N_PER_M


def test_a_slack_tendon_shifts_the_fingers_curve_by_the_slack() -> None:
    late = mechanism(PRETENSIONER, FINGER.model_copy(update={"slack": 3e-4}))
    x, force = table(late)
    assert (force[x <= 3e-4] == 0.0).all()
    shifted = np.interp(np.clip(x - 3e-4, 0.0, None), TRAVEL, FORCE)
    assert force[x < TRAVEL[-1]] == pytest.approx(shifted[x < TRAVEL[-1]], abs=1e-12)
    assert float(tendon_of(late).free_endpoint_m(8e-4)) == pytest.approx(np.interp(5e-4, TRAVEL, ENDPOINT))


def test_friction_along_the_tendon_is_a_share_of_its_force() -> None:
    found = mechanism(PRETENSIONER, FINGER).load
    x = found.step_m * np.arange(found.force_n.size)
    inside = x <= TRAVEL[-1]
    share = np.interp(x, TRAVEL, CURVE.friction_share)
    assert found.friction_n[inside] == pytest.approx((share * found.force_n)[inside], abs=1e-12)
    assert mechanism(Spring(part="spring", stiffness=1.0, slack=1e-4)).load.friction_n.max() == 0.0


def test_a_free_endpoint_is_where_the_curve_says_and_an_object_holds_it_back() -> None:
    free = tendon_of(mechanism(PRETENSIONER, FINGER))
    held = tendon_of(mechanism(PRETENSIONER, FINGER, Contact(part="contact", stiffness=200.0, clearance=2e-3)))
    x = np.linspace(0.0, 1.2e-3, 25)
    assert (free.endpoint_force_n(x) == 0.0).all()
    assert free.endpoint_m(x, 0.0) == pytest.approx(np.interp(x, TRAVEL, ENDPOINT), abs=1e-12)
    force = held.endpoint_force_n(x)
    before = np.interp(x, TRAVEL, ENDPOINT) <= 2e-3
    assert (force[before] == 0.0).all()
    assert (force[~before] > 0.0).all()
    # Balance at the object: it is pressed in by what the endpoint is beyond the clearance.
    assert held.endpoint_m(x, force)[~before] - 2e-3 == pytest.approx(force[~before] / 200.0, rel=1e-9)
    assert (held.force_n(x, force) >= free.force_n(x, 0.0)).all()


def test_without_a_pretensioner_the_pretension_bends_the_finger_first() -> None:
    bent = mechanism(FINGER)
    start_m = tendon_of(bent).start_m
    assert float(np.interp(start_m, TRAVEL, FORCE)) == pytest.approx(0.71, abs=1e-6)
    assert float(tendon_of(bent).free_endpoint_m(0.0)) == pytest.approx(np.interp(start_m, TRAVEL, ENDPOINT))
    x, force = table(bent)
    assert force[0] == 0.0
    some = (x > 0.0) & (x + start_m < TRAVEL[-1])
    assert force[some] == pytest.approx(np.interp(x[some] + start_m, TRAVEL, FORCE) - 0.71, abs=1e-6)
    assert bent.load.stiffness_n_per_m == 0.0


def test_whatever_else_carries_the_pretension_leaves_the_finger_straight_but_no_spring_that_hangs_through() -> None:
    spring = Spring(part="spring", stiffness=100.0)
    for carrier in (PRETENSIONER, spring, Blocked(part="blocked")):
        assert tendon_of(mechanism(carrier, FINGER)).start_m == 0.0
    late = Spring(part="spring", stiffness=100.0, slack=1e-3)
    assert tendon_of(mechanism(late, FINGER)).start_m > 0.0
    x, force = table(mechanism(late))
    assert force == pytest.approx(100.0 * np.clip(x - 1e-3, 0.0, None))


def test_more_pretension_than_the_finger_carries_is_refused_with_what_to_do() -> None:
    with pytest.raises(CallerError, match=f"pretension of 4 N, and it ends at {FORCE[-1]:.3g} N: add a part"):
        mechanism(FINGER, pretension_n=4.0)


def test_a_contact_without_a_finger_stands_before_the_connector_and_one_between_fingers_is_left_to_the_pair() -> None:
    x, force = table(mechanism(PRETENSIONER, Contact(part="contact", stiffness=2000.0, clearance=1e-3)))
    assert force == pytest.approx(2000.0 * np.clip(x - 1e-3, 0.0, None))
    parts = (PRETENSIONER, FINGER, Contact(part="contact", stiffness=200.0, clearance=2e-3))
    assert table(mechanism(*parts, object_between=True))[1] == pytest.approx(table(mechanism(*parts[:2]))[1])


def test_stiffnesses_and_weights_add_up_and_a_mount_is_a_stiff_spring() -> None:
    found = mechanism(
        PRETENSIONER,
        Spring(part="spring", stiffness=100.0),
        Blocked(part="blocked", mount_stiffness=1e5),
        Weight(part="weight", force=0.2),
        Weight(part="weight", force=0.3),
    )
    assert found.load.stiffness_n_per_m == pytest.approx(BESIDE_N_PER_M + 100.0 + 1e5)
    assert found.added_n == pytest.approx(0.5)
    assert found.load.force_n.size == 2, "no table where nothing bends"


@pytest.mark.parametrize(
    ("parts", "stage"),
    [
        ([Weight(part="weight", force=0.5)], False),
        ([Weight(part="weight", force=0.5), PRETENSIONER], True),
        ([Weight(part="weight", force=0.5), FINGER], True),
        ([Blocked(part="blocked")], True),
        ([FINGER], True),
    ],
)
def test_a_rig_has_a_stage_unless_only_weights_hang_on_the_wire(parts: list[Any], stage: bool) -> None:
    assert mechanism(*Parts(load=parts).load).stage is stage
