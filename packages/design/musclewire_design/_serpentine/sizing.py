"""Sizing: the serpentine that has a requested stiffness, fits its envelope, can be made, and survives its travel.

For a number of beams and a width the envelope gives half length and pitch, and the closed form gives the thickness. The
smallest number of beams within all limits is chosen, from four up: with two, the stiffness depends by a quarter and
more on how the connector is guided. Even numbers only: an odd serpentine turns its connector. Then the dimensions are
rounded for the drawing, and plane stress sets the half length, which adjusts finer than the thickness.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from scipy.optimize import brentq

from musclewire.errors import CallerError
from musclewire.parameters import Material
from musclewire_design._design_checks import DesignCheck
from musclewire_design._serpentine import closed_form
from musclewire_design._serpentine.analysis import (
    WANTED_TOLERANCE,
    PretensionerDesign,
    PretensionerDuty,
    analyse,
    finger_problem,
)
from musclewire_design._serpentine.geometry import (
    MIN_HALF_BEAM,
    USUAL_CORNER,
    AvailableRoom,
    SerpentineFittings,
    SerpentineGeometry,
)
from musclewire_design._serpentine.strip import linear_answer

STEP_M = 1e-5
BEAM_NUMBERS = (*range(4, 41, 2), 2)
WIDTH_FRACTIONS = (1.0, 0.85, 0.7, 0.55, 0.4, 0.3)
# If the usual corners have too much stress, larger radii are tried.
CORNER_FRACTIONS = (USUAL_CORNER, 0.5, 1.0)
# Lower bound of the search, thinner than any process makes.
THINNEST_M = 5e-6


@dataclass(frozen=True)
class PretensionerRequest:
    """Requirements: a stiffness [N/m] and a duty, of a material, by a process, within an envelope."""

    stiffness_n_per_m: float
    duty: PretensionerDuty
    material: Material
    envelope: AvailableRoom
    process: str | None = None

    @property
    def min_m(self) -> float:
        """Thinnest strip and slot that the process makes [m]."""
        return self.material.minimum_thickness_by(self.process)

    @property
    def travel_m(self) -> float:
        """Whole travel of the connector [m]."""
        return self.duty.travel_with(self.stiffness_n_per_m) or 0.0


class SerpentineCandidate(NamedTuple):
    """A serpentine of the requested stiffness by the closed form, and the limit it exceeds most, if any."""

    geometry: SerpentineGeometry
    excess: float
    problem: str


def design_pretensioner(request: PretensionerRequest) -> PretensionerDesign:
    """Return a serpentine whose plane-stress stiffness is within 1 % of that requested, all limits kept.

    Parameters
    ----------
    request
        Stiffness, duty, material, process and envelope.

    Returns
    -------
    The first serpentine that keeps every limit, computed and checked; few beams are tried first.

    Raises
    ------
    CallerError
        If there is none: the message names the limit that binds and by how much.
    """
    require_sense(request)
    closest: SerpentineCandidate | None = None
    almost: list[PretensionerDesign] = []
    for corner_fraction in CORNER_FRACTIONS:
        for form in forms(corner_fraction):
            for candidate in tried(request, form):
                made = made_of(request, candidate) if candidate.excess <= 0.0 else None
                if made is not None and made.holds:
                    return made
                almost += [made] if made is not None else []
                if closest is None or candidate.excess < closest.excess:
                    closest = candidate
    if closest is None:
        raise CallerError(out_of_reach(request))
    raise CallerError(close_call(request, almost) if almost else closest.problem)


def made_of(request: PretensionerRequest, candidate: SerpentineCandidate) -> PretensionerDesign | None:
    """Return a candidate rounded, trimmed and computed by finite elements; None if trimming misses the stiffness."""
    trimmed = trim(request, candidate.geometry)
    if trimmed is None:
        return None
    return analyse(
        trimmed, request.material, request.process, request.duty, request.envelope, request.stiffness_n_per_m
    )


def require_sense(request: PretensionerRequest) -> None:
    """Raise CallerError for a request that no geometry can meet."""
    wanted, duty = request.stiffness_n_per_m, request.duty
    if not 0.0 < wanted < math.inf:
        raise CallerError(f"a stiffness of {wanted:g} N/m is not possible: it must be above 0")
    if min(request.envelope) <= 0.0:
        raise CallerError("an envelope has three sizes above 0: across the wire, along it, out of plane")
    if duty.pretension_n is None and duty.travel_m is None:
        raise CallerError("give the pretensioner's duty: a pretension (N) or its whole travel (mm)")
    if duty.pretension_n is not None and duty.travel_m is not None and wanted * duty.travel_m < duty.pretension_n:
        reached = wanted * duty.travel_m
        raise CallerError(
            f"{wanted:g} N/m gives {reached:.3f} N at a travel of {1e3 * duty.travel_m:g} mm, "
            f"{duty.pretension_n - reached:.3f} N less than the pretension of {duty.pretension_n:g} N: "
            f"{1e3 * duty.pretension_n / wanted:.2f} mm would do, or {duty.pretension_n / duty.travel_m:.1f} N/m"
        )
    if problem := finger_problem(wanted, duty.finger_stiffness_n_per_m):
        raise CallerError(problem)


class SearchVariables(NamedTuple):
    """Variables of the search: beams, half length over that which fills the width, corner radius over thickness."""

    beams: int
    width_fraction: float
    corner_fraction: float


def forms(corner_fraction: float) -> list[SearchVariables]:
    """Return all forms with such corners, the simplest and widest first."""
    return [SearchVariables(beams, fraction, corner_fraction) for beams in BEAM_NUMBERS for fraction in WIDTH_FRACTIONS]


def shape(request: PretensionerRequest, form: SearchVariables, thickness_m: float) -> SerpentineGeometry:
    """Return the serpentine that fills the envelope along the wire, and a fraction of its width."""
    fittings = SerpentineFittings()
    room = request.envelope.along_m - fittings.pad_height_m - fittings.connector_height_m
    pitch = (room + thickness_m) / (form.beams + 2)
    half = 0.5 * form.width_fraction * (request.envelope.across_m - thickness_m)
    return SerpentineGeometry.with_corner_fraction(
        form.beams, half, pitch, thickness_m, request.envelope.depth_m, form.corner_fraction
    )


def thickest_m(request: PretensionerRequest, form: SearchVariables) -> float:
    """Return the largest thickness [m] with slots wide enough and beams long enough; 0 or less if none does."""
    fittings = SerpentineFittings()
    room = request.envelope.along_m - fittings.pad_height_m - fittings.connector_height_m
    slots = (room - (form.beams + 2) * request.min_m) / (form.beams + 1)
    across = request.envelope.across_m
    if across < max(fittings.pad_width_m, fittings.connector_width_m):
        return 0.0
    beam = form.width_fraction * across / (2.0 * (MIN_HALF_BEAM + form.corner_fraction + 0.5) + form.width_fraction)
    return min(slots, beam) * (1.0 - 1e-9)


def estimate_n_per_m(request: PretensionerRequest, geometry: SerpentineGeometry) -> float:
    """Return the stiffness by the closed form with rounded corners and shear [N/m]."""
    material = request.material
    return closed_form.rounded_stiffness_n_per_m(
        geometry, material.youngs_modulus_pa.value, material.poisson_ratio.value
    )


def tried(request: PretensionerRequest, form: SearchVariables) -> list[SerpentineCandidate]:
    """Return the serpentine of this form that has the requested stiffness; nothing if none fits."""
    max_thickness_m = thickest_m(request, form)
    if max_thickness_m <= THINNEST_M:
        return []

    def miss(thickness: float) -> float:
        return math.log(estimate_n_per_m(request, shape(request, form, thickness)) / request.stiffness_n_per_m)

    if miss(max_thickness_m) < 0.0 or miss(THINNEST_M) > 0.0:
        return []
    geometry = shape(request, form, brentq(miss, THINNEST_M, max_thickness_m, xtol=1e-9))
    return [judged(request, geometry)]


def judged(request: PretensionerRequest, geometry: SerpentineGeometry) -> SerpentineCandidate:
    """Return a serpentine with the limit it exceeds most."""
    min_thickness_m, allowed = request.min_m, request.material.allowable_stress_pa.value
    process = request.material.process_called(request.process)
    stress = closed_form.nominal_stress_pa(geometry, request.stiffness_n_per_m * request.travel_m)
    stress *= closed_form.corner_stress_factor(geometry)
    where = f"{request.stiffness_n_per_m:g} N/m of {request.material.name} with {geometry.beams} beams in this envelope"
    thin = (
        min_thickness_m / geometry.thickness_m - 1.0,
        f"too thin to make: {where} would be {1e3 * geometry.thickness_m:.3f} mm thick, "
        f"{1e3 * (min_thickness_m - geometry.thickness_m):.3f} mm below the {1e3 * min_thickness_m:g} mm that "
        f"'{process}' makes; give a larger envelope, less depth, a softer material or another process",
    )
    weak = (
        stress / allowed - 1.0,
        f"too much stress: {where} has {1e-6 * stress:.1f} MPa at a travel of {1e3 * request.travel_m:.2f} mm, "
        f"{1e-6 * (stress - allowed):.1f} MPa above the {1e-6 * allowed:g} MPa it may bear permanently (yield "
        f"{1e-6 * request.material.yield_stress_pa.value:g} MPa); give a larger envelope, less travel or a stronger "
        "material",
    )
    excess, problem = max(thin, weak)
    return SerpentineCandidate(geometry, excess, problem)


def out_of_reach(request: PretensionerRequest) -> str:
    """Return why no serpentine has the requested stiffness: envelope too small or stiffness out of range."""
    fittings, envelope = SerpentineFittings(), request.envelope
    min_across = max(fittings.pad_width_m, fittings.connector_width_m)
    min_along = fittings.pad_height_m + fittings.connector_height_m + 4.0 * request.min_m + 3.0 * request.min_m
    for name, room, need in (
        ("across", envelope.across_m, min_across),
        ("along", envelope.along_m, min_along),
    ):
        if room < need:
            return (
                f"the envelope is too small: pad, connector and two beams take {1e3 * need:.2f} mm {name} the wire, "
                f"{1e3 * (need - room):.2f} mm more than the {1e3 * room:.2f} mm there are"
            )
    return stiffness_out_of_reach(request)


def stiffness_out_of_reach(request: PretensionerRequest) -> str:
    """Return the message for a stiffness above or below those of the serpentines that fit the envelope."""
    stiffest = 0.0
    for form in forms(USUAL_CORNER):
        max_thickness_m = thickest_m(request, form)
        if max_thickness_m > THINNEST_M:
            stiffest = max(stiffest, estimate_n_per_m(request, shape(request, form, max_thickness_m)))
    wanted = request.stiffness_n_per_m
    if stiffest < wanted:
        return (
            f"stiffness out of reach: the stiffest serpentine of {request.material.name} in this envelope has "
            f"{stiffest:.4g} N/m, {wanted - stiffest:.4g} N/m less than the {wanted:g} N/m requested"
        )
    return (
        f"stiffness out of reach: no serpentine of {request.material.name} is as soft as {wanted:g} N/m in this "
        "envelope"
    )


def close_call(request: PretensionerRequest, almost: Sequence[PretensionerDesign]) -> str:
    """Return the limit that closed forms keep and finite elements exceed, with the smallest excess."""

    def beyond(check: DesignCheck) -> float:
        return abs(check.value / check.reference - 1.0)

    worst = [max((check for check in made.checks if not check.ok), key=beyond) for made in almost]
    check = min(worst, key=beyond)
    unit, factor = {"Pa": ("MPa", 1e-6), "m": ("mm", 1e3)}.get(check.unit, (check.unit, 1.0))
    value, limit = factor * check.value, factor * check.reference
    return (
        f"no serpentine of {request.material.name} keeps every limit at {request.stiffness_n_per_m:g} N/m in this "
        f"envelope: {check.name} is {value:.4g} {unit}, {abs(value - limit):.2g} {unit} beyond {limit:.4g} {unit}; "
        "give a little more room, less travel or another material"
    )


def trim(request: PretensionerRequest, geometry: SerpentineGeometry) -> SerpentineGeometry | None:
    """Return the geometry in steps of 0.01 mm whose plane-stress stiffness is the nearest to the requested one.

    Thickness and pitch are rounded down, which makes it softer if anything; a shorter half length compensates. None if
    that misses by more than 1 %.
    """
    thickness = max(down(geometry.thickness_m), request.min_m)
    pitch = down(geometry.pitch_m)
    radius = max(min(down(geometry.corner_radius_m), down(0.5 * (pitch - thickness))), 0.0)
    rounded = geometry.with_(thickness_m=thickness, pitch_m=pitch, corner_radius_m=radius)
    wanted = request.stiffness_n_per_m

    def stiffness(half: float) -> float:
        return linear_answer(rounded.with_(half_length_m=half), request.material).stiffness_n_per_m

    # Stiffness falls with a power of the half length between 2 and 3; a few secants in logarithms land within a step.
    half, power = geometry.half_length_m, -2.7
    max_half_length_m = 0.5 * (request.envelope.across_m - thickness)
    for _ in range(4):
        half = min(half * (wanted / stiffness(half)) ** (1.0 / power), max_half_length_m)
    steps = [down(half), down(half) + STEP_M]
    best = min(
        (step for step in steps if step <= max_half_length_m + 1e-12), key=lambda step: abs(stiffness(step) - wanted)
    )
    best = round(best, 9)
    found = rounded.with_(half_length_m=best)
    return found if abs(stiffness(best) / wanted - 1.0) <= WANTED_TOLERANCE else None


def down(length_m: float) -> float:
    """Return a length rounded down to 0.01 mm [m]."""
    return round(math.floor(length_m / STEP_M + 1e-6) * STEP_M, 9)
