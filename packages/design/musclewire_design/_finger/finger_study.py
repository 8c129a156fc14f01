"""A study of one finger: dimensions from requirements, or the behaviour of given dimensions, with checks."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from musclewire.errors import CallerError
from musclewire.parameters import (
    FingerCurve,
    Material,
    ReachedConditions,
    beyond_validity,
    load_alloy,
    load_wire,
    section_m2,
    validity_of,
)
from musclewire.wire import ElasticObject
from musclewire_design._design_checks import DesignCheck
from musclewire_design._finger.chain import FOOT_THICKNESSES, finger_chain
from musclewire_design._finger.closed_forms import pure_moment_stiffness_n_per_m
from musclewire_design._finger.comparison import PullingScheme, compare_schemes
from musclewire_design._finger.curve import (
    CURVE_REACH,
    beam_stress_pa,
    column_gap_m,
    curve_travels_m,
    finger_curve,
    linear_error,
    max_free_travel_m,
    reciprocity_error,
    touch_curve,
    travel_for_endpoint_m,
)
from musclewire_design._finger.friction import ASSUMED_FRICTION, MAX_FRICTION, ConnectorFriction, friction_at
from musclewire_design._finger.geometry import FingerGeometry
from musclewire_design._finger.plane_stress import finger_body, plane_stress_path
from musclewire_design._finger.sizing import FingerRequest, design_finger, finger_stiffness_n_per_m
from musclewire_design._finger.statics import EquilibriumSlopes, FingerEquilibrium, equilibria, sensitivity
from musclewire_design._finger.wire import WireOnFinger, wire_on_finger

# Tolerances between two methods for the same number.
WANTED_TOLERANCE, PLANE_TOLERANCE, STRESS_TOLERANCE = 0.01, 0.05, 0.1
LINEAR_FRACTION, RECIPROCAL = 0.02, 1e-4
# Searle's parameter beyond which a strip bends more like a plate than like a beam.
PLATE = 10.0
# The linear response is checked up to the endpoint force that raises the tendon's force by this fraction.
JUDGED_FRACTION = 1.0 / 3.0
JUDGED_TRAVELS = 9
PLANE_STRESS_FRACTIONS = (0.02, 0.5, 1.0)


@dataclass(frozen=True)
class WireToPull:
    """A wire that pulls the finger: its name, both legs' length, pretension and the pretensioner's stiffness."""

    name: str
    length_m: float
    pretension_n: float
    pretensioner_n_per_m: float


@dataclass(frozen=True)
class FingerStudy:
    """Input of a study: a ``request`` to be sized, or a ``geometry`` as it is; the endpoint and the available travel.

    ``finite_elements`` compares with plane stress on a mesh ``refined`` times finer than the coarsest.
    """

    material: Material
    endpoint_m: float
    travel_m: float
    request: FingerRequest | None = None
    geometry: FingerGeometry | None = None
    friction: float = ASSUMED_FRICTION
    obstacle: ElasticObject | None = None
    wire: WireToPull | None = None
    compare: bool = False
    finite_elements: bool = True
    refined: int = 1


class ObjectContact(NamedTuple):
    """The finger on an object at the end of its travel: endpoint, its force, the tendon's; and the force by the curve.

    ``linear_force_n`` follows from the free curve with its compliance; ``force_n`` is solved with contact;
    ``stress_pa`` is the beam's.
    """

    endpoint_m: float
    force_n: float
    tendon_force_n: float
    linear_force_n: float
    stress_pa: float
    at: FingerEquilibrium


@dataclass(frozen=True)
class FingerStudyResult:
    """A finger with its numbers at the requested endpoint."""

    study: FingerStudy
    geometry: FingerGeometry
    stiffness_n_per_m: float
    at: FingerEquilibrium
    slope: EquilibriumSlopes
    friction: ConnectorFriction
    stress_pa: float
    curve: FingerCurve
    checks: list[DesignCheck]
    contact: ObjectContact | None
    wire: WireOnFinger | None
    schemes: list[PullingScheme]
    warnings: list[str] = field(default_factory=list)


def study_finger(study: FingerStudy) -> FingerStudyResult:
    """Return the finger of a study, with its numbers at the requested endpoint.

    Raises CallerError, in one line that names the limit and by how much it is missed: stiffness, endpoint, room,
    stress, process, wire.
    """
    require_valid(study)
    geometry = geometry_for(study)
    chain = finger_chain(geometry)
    at = travel_for_endpoint_m(chain, geometry.stiffness_n_m2, study.endpoint_m, study.travel_m)
    stress = float(beam_stress_pa(geometry, at).max())
    require_unbroken(study, geometry, at, stress)
    max_travel_m = max_free_travel_m(geometry, CURVE_REACH * study.travel_m)
    curve = finger_curve(geometry, curve_travels_m(max_travel_m), study.friction)
    wire = None if study.wire is None else wire_for(study.wire, curve, at.travel_m)
    stiffness = finger_stiffness_n_per_m(geometry)
    contact = None if study.obstacle is None else object_contact(study, geometry, study.obstacle)
    return FingerStudyResult(
        study=study,
        geometry=geometry,
        stiffness_n_per_m=stiffness,
        at=at,
        slope=sensitivity(at),
        friction=friction_at(chain, geometry.stiffness_n_m2, at, study.friction),
        stress_pa=stress,
        curve=curve,
        checks=checks_of(study, geometry, at, stiffness, stress),
        contact=contact,
        wire=wire,
        schemes=schemes_of(study, geometry) if study.compare else [],
        warnings=[*warnings_of(study, geometry, at, stress), *warnings_of_loads(study, geometry, contact, wire)],
    )


def require_valid(study: FingerStudy) -> None:
    """Raise CallerError for invalid numbers."""
    obstacle = study.obstacle
    numbers = {"endpoint": study.endpoint_m, "travel": study.travel_m}
    numbers |= {} if obstacle is None else {"stiffness of the object": obstacle.stiffness_n_per_m}
    for name, value in numbers.items():
        if not 0.0 < value < math.inf:
            raise CallerError(f"{name} is {value:g}: give a number above 0")
    if obstacle is not None and not 0.0 <= obstacle.clearance_m < math.inf:
        raise CallerError(f"the clearance is {obstacle.clearance_m:g} m: give 0 or more")
    if not 0.0 <= study.friction <= MAX_FRICTION:
        raise CallerError(
            f"a friction coefficient of {study.friction:g} is outside 0 to {MAX_FRICTION:g}: give one within"
        )


def geometry_for(study: FingerStudy) -> FingerGeometry:
    """Return the geometry given, or the one sized for the request."""
    if study.geometry is not None:
        return study.geometry
    if study.request is None:
        raise CallerError("a finger requires a stiffness or its dimensions: neither was given, give one")
    return design_finger(study.request, study.material)


def require_unbroken(study: FingerStudy, geometry: FingerGeometry, at: FingerEquilibrium, stress_pa: float) -> None:
    """Raise CallerError if a finger yields or its columns collide before it reaches the endpoint."""
    limit = study.material.yield_stress_pa.value
    if stress_pa > limit:
        raise CallerError(
            f"the beam would bear {1e-6 * stress_pa:.1f} MPa at an endpoint of {1e3 * study.endpoint_m:g} mm, "
            f"{100 * (stress_pa / limit - 1):.0f} % above the {1e-6 * limit:g} MPa at which {study.material.name} "
            "yields: a thinner beam, more length, or less endpoint"
        )
    gap = column_gap_m(geometry, at)
    if gap <= 0.0:
        raise CallerError(
            f"columns of {1e3 * geometry.column_height_m:.2f} mm would overlap by {-1e3 * gap:.3f} mm at an endpoint "
            f"of {1e3 * study.endpoint_m:g} mm: shorter or fewer columns, or less endpoint"
        )


def wire_for(wire: WireToPull, curve: FingerCurve, needed_travel_m: float) -> WireOnFinger:
    """Return the reach of the finger with the wire of the study."""
    return wire_on_finger(
        curve,
        wire.name,
        wire_length_m=wire.length_m,
        pretension_n=wire.pretension_n,
        pretensioner_n_per_m=wire.pretensioner_n_per_m,
        needed_travel_m=needed_travel_m,
    )


def checks_of(
    study: FingerStudy, geometry: FingerGeometry, at: FingerEquilibrium, stiffness_n_per_m: float, stress_pa: float
) -> list[DesignCheck]:
    """Return the numbers of a design compared with their references."""
    material = study.material
    feet = (2 * geometry.columns - 1) * FOOT_THICKNESSES * geometry.beam_thickness_m
    bends_as = geometry.flexible_length_m + feet
    closed = pure_moment_stiffness_n_per_m(geometry.stiffness_n_m2, geometry.tendon_offset_m, bends_as)
    wanted = study.request
    checks = (
        []
        if wanted is None
        else [
            DesignCheck(
                "stiffness, as requested", stiffness_n_per_m, wanted.stiffness_n_per_m, "N/m", "about", WANTED_TOLERANCE
            )
        ]
    )
    checks += [
        DesignCheck("travel at the endpoint", at.travel_m, study.travel_m, "m", "below"),
        DesignCheck("stress, yield", stress_pa, material.yield_stress_pa.value, "Pa", "below"),
        DesignCheck("gap between columns", column_gap_m(geometry, at), 0.0, "m", "above"),
        DesignCheck("stiffness, closed form EI/(r^2 L)", stiffness_n_per_m, closed, "N/m", "shown"),
        DesignCheck("width: b^2/(R t), beyond 10 a plate", searle(geometry, at), PLATE, "1", "shown"),
        *curve_checks(study, geometry, at),
    ]
    return checks + (plane_stress_checks(study, geometry, at) if study.finite_elements else [])


def searle(geometry: FingerGeometry, at: FingerEquilibrium) -> float:
    """Return b^2/(R t) at the sharpest bend: whether a strip can still curve across its depth as a beam does."""
    bent = float(np.abs(at.placed.chain.turns @ at.angles_rad / at.placed.chain.yielding_m).max())
    return geometry.beam_depth_m**2 * bent / geometry.beam_thickness_m


def curve_checks(study: FingerStudy, geometry: FingerGeometry, at: FingerEquilibrium) -> list[DesignCheck]:
    """Return checks of the curve's linear response to endpoint forces against direct solutions."""
    judged_n = JUDGED_FRACTION * at.tendon_force_n / sensitivity(at).tendon_force_per_endpoint_force
    travels = np.linspace(0.0, study.travel_m, JUDGED_TRAVELS)[1:]
    linear = linear_error(geometry, travels, judged_n * np.array([0.5, 1.0]))
    max_y_m, max_n = LINEAR_FRACTION * at.endpoint_displacement_m, LINEAR_FRACTION * at.tendon_force_n
    return [
        DesignCheck(
            "dT/df over dy/dx less 1: reciprocity", reciprocity_error(geometry, travels), RECIPROCAL, "1", "below"
        ),
        DesignCheck(
            f"endpoint by linear curve to {judged_n:.2g} N, off by", linear.displacement_m, max_y_m, "m", "below"
        ),
        DesignCheck(f"tendon by linear curve to {judged_n:.2g} N, off by", linear.tendon_force_n, max_n, "N", "below"),
    ]


