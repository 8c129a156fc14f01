"""Sizing a finger: from requirements to dimensions.

The endpoint's displacement at a given travel depends only on lengths, not on the beam's stiffness: so the tendon's
offset follows from endpoint and travel, then EI from the stiffness along the wire, then thickness and depth from EI and
from the stress. Everything is rounded to what a drawing says, 0.01 mm, in that order, and the last dimension, the
depth, compensates the effect of rounding on the stiffness.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from musclewire.errors import CallerError, NumericsError
from musclewire.parameters import Material
from musclewire_design._finger.chain import finger_chain
from musclewire_design._finger.closed_forms import pure_moment_tip_m
from musclewire_design._finger.curve import beam_stress_pa, column_gap_m, travel_for_endpoint_m
from musclewire_design._finger.geometry import HOLE_RADIUS_M, FingerGeometry
from musclewire_design._finger.statics import FingerEquilibrium, equilibria, equilibrium, sensitivity

ROUNDED_M = 1e-5
# The finger reaches its endpoint with this fraction of the available travel; the rest is reserve.
TRAVEL_FRACTION = 0.95
# Beyond 135 degrees the endpoint only moves back.
MAX_ANGLE_RAD = 0.75 * math.pi
# Minimum wall between a hole and the beam.
WALL_M = 0.1e-3
# Two legs of tendon side by side require this depth.
MIN_DEPTH_M = 2e-3
# From one section to the next: a hundredth of a millimetre, or this fraction of a thick beam.
SECTION_FRACTION = 0.01
# Height of columns over that of their holes: the holes are in the middle, the outer half is the isolator.
COLUMN_HEIGHT_OFFSETS = 2.0
# The search for an offset begins this much further out than that of a uniform arc, and goes inward in these steps.
FURTHEST_GUESS, NEAREST_GUESS, GUESS_STEP = 1.6, 0.4, 1.08
# If the endpoint moves by less than this fraction of the request, the travel is of another order.
MIN_FRACTION = 0.05
# A plate this many times thicker than the beam bends about a hundredth as much.
PLATE_THICKNESSES = 5.0


@dataclass(frozen=True)
class FingerRequest:
    """Requirements of a finger: stiffness along the tendon, endpoint displacement, largest travel.

    ``depth_m`` is the preferred depth, ``max_depth_m`` the available room; ``min_thickness_m`` the thinnest beam that
    can be made.
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
    max_depth_m: float
    min_thickness_m: float


def finger_stiffness_n_per_m(geometry: FingerGeometry) -> float:
    """Return the stiffness along the tendon of the unloaded finger [N/m], both tendon legs together: k_f."""
    chain = finger_chain(geometry)
    return sensitivity(equilibrium(chain, geometry.stiffness_n_m2, 0.0)).tendon_stiffness_n_per_m


def design_finger(request: FingerRequest, material: Material) -> FingerGeometry:
    """Return dimensions, rounded to 0.01 mm, of a finger of a given stiffness and endpoint displacement.

    Parameters
    ----------
    request
        Stiffness, endpoint displacement, travel and the room there is.
    material
        What the finger is made of.

    Returns
    -------
    The dimensions.

    Raises
    ------
    CallerError
        If there is no such finger: the message names the limit that binds and by how much (endpoint out of reach, hole
        inside the beam, columns that touch, thinner than can be made, deeper than there is room, stress above yield).
    """
    for name in ("stiffness_n_per_m", "endpoint_m", "travel_m", "depth_m", "max_depth_m", "min_thickness_m"):
        value = getattr(request, name)
        if not 0.0 < value < math.inf:
            raise CallerError(f"{name} is {value:g}: give a number above 0")
    offset = rounded(offset_for(request), down=True)
    require_hole_beside(request, offset, request.min_thickness_m)
    shape = shape_of(request, offset, material.youngs_modulus_pa.value)
    chosen = section_for(request, material, shape)
    section = shape.with_(beam_thickness_m=chosen.thickness_m, beam_depth_m=chosen.depth_m)
    require_hole_beside(request, offset, chosen.thickness_m)
    gap = column_gap_m(section, chosen.at)
    if gap <= 0.0:
        raise CallerError(
            f"columns of {1e3 * shape.column_height_m:.2f} mm would overlap by {-1e3 * gap:.3f} mm at an endpoint of "
            f"{1e3 * request.endpoint_m:g} mm: fewer columns, or less travel for the same endpoint"
        )
    return section.with_(plate_thickness_m=rounded(PLATE_THICKNESSES * chosen.thickness_m))


