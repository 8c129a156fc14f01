"""From the parts at a connector to what the simulator takes: one load, where the endpoint is, what touches it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from musclewire.errors import CallerError
from musclewire.parameters.finger_file import FingerCurve, load_finger
from musclewire.rigs.load_parts import Antagonist, Blocked, Contact, Finger, Part, Pretensioner, Spring, Weight
from musclewire.wire.loads import Load, spring_load, with_table

__all__ = ["Mechanism", "Tendon", "mechanism_of"]

FloatArray = NDArray[np.float64]
Kind = TypeVar("Kind")
# A wire contracts by at most about 8 %; tables reach a little further.
LARGEST_CONTRACTION = 0.10
TABLE_POINTS = 2001
SOLVE_POINTS = 20001


@dataclass(frozen=True)
class Tendon:
    """A finger at a connector, from the connector's displacement [m] to what the finger does; arrays of any shape.

    ``start_m`` is the tendon travel that is taken up before the connector moves: by a pretension without pretensioner,
    or by a stage that pulls the finger back.
    """

    curve: FingerCurve
    slack_m: float
    start_m: float
    contact: Contact | None

    def column(self, name: str, displacement_m: ArrayLike) -> FloatArray:
        """Return a column of the curve at the connector's displacement; it goes on straight beyond its end."""
        travel = np.maximum(np.asarray(displacement_m, dtype=np.float64) - self.slack_m + self.start_m, 0.0)
        at, values = np.asarray(self.curve.tendon_travel_m), np.asarray(getattr(self.curve, name))
        beyond = np.maximum(travel - at[-1], 0.0) * (values[-1] - values[-2]) / (at[-1] - at[-2])
        return np.asarray(np.interp(travel, at, values) + beyond)

    def free_endpoint_m(self, displacement_m: ArrayLike) -> FloatArray:
        """Return where the endpoint is while nothing touches it [m]."""
        return self.column("endpoint_displacement_m", displacement_m)

    def endpoint_force_n(self, displacement_m: ArrayLike, squeeze_m: float = 0.0) -> FloatArray:
        """Return the force of an object in the endpoint's way [N]."""
        if self.contact is None:
            return np.zeros_like(np.asarray(displacement_m, dtype=np.float64))
        inside = np.maximum(self.free_endpoint_m(displacement_m) + squeeze_m - self.contact.clearance, 0.0)
        soft = self.column("endpoint_compliance_m_per_n", displacement_m)
        return np.asarray(self.contact.stiffness * inside / (1.0 + self.contact.stiffness * soft))

    def endpoint_m(self, displacement_m: ArrayLike, endpoint_force_n: FloatArray | float) -> FloatArray:
        """Return where the endpoint is [m] while a force holds it back."""
        soft = self.column("endpoint_compliance_m_per_n", displacement_m)
        return np.asarray(self.free_endpoint_m(displacement_m) - soft * endpoint_force_n)

    def force_n(self, displacement_m: ArrayLike, endpoint_force_n: FloatArray | float) -> FloatArray:
        """Return the tendon's force without friction [N], from where the tendon hangs through or starts."""
        free = self.column("tendon_force_n", displacement_m)
        lever = self.column("tendon_force_per_endpoint_force", displacement_m)
        return np.asarray(free + lever * endpoint_force_n)


@dataclass(frozen=True)
class Mechanism:
    """A load for the simulator, what it adds to the stage's pretension, and the finger, if there is one.

    ``added_n`` is the pull of hanging weights, and of a tendon that its own stage has drawn taut.
    """

    load: Load
    added_n: float
    stage: bool
    tendon: Tendon | None


def of_kind(parts: Sequence[Part], kind: type[Kind]) -> list[Kind]:
    """Return the parts of one kind."""
    return [part for part in parts if isinstance(part, kind)]