def plane_stress_checks(study: FingerStudy, geometry: FingerGeometry, at: FingerEquilibrium) -> list[DesignCheck]:
    """Return stiffness, force, endpoint and stress of the chain compared with finite elements at the same travel."""
    meshed = finger_body(geometry, study.material.poisson_ratio.value, study.refined)
    points = list(plane_stress_path(meshed, at.tendon_force_n, np.array(PLANE_STRESS_FRACTIONS)))
    travels = np.array([point.travel_m for point in points])
    ours = equilibria(finger_chain(geometry), geometry.stiffness_n_m2, travels)
    first, last, there = points[0], points[-1], ours[-1]
    slope, fine = ours[0].tendon_force_n / first.travel_m, first.tendon_force_n / first.travel_m
    stress = float(beam_stress_pa(geometry, there).max())
    moved = there.endpoint_displacement_m
    return [
        DesignCheck("stiffness, plane stress", slope, fine, "N/m", "about", PLANE_TOLERANCE),
        DesignCheck(
            "tendon force, plane stress", there.tendon_force_n, last.tendon_force_n, "N", "about", PLANE_TOLERANCE
        ),
        DesignCheck("endpoint, plane stress", moved, last.endpoint_displacement_m, "m", "about", WANTED_TOLERANCE),
        DesignCheck("stress, plane stress", stress, last.stress_pa, "Pa", "about", STRESS_TOLERANCE),
    ]