def require_hole_beside(request: FingerRequest, offset_m: float, thickness_m: float) -> None:
    """Raise CallerError if the hole for the tendon would cut into the beam."""
    hole = 0.5 * thickness_m + WALL_M + HOLE_RADIUS_M
    if offset_m < hole:
        raise CallerError(
            f"the tendon would run {1e3 * offset_m:.2f} mm from the middle of a {1e3 * thickness_m:.2f} mm beam, and "
            f"its hole requires {1e3 * hole:.2f} mm: a travel of {1e3 * request.travel_m:.2f} mm is "
            f"{100 * (1 - offset_m / hole):.0f} % too little for this endpoint"
        )


def offset_for(request: FingerRequest) -> float:
    """Return the tendon's offset [m] at which the endpoint is reached with the usable fraction of the travel."""
    # Errors of the lengths are raised first, with an offset that cannot be wrong.
    shape_of(request, request.overall_length_m, 1.0)
    flexible = request.overall_length_m - request.plate_length_m
    # Columns spread the bend, so a uniform arc over segments and columns is close.
    angles = np.linspace(0.0, MAX_ANGLE_RAD - request.inward_angle_rad, 400) + request.inward_angle_rad
    across = np.array([pure_moment_tip_m(float(angle), flexible, request.plate_length_m)[1] for angle in angles])
    reached = across - across[0]
    if reached.max() < request.endpoint_m:
        raise CallerError(
            f"an endpoint displacement of {1e3 * request.endpoint_m:g} mm is out of reach: an overall length of "
            f"{1e3 * request.overall_length_m:g} mm gives at most {1e3 * reached.max():.2f} mm at any curl, "
            f"{100 * (1 - reached.max() / request.endpoint_m):.1f} % too little; make the finger longer"
        )
    rising = slice(int(np.argmax(reached)) + 1)
    turn = float(np.interp(request.endpoint_m, reached[rising], angles[rising]) - angles[0])
    return bracketed_offset(request, TRAVEL_FRACTION * request.travel_m, TRAVEL_FRACTION * request.travel_m / turn)


def bracketed_offset(request: FingerRequest, travel_m: float, guess_m: float) -> float:
    """Return the offset [m] at which a travel just reaches the endpoint, searched around a guess.

    The nearer the tendon is to the beam the more the same travel bends it, until it curls. Raises CallerError if the
    endpoint turns back before the requested displacement.
    """
    further, most = FURTHEST_GUESS * guess_m, 0.0

    def too_far(offset_m: float) -> float:
        return endpoint_at(shape_of(request, offset_m, 1.0), travel_m) - request.endpoint_m

    while further > NEAREST_GUESS * guess_m:
        nearer = further / GUESS_STEP
        try:
            missing = too_far(nearer)
            # If the first step is already too far, the guess was useless: the errors below state why.
            if missing >= 0.0 and too_far(further) < 0.0:
                return float(brentq(too_far, nearer, further, xtol=1e-9))
        except NumericsError:
            break
        if missing >= 0.0 or request.endpoint_m + missing < most:
            break
        further, most = nearer, request.endpoint_m + missing
    if most <= MIN_FRACTION * request.endpoint_m:
        raise CallerError(
            f"a travel of {1e3 * request.travel_m:g} mm bends no such finger: its tendon would have to run about "
            f"{1e3 * guess_m:.2g} mm from the middle of the beam; "
            + ("less" if guess_m > 0.1 * request.overall_length_m else "more")
            + f" travel for an endpoint of {1e3 * request.endpoint_m:g} mm"
        )
    raise CallerError(
        f"{request.columns} columns on {1e3 * request.overall_length_m:g} mm move the endpoint {1e3 * most:.2f} mm at "
        f"most before it curls back, {100 * (1 - most / request.endpoint_m):.1f} % less than the "
        f"{1e3 * request.endpoint_m:g} mm asked for: make the finger longer, or its plate or columns smaller"
    )


