"""From what a finger shall do to its dimensions.

Where the endpoint goes at a given travel does not depend on the beam's stiffness, only on lengths: so the tendon's
offset follows from endpoint and travel, then EI from the stiffness along the wire, then thickness and depth from EI and
from the stress. Everything is rounded to what a drawing says, 0.01 mm, in that order, and the last dimension, the
depth, takes up what rounding did to the stiffness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from musclewire.design.finger.chain import finger_chain
from musclewire.design.finger.closed_forms import pure_moment_tip_m
from musclewire.design.finger.curve import bent_per_m, column_gap_m, travel_for_endpoint_m
from musclewire.design.finger.geometry import FingerGeometry
from musclewire.design.finger.statics import equilibria, equilibrium, sensitivity
from musclewire.errors import CallerError, NumericsError
from musclewire.parameters.materials import Material

__all__ = ["FingerRequest", "design_finger", "finger_stiffness_n_per_m"]

ROUNDED_M = 1e-5
# The finger reaches its endpoint with this share of the travel there is; the rest is reserve.
TRAVEL_SHARE = 0.95
# Beyond a right angle and a half the endpoint only comes back.
MOST_ANGLE_RAD = 0.75 * math.pi
# Least wall between a hole and the beam, and the hole's radius: 0.3 mm holes, as fine as is drilled by hand.
HOLE_RADIUS_M, WALL_M = 0.15e-3, 0.1e-3
# Two legs of tendon side by side want this depth.
LEAST_DEPTH_M = 2e-3
# Columns stand out twice as far as their holes: the holes are in the middle, the outer half is the isolator.
COLUMN_HEIGHT_OFFSETS = 2.0
# Plates this much thicker than the beam bend a thousandth of what the beam does.
PLATE_THICKNESSES = 5.0


@dataclass(frozen=True)
class FingerRequest:
    """What a finger shall do: stiffness along the tendon, endpoint displacement, with the travel there is at most.

    ``depth_m`` is the depth wished for, ``most_depth_m`` the most there is room for; ``least_thickness_m`` what can be
    made.
    """

    stiffness_n_per_m: float
    endpoint_m: float
    travel_m: float
    overall_length_m: float
    plate_length_m: float
    columns: int
    column_width_m: float
    inward_angle_rad: float
    depth_m: float
    most_depth_m: float
    least_thickness_m: float


def finger_stiffness_n_per_m(geometry: FingerGeometry) -> float:
    """Return the stiffness along the tendon of the unloaded finger [N/m], both tendon legs together: k_f."""
    chain = finger_chain(geometry)
    return sensitivity(equilibrium(chain, geometry.stiffness_n_m2, 0.0)).tendon_stiffness_n_per_m


def design_finger(request: FingerRequest, material: Material) -> FingerGeometry:
    """Return dimensions, rounded to 0.01 mm, of a finger that does what is asked.

    Raises CallerError, naming the limit that binds and by how much: endpoint out of reach, hole inside the beam,
    columns that touch, thinner than can be made, deeper than there is room, stress above yield.
    """
    for name in ("stiffness_n_per_m", "endpoint_m", "travel_m", "depth_m", "most_depth_m", "least_thickness_m"):
        value = getattr(request, name)
        if not 0.0 < value < math.inf:
            raise CallerError(f"{name} is {value:g}: give a number above 0")
    offset = rounded(offset_for(request), down=True)
    shape = shape_of(request, offset, material.youngs_modulus_pa.value)
    wanted = shape.stiffness_n_m2 * request.stiffness_n_per_m / finger_stiffness_n_per_m(shape)
    at = travel_for_endpoint_m(finger_chain(shape), shape.stiffness_n_m2, request.endpoint_m, request.travel_m)
    gap = column_gap_m(shape, at)
    if gap <= 0.0:
        raise CallerError(
            f"columns of {1e3 * shape.column_height_m:g} mm would overlap by {-1e3 * gap:.3f} mm at an endpoint of "
            f"{1e3 * request.endpoint_m:g} mm: fewer columns, or less travel for the same endpoint"
        )
    curvature = float(np.abs(bent_per_m(at)).max())
    force = at.tendon_force_n * wanted / shape.stiffness_n_m2
    thickness, depth = section_for(request, material, wanted, curvature, force)
    hole = 0.5 * thickness + WALL_M + HOLE_RADIUS_M
    if offset < hole:
        raise CallerError(
            f"the tendon would run {1e3 * offset:.2f} mm from the middle of a beam of {1e3 * thickness:.2f} mm, and its "
            f"hole wants {1e3 * hole:.2f} mm: a travel of {1e3 * request.travel_m:.2f} mm is "
            f"{100 * (1 - offset / hole):.0f} % too little for this endpoint"
        )
    plate = max(PLATE_THICKNESSES * thickness, shape.column_width_m)
    return shape.with_(beam_thickness_m=thickness, beam_depth_m=depth, plate_thickness_m=rounded(plate))


def offset_for(request: FingerRequest) -> float:
    """Return the tendon's offset [m] at which the endpoint is reached with the share of the travel set aside for it."""
    flexible = request.overall_length_m - request.plate_length_m
    # Columns spread the bend, so an even arc over segments and columns is close.
    angles = np.linspace(0.0, MOST_ANGLE_RAD - request.inward_angle_rad, 400) + request.inward_angle_rad
    across = np.array([pure_moment_tip_m(float(angle), flexible, request.plate_length_m)[1] for angle in angles])
    reached = across - across[0]
    if reached.max() < request.endpoint_m:
        raise CallerError(
            f"an endpoint displacement of {1e3 * request.endpoint_m:g} mm is out of reach: an overall length of "
            f"{1e3 * request.overall_length_m:g} mm gives at most {1e3 * reached.max():.2f} mm however far it curls, "
            f"{100 * (1 - reached.max() / request.endpoint_m):.1f} % too little; make the finger longer"
        )
    turn = float(angles[np.argmax(reached >= request.endpoint_m)] - angles[0])
    travel = TRAVEL_SHARE * request.travel_m

    def too_far(offset: float) -> float:
        shape = shape_of(request, offset, 1.0)
        return equilibrium_of(shape, travel) - request.endpoint_m

    guess = travel / turn
    nearer, further = 0.8 * guess, 1.25 * guess
    try:
        return float(brentq(too_far, nearer, further, xtol=1e-9))
    except (ValueError, NumericsError):
        raise CallerError(
            f"an endpoint displacement of {1e3 * request.endpoint_m:g} mm is nearly all that an overall length of "
            f"{1e3 * request.overall_length_m:g} mm gives ({1e3 * reached.max():.2f} mm): make the finger longer"
        ) from None