def object_contact(study: FingerStudy, geometry: FingerGeometry, obstacle: ElasticObject) -> ObjectContact:
    """Return the finger on an object at the end of the available travel."""
    travels = np.linspace(0.0, study.travel_m, 40)
    touching = touch_curve(geometry, travels, obstacle)[-1]
    free = equilibria(finger_chain(geometry), geometry.stiffness_n_m2, travels)[-1]
    compliance = sensitivity(free).endpoint_compliance_m_per_n
    beyond = max(free.endpoint_displacement_m - obstacle.clearance_m, 0.0)
    return ObjectContact(
        touching.endpoint_displacement_m,
        touching.endpoint_force_n,
        touching.tendon_force_n,
        beyond / (compliance + 1.0 / obstacle.stiffness_n_per_m),
        float(beam_stress_pa(geometry, touching).max()),
        touching,
    )


def schemes_of(study: FingerStudy, geometry: FingerGeometry) -> list[PullingScheme]:
    """Return the schemes of actuation of this finger, up to the available travel and the material's yield."""
    return compare_schemes(geometry, study.travel_m, study.material.yield_stress_pa.value)


def warnings_of(study: FingerStudy, geometry: FingerGeometry, at: FingerEquilibrium, stress_pa: float) -> list[str]:
    """Return warnings about the finger."""
    material, found = study.material, []
    lasting = material.allowable_stress_pa.value
    if stress_pa > lasting:
        found.append(
            f"{1e-6 * stress_pa:.0f} MPa at the endpoint is below yield, but above the {1e-6 * lasting:.0f} MPa that "
            f"{material.name} should bear permanently and repeatedly: a thinner beam, or less endpoint"
        )
    plate = 100.0 * (1.0 / (1.0 - material.poisson_ratio.value**2) - 1.0)
    if searle(geometry, at) > PLATE:
        found.append(
            f"at this bend a strip so deep and thin behaves almost as a plate, which is {plate:.0f} % stiffer; "
            "all numbers here are those of a beam: take the stiffness as a lower limit"
        )
    # A chosen process has been respected by the sizing; without one the beam may be too thin for all of them.
    finest = min(material.processes, key=material.minimum_thickness_by)
    min_thickness_m = material.minimum_thickness_by(finest)
    if geometry.beam_thickness_m < min_thickness_m:
        found.append(
            f"no process listed for {material.name} makes a beam of {1e3 * geometry.beam_thickness_m:.2f} mm: the "
            f"finest, {finest}, makes {1e3 * min_thickness_m:g} mm; take a strip of film, or micro-moulding"
        )
    elif geometry.column_width_m < min_thickness_m:
        found.append(
            f"no process listed for {material.name} makes columns of {1e3 * geometry.column_width_m:g} mm: the finest, "
            f"{finest}, makes {1e3 * min_thickness_m:g} mm; wider columns, or another material"
        )
    return found