def mechanism_of(
    parts: Sequence[Part],
    *,
    pretension_n: float,
    leg_length_m: float,
    object_between: bool = False,
    tendon_slack_m: float | None = None,
) -> Mechanism:
    """Return what the parts at a connector are together, at a setting of the stage.

    A pretensioner, spring, mount or antagonist carries the stage's pretension; with none of them the finger must, and
    is bent before anything is heated. ``object_between`` leaves the contact to the pair of fingers that share it.
    ``tendon_slack_m`` takes the place of the finger's own; below 0 the finger's stage pulls the tendon taut by as much.
    Raises CallerError where the finger cannot carry the pretension.
    """
    carrying = [part.stiffness_n_per_m for part in of_kind(parts, Pretensioner)]
    carrying += [part.stiffness for part in of_kind(parts, Spring) if part.slack == 0.0]
    carrying += [part.mount_stiffness for part in of_kind(parts, Blocked)]
    stiffness = sum(carrying, start=0.0)
    against = of_kind(parts, Antagonist)
    added_n = weight_n = sum((part.force for part in of_kind(parts, Weight)), start=0.0)
    contact = None if object_between else next(iter(of_kind(parts, Contact)), None)
    finger = next(iter(of_kind(parts, Finger)), None)
    tendon = None
    if finger is not None:
        curve = load_finger(finger.finger).curve
        slack_m = finger.slack if tendon_slack_m is None else tendon_slack_m
        tendon = Tendon(curve, max(slack_m, 0.0), max(-slack_m, 0.0), contact)
        added_n += float(tendon.force_n(0.0, float(tendon.endpoint_force_n(0.0))))
        if not (carrying or against):
            tendon = Tendon(curve, 0.0, travel_at_force(tendon, pretension_n, finger.finger), contact)
    stage = bool(carrying or against) or finger is not None or not weight_n
    late = [part for part in of_kind(parts, Spring) if part.slack > 0.0]
    if tendon is None and not late and contact is None:
        return Mechanism(spring_load(stiffness), added_n, stage, None)
    load = with_table(
        stiffness,
        lambda x: beyond_spring_n(x, late, tendon, contact),
        lambda x: np.zeros_like(x) if tendon is None else tendon_friction_n(tendon, x),
        reach_m=LARGEST_CONTRACTION * leg_length_m,
        points=TABLE_POINTS,
    )
    return Mechanism(load, added_n, stage, tendon)


def beyond_spring_n(
    displacement_m: FloatArray, late: Sequence[Spring], tendon: Tendon | None, contact: Contact | None
) -> FloatArray:
    """Return the force of everything that is not a plain spring, over displacement, (n_points,); 0 at the start."""
    force = np.zeros_like(displacement_m)
    for part in late:
        force += part.stiffness * np.maximum(displacement_m - part.slack, 0.0)
    if tendon is not None:
        pulled = tendon.force_n(displacement_m, tendon.endpoint_force_n(displacement_m))
        force += pulled - tendon.force_n(0.0, tendon.endpoint_force_n(0.0))
    elif contact is not None:
        force += contact.stiffness * np.maximum(displacement_m - contact.clearance, 0.0)
    return force


def tendon_friction_n(tendon: Tendon, displacement_m: FloatArray) -> FloatArray:
    """Return the largest friction along the tendon over displacement, (n_points,)."""
    pulled = tendon.force_n(displacement_m, tendon.endpoint_force_n(displacement_m))
    return np.asarray(tendon.column("friction_share", displacement_m) * pulled)


def travel_at_force(tendon: Tendon, force_n: float, name: str) -> float:
    """Return the tendon travel at which a finger carries a force by itself [m]."""
    travel = np.linspace(0.0, tendon.curve.tendon_travel_m[-1], SOLVE_POINTS)
    force = tendon.force_n(travel, tendon.endpoint_force_n(travel))
    if force_n > force[-1]:
        raise CallerError(
            f"without a pretensioner the finger {name} must carry the pretension of {force_n:g} N, and it ends at "
            f"{force[-1]:.3g} N: add a part 'pretensioner', or less pretension"
        )
    return float(np.interp(force_n, force, travel))