def endpoint_at(shape: FingerGeometry, travel_m: float) -> float:
    """Return the endpoint's displacement [m] at a travel, approached in steps."""
    steps = np.linspace(0.0, travel_m, 9)[1:]
    return equilibria(finger_chain(shape), shape.stiffness_n_m2, steps)[-1].endpoint_displacement_m


def shape_of(request: FingerRequest, offset_m: float, youngs_modulus_pa: float) -> FingerGeometry:
    """Return a finger with all lengths along it, and a provisional section of the beam."""
    thin = min(0.1 * offset_m, request.min_thickness_m)  # provisional: lengths alone decide the endpoint's displacement
    return FingerGeometry(
        overall_length_m=request.overall_length_m,
        plate_length_m=request.plate_length_m,
        columns=request.columns,
        column_width_m=request.column_width_m,
        column_height_m=column_height_m(offset_m),
        tendon_offset_m=offset_m,
        beam_thickness_m=thin,
        beam_depth_m=request.depth_m,
        inward_angle_rad=request.inward_angle_rad,
        plate_thickness_m=PLATE_THICKNESSES * thin,
        youngs_modulus_pa=youngs_modulus_pa,
    )


def geometry_of_section(
    thickness_m: float,
    depth_m: float,
    offset_m: float,
    lengths: Mapping[str, float],
    columns: int,
    youngs_modulus_pa: float,
) -> FingerGeometry:
    """Return a finger of given section and offset, with columns and plate as the sizing makes them.

    ``lengths`` has overall_length_m, plate_length_m, column_width_m and inward_angle_rad.
    """
    return FingerGeometry(
        columns=columns,
        column_height_m=column_height_m(offset_m),
        tendon_offset_m=offset_m,
        beam_thickness_m=thickness_m,
        beam_depth_m=depth_m,
        plate_thickness_m=rounded(PLATE_THICKNESSES * thickness_m),
        youngs_modulus_pa=youngs_modulus_pa,
        **lengths,
    )


def column_height_m(offset_m: float) -> float:
    """Return the height of columns above the beam's middle [m]: holes in the middle, with a wall around them."""
    return max(COLUMN_HEIGHT_OFFSETS * offset_m, rounded(offset_m + HOLE_RADIUS_M + WALL_M))


def section_for(request: FingerRequest, material: Material, shape: FingerGeometry) -> BeamSection:
    """Return the section that gives the stiffness without yielding: that with the depth nearest to the preferred one.

    Raises CallerError if no section can be made, fits the room and does not yield at the endpoint.
    """
    if request.max_depth_m < MIN_DEPTH_M:
        raise CallerError(
            f"a depth of at most {1e3 * request.max_depth_m:g} mm has no room for two tendon legs side by side: "
            f"{1e3 * (MIN_DEPTH_M - request.max_depth_m):g} mm more are needed"
        )
    found = sections(request, shape)
    if not found:
        raise no_section(request, shape)
    roomy = [section for section in found if section.depth_m <= request.max_depth_m]
    if not roomy:
        raise CallerError(
            f"for {request.stiffness_n_per_m:g} N/m the beam would be {1e3 * found[-1].depth_m:.2f} mm deep, "
            f"{1e3 * (found[-1].depth_m - request.max_depth_m):.2f} mm more than the available room: a softer finger "
            "or more depth"
        )
    limit = material.yield_stress_pa.value
    fitting = [section for section in roomy if section.stress_pa <= limit]
    if not fitting:
        least = min(roomy, key=lambda section: section.stress_pa)
        raise CallerError(
            f"the beam would bear {1e-6 * least.stress_pa:.1f} MPa at an endpoint of {1e3 * request.endpoint_m:g} mm, "
            f"{100 * (least.stress_pa / limit - 1):.0f} % above the {1e-6 * limit:g} MPa at which {material.name} "
            f"yields ({1e3 * least.thickness_m:.2f} mm thick, {1e3 * least.depth_m:.2f} mm deep): more length, more "
            "depth, or a softer finger"
        )
    return min(fitting, key=lambda section: abs(section.depth_m - request.depth_m))