def equilibrium_of(shape: FingerGeometry, travel_m: float) -> float:
    """Return the endpoint's displacement [m] at a travel, approached in steps."""
    steps = np.linspace(0.0, travel_m, 9)[1:]
    return equilibria(finger_chain(shape), shape.stiffness_n_m2, steps)[-1].endpoint_displacement_m


def shape_of(request: FingerRequest, offset_m: float, youngs_modulus_pa: float) -> FingerGeometry:
    """Return a finger with all lengths along it, and a beam that has yet to get its section."""
    thin = min(0.1 * offset_m, request.least_thickness_m)
    return FingerGeometry(
        overall_length_m=request.overall_length_m,
        plate_length_m=request.plate_length_m,
        columns=request.columns,
        column_width_m=request.column_width_m,
        column_height_m=COLUMN_HEIGHT_OFFSETS * offset_m,
        tendon_offset_m=offset_m,
        beam_thickness_m=thin,
        beam_depth_m=request.depth_m,
        inward_angle_rad=request.inward_angle_rad,
        plate_thickness_m=PLATE_THICKNESSES * thin,
        youngs_modulus_pa=youngs_modulus_pa,
    )


def section_for(
    request: FingerRequest, material: Material, stiffness_n_m2: float, curvature_per_m: float, force_n: float
) -> tuple[float, float]:
    """Return thickness and depth [m] of a beam of this bending stiffness: the depth nearest to the one wished for.

    Raises CallerError where no section is thick enough to make, shallow enough, and unyielding at this curvature.
    """
    modulus, limit = material.youngs_modulus_pa.value, material.yield_stress_pa.value
    at_depth = 12.0 * stiffness_n_m2 / modulus  # b t^3
    thinnest = max((at_depth / request.most_depth_m) ** (1.0 / 3.0), request.least_thickness_m)
    thickest = (at_depth / LEAST_DEPTH_M) ** (1.0 / 3.0)
    if thickest < request.least_thickness_m:
        raise CallerError(
            f"a finger of {request.stiffness_n_per_m:g} N/m wants a beam of at most {1e3 * thickest:.3f} mm, even if "
            f"only {1e3 * LEAST_DEPTH_M:g} mm deep; the thinnest to be made is {1e3 * request.least_thickness_m:g} mm, "
            f"{request.least_thickness_m / thickest:.2f} times that: another process, or a softer material"
        )
    if thinnest > thickest:
        raise CallerError(
            f"a depth of at most {1e3 * request.most_depth_m:g} mm has no room for two tendon legs side by side: give "
            f"{1e3 * LEAST_DEPTH_M:g} mm or more"
        )
    grid = ROUNDED_M * np.arange(math.ceil(thinnest / ROUNDED_M - 1e-9), math.floor(thickest / ROUNDED_M + 1e-9) + 1)
    sections = [(rounded(float(t)), rounded(at_depth / t**3)) for t in grid]
    stresses = [0.5 * modulus * t * curvature_per_m + force_n / (t * b) for t, b in sections]
    fitting = [(t, b) for (t, b), stress in zip(sections, stresses, strict=True) if stress <= limit]
    if not sections or not fitting:
        stress = min(stresses, default=0.5 * modulus * thinnest * curvature_per_m)
        raise CallerError(
            f"the beam would bear {1e-6 * stress:.1f} MPa at an endpoint of {1e3 * request.endpoint_m:g} mm, "
            f"{100 * (stress / limit - 1):.0f} % above the {1e-6 * limit:g} MPa at which {material.name} yields, with "
            f"the thinnest beam that fits ({1e3 * thinnest:.2f} mm): more length to bend, more depth, or less stiffness"
        )
    return min(fitting, key=lambda section: abs(section[1] - request.depth_m))


def rounded(length_m: float, *, down: bool = False) -> float:
    """Return a length as a drawing says it: in hundredths of a millimetre."""
    count = length_m / ROUNDED_M
    return round((math.floor(count + 1e-9) if down else round(count)) * ROUNDED_M, 8)
