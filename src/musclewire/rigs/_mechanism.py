"""The mechanism at a connector from its parts: one load for the simulator, the endpoint, and what touches it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.parameters import FingerCurve
from musclewire.rigs._device import Metadata
from musclewire.rigs._load_part import LoadPart
from musclewire.wire import ConnectorLoad, ElasticObject, spring_load, with_table

# A wire contracts by at most about 8 %; tables reach a little further.
MAX_CONTRACTION = 0.10
TABLE_POINTS = 2001
SOLVE_POINTS = 20001


@dataclass(frozen=True)
class FingerTendon:
    """A finger at a connector: forces and positions over the connector's displacement [m], arrays of any shape."""

    curve: FingerCurve
    slack_m: float
    # Tendon travel before the connector moves: by a pretension without pretensioner, or by a stage that pulls back.
    start_m: float
    obstacle: ElasticObject | None

    def column(self, name: str, displacement_m: ArrayLike) -> FloatArray:
        """Return a column of the curve at the connector's displacement, extrapolated linearly beyond its end."""
        travel = np.maximum(np.asarray(displacement_m, dtype=np.float64) - self.slack_m + self.start_m, 0.0)
        at, values = np.asarray(self.curve.tendon_travel_m), np.asarray(getattr(self.curve, name))
        beyond = np.maximum(travel - at[-1], 0.0) * (values[-1] - values[-2]) / (at[-1] - at[-2])
        return np.asarray(np.interp(travel, at, values) + beyond)

    def free_endpoint_m(self, displacement_m: ArrayLike) -> FloatArray:
        """Return the position of the free endpoint [m]."""
        return self.column("endpoint_displacement_m", displacement_m)

    def endpoint_force_n(self, displacement_m: ArrayLike, squeeze_m: float = 0.0) -> FloatArray:
        """Return the force of an object in the endpoint's way [N]."""
        if self.obstacle is None:
            return np.zeros_like(np.asarray(displacement_m, dtype=np.float64))
        inside = np.maximum(self.free_endpoint_m(displacement_m) + squeeze_m - self.obstacle.clearance_m, 0.0)
        soft = self.column("endpoint_compliance_m_per_n", displacement_m)
        return np.asarray(self.obstacle.stiffness_n_per_m * inside / (1.0 + self.obstacle.stiffness_n_per_m * soft))

    def endpoint_m(self, displacement_m: ArrayLike, endpoint_force_n: FloatArray | float) -> FloatArray:
        """Return the position of the endpoint [m] under a force that holds it back."""
        soft = self.column("endpoint_compliance_m_per_n", displacement_m)
        return np.asarray(self.free_endpoint_m(displacement_m) - soft * endpoint_force_n)

    def force_n(self, displacement_m: ArrayLike, endpoint_force_n: FloatArray | float) -> FloatArray:
        """Return the tendon's force without friction [N], with its slack or its initial travel."""
        free = self.column("tendon_force_n", displacement_m)
        lever = self.column("tendon_force_per_endpoint_force", displacement_m)
        return np.asarray(free + lever * endpoint_force_n)


@dataclass(frozen=True)
class SimulatedLoad:
    """A load for the simulator, the force that it adds to the stage's pretension, and the finger, if there is one."""

    load: ConnectorLoad  # over the connector's displacement
    added_n: float  # pull of hanging weights, and of a tendon that its own stage has drawn taut
    stage: bool  # whether a stage sets the pretension; False if only a weight hangs on the wire
    tendon: FingerTendon | None


def mechanism_of(
    parts: Sequence[LoadPart],
    *,
    pretension_n: float,
    leg_length_m: float,  # tables reach over the displacement that a leg can move through
    object_between: bool = False,  # two fingers share the obstacle, which is then left to the pair
    tendon_slack_m: float | None = None,  # below 0 its stage pulls the tendon taut; by default the finger's own
) -> SimulatedLoad:
    """Return the mechanism of the parts at a connector, at a setting of the stage.

    If no part carries the stage's pretension the finger must, and is bent before anything is heated. Raises CallerError
    if the finger cannot carry the pretension, or its file cannot be used.
    """
    stiffness = sum((part.stiffness_n_per_m for part in parts), start=0.0)
    carried = any(part.carries_pretension for part in parts)
    added_n = weight_n = sum((part.hanging_force_n for part in parts), start=0.0)
    obstacle = None if object_between else next((part.obstacle for part in parts if part.obstacle), None)
    tendon = None
    finger = next((part for part in parts if part.finger_name is not None), None)
    if finger is not None:
        tendon = tendon_of(finger, obstacle, tendon_slack_m)
        added_n += float(tendon.force_n(0.0, float(tendon.endpoint_force_n(0.0))))
        if not carried:
            start_m = travel_at_force(tendon, pretension_n, str(finger.finger_name))
            tendon = FingerTendon(tendon.curve, 0.0, start_m, obstacle)
    stage = carried or finger is not None or not weight_n
    load = load_of(parts, stiffness, tendon, obstacle, MAX_CONTRACTION * leg_length_m)
    return SimulatedLoad(load, added_n, stage, tendon)