def no_section(request: FingerRequest, shape: FingerGeometry) -> CallerError:
    """Return the error for a stiffness that no section between the thinnest and the thickest beam has."""
    thinnest = rounded(request.min_thickness_m, up=True)
    depth = depth_at(request, shape.with_(beam_thickness_m=thinnest))
    if depth < MIN_DEPTH_M:
        return CallerError(
            f"a beam of {1e3 * thinnest:.2f} mm, the thinnest to be made, would have to be {1e3 * depth:.3f} mm deep "
            f"for {request.stiffness_n_per_m:g} N/m; two tendon legs require {1e3 * MIN_DEPTH_M:g} mm, "
            f"{MIN_DEPTH_M / depth:.1f} times that: another process, a softer material, or a stiffer finger"
        )
    thickest = max(rounded(2.0 * (shape.tendon_offset_m - WALL_M - HOLE_RADIUS_M), down=True), thinnest)
    depth = depth_at(request, shape.with_(beam_thickness_m=thickest))
    return CallerError(
        f"for {request.stiffness_n_per_m:g} N/m a beam of {1e3 * thickest:.2f} mm, the thickest next to the tendon's "
        f"hole, would have to be {1e3 * depth:.2f} mm deep, {1e3 * (depth - request.max_depth_m):.2f} mm more than "
        "the available room: a softer finger or a stiffer material"
    )


class BeamSection(NamedTuple):
    """A beam's section of the requested stiffness, the finger at its endpoint, and its stress there."""

    thickness_m: float
    depth_m: float
    at: FingerEquilibrium
    stress_pa: float


def sections(request: FingerRequest, shape: FingerGeometry) -> list[BeamSection]:
    """Return all sections of the wanted stiffness that can be made and are deep enough, thinnest first.

    Of those too deep only the shallowest is kept, for the message.
    """
    found: list[BeamSection] = []
    thinnest = rounded(request.min_thickness_m, up=True)
    # Stiffness is proportional to the cube of the thickness: a thinner beam would be too deep.
    needless = 0.9 * np.cbrt(depth_at(request, shape.with_(beam_thickness_m=thinnest)) / (1.2 * request.max_depth_m))
    thickness = max(thinnest, rounded(thinnest * float(needless)))
    while thickness < 2.0 * shape.tendon_offset_m:
        depth = depth_at(request, shape.with_(beam_thickness_m=thickness))
        if depth < MIN_DEPTH_M:
            break
        if depth <= 1.2 * request.max_depth_m:
            found.append(section_at(request, shape.with_(beam_thickness_m=thickness, beam_depth_m=rounded(depth))))
        thickness = rounded(thickness + max(ROUNDED_M, SECTION_FRACTION * thickness))
    return found


def section_at(request: FingerRequest, geometry: FingerGeometry) -> BeamSection:
    """Return a section with its stress at the endpoint."""
    chain = finger_chain(geometry)
    at = travel_for_endpoint_m(chain, geometry.stiffness_n_m2, request.endpoint_m, request.travel_m)
    stress = float(beam_stress_pa(geometry, at).max())
    return BeamSection(geometry.beam_thickness_m, geometry.beam_depth_m, at, stress)


def depth_at(request: FingerRequest, geometry: FingerGeometry) -> float:
    """Return the depth [m] of the requested stiffness: both are proportional."""
    return geometry.beam_depth_m * request.stiffness_n_per_m / finger_stiffness_n_per_m(geometry)


def rounded(length_m: float, *, down: bool = False, up: bool = False) -> float:
    """Return a length rounded to hundredths of a millimetre, as in a drawing."""
    count = length_m / ROUNDED_M
    whole = math.floor(count + 1e-9) if down else math.ceil(count - 1e-9) if up else round(count)
    return round(whole * ROUNDED_M, 8)