def warnings_of_loads(
    study: FingerStudy, geometry: FingerGeometry, contact: ObjectContact | None, wire: WireOnFinger | None
) -> list[str]:
    """Return warnings about object and wire."""
    found, limit = [], study.material.yield_stress_pa.value
    if contact is not None and contact.stress_pa > limit:
        found.append(
            f"pulled to the end of its travel against the object, the beam would bear "
            f"{1e-6 * contact.stress_pa:.0f} MPa and yield ({1e-6 * limit:g} MPa): less travel, or a softer object"
        )
    if wire is not None:
        steps = np.linspace(0.0, wire.travel_m, JUDGED_TRAVELS)
        there = equilibria(finger_chain(geometry), geometry.stiffness_n_m2, steps)[-1]
        stress = float(beam_stress_pa(geometry, there).max())
        if stress > limit:
            found.append(
                f"fully heated, the wire would pull the beam to {1e-6 * stress:.0f} MPa and it would yield "
                f"({1e-6 * limit:g} MPa): end its stroke before, by a stop or by control"
            )
    return found + warnings_of_wire(study.wire, wire)


def warnings_of_wire(asked: WireToPull | None, found: WireOnFinger | None) -> list[str]:
    """Return warnings of stresses beyond the vendor's and beyond the data of the wire's alloy."""
    if asked is None or found is None:
        return []
    wire = load_wire(asked.name)
    section = section_m2(wire.diameter_m.value, 2.0)
    reached = ReachedConditions(asked.pretension_n / section, found.wire_stress_pa, section_m2=section)
    return list(beyond_validity(validity_of(load_alloy(wire.alloy)), reached))