def tabulated_m(leg_length_m: float) -> FloatArray:
    """Return the displacements at which loads of a wire are tabulated [m], (n_points,)."""
    return np.linspace(0.0, MAX_CONTRACTION * leg_length_m, TABLE_POINTS)


def tendon_of(part: LoadPart, obstacle: ElasticObject | None, slack_m: float | None) -> FingerTendon:
    """Return the tendon of a part's finger; ``slack_m`` replaces the part's own slack."""
    finger = part.finger_file()
    assert finger is not None  # it has a name
    hanging_m = part.tendon_slack_m if slack_m is None else slack_m
    return FingerTendon(finger.curve, max(hanging_m, 0.0), max(-hanging_m, 0.0), obstacle)


def load_of(
    parts: Sequence[LoadPart],
    stiffness_n_per_m: float,
    tendon: FingerTendon | None,
    obstacle: ElasticObject | None,
    reach_m: float,
) -> ConnectorLoad:
    """Return a spring if the parts are linear, otherwise a spring with tables of their other forces and friction."""
    nowhere = np.zeros(1)
    bent = any(part.force_n(nowhere) is not None or part.friction_n(nowhere) is not None for part in parts)
    if tendon is None and obstacle is None and not bent:
        return spring_load(stiffness_n_per_m)
    return with_table(
        stiffness_n_per_m,
        lambda x: beyond_spring_n(x, parts, tendon, obstacle),
        lambda x: added_friction_n(x, parts, tendon),
        reach_m=reach_m,
        points=TABLE_POINTS,
    )


def beyond_spring_n(
    displacement_m: FloatArray, parts: Sequence[LoadPart], tendon: FingerTendon | None, obstacle: ElasticObject | None
) -> FloatArray:
    """Return the force of all parts that are not linear springs, over displacement, (n_points,); 0 at the start."""
    force = np.zeros_like(displacement_m)
    for part in parts:
        own = part.force_n(displacement_m)
        if own is not None:
            force += own
    if tendon is not None:
        pulled = tendon.force_n(displacement_m, tendon.endpoint_force_n(displacement_m))
        force += pulled - tendon.force_n(0.0, tendon.endpoint_force_n(0.0))
    elif obstacle is not None:
        force += obstacle.stiffness_n_per_m * np.maximum(displacement_m - obstacle.clearance_m, 0.0)
    return force


def added_friction_n(displacement_m: FloatArray, parts: Sequence[LoadPart], tendon: FingerTendon | None) -> FloatArray:
    """Return the largest friction of all parts in addition to the guide's, over displacement, (n_points,)."""
    friction = np.zeros_like(displacement_m) if tendon is None else tendon_friction_n(tendon, displacement_m)
    for part in parts:
        own = part.friction_n(displacement_m)
        if own is not None:
            friction = friction + own
    return friction


def tendon_friction_n(tendon: FingerTendon, displacement_m: FloatArray) -> FloatArray:
    """Return the largest friction along the tendon over displacement, (n_points,)."""
    pulled = tendon.force_n(displacement_m, tendon.endpoint_force_n(displacement_m))
    # Far beyond the end of the finger's curve its compliance, continued, turns negative, and so would the friction.
    return np.maximum(tendon.column("friction_share", displacement_m) * pulled, 0.0)


def travel_at_force(tendon: FingerTendon, force_n: float, name: str) -> float:
    """Return the tendon travel at which a finger carries a force by itself [m]."""
    travel = np.linspace(0.0, tendon.curve.tendon_travel_m[-1], SOLVE_POINTS)
    force = tendon.force_n(travel, tendon.endpoint_force_n(travel))
    if force_n > force[-1]:
        raise CallerError(
            f"without a pretensioner the finger {name} must carry the pretension of {force_n:g} N, and it ends at "
            f"{force[-1]:.3g} N: add a part 'pretensioner', or less pretension"
        )
    return float(np.interp(force_n, force, travel))


def load_metadata(parts: Sequence[LoadPart], mechanism: SimulatedLoad, two_wires: bool) -> Metadata:
    """Return the metadata of a recording that describe a wire's load."""
    stiffness = mechanism.load.stiffness_n_per_m
    if not parts:
        return {"spring_stiffness_n_per_m": stiffness}
    plain = all(part.is_straight for part in parts)
    named: Metadata = {"load": ", ".join(part.part for part in parts)}
    for part in parts:
        named |= part.facts()
    if two_wires:
        named["wires"] = 2
    return {**named, "spring_stiffness_n_per_m": stiffness} if plain else named
