"""Analysis of a serpentine by closed form, beam elements and plane stress, and checks of its use."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from musclewire.errors import CallerError
from musclewire.parameters import Material
from musclewire_design._design_checks import DesignCheck
from musclewire_design._frame import chain_stiffness_n_per_m
from musclewire_design._serpentine import closed_form
from musclewire_design._serpentine.geometry import AvailableRoom, SerpentineGeometry
from musclewire_design._serpentine.strip import (
    FINEST,
    MESHES,
    ForceCurve,
    LinearAnswer,
    force_curve,
    linear_answer,
)

# Tolerances between two methods for the same number.
BEAMS_TOLERANCE, STRIP_TOLERANCE, MESH_TOLERANCE, CORNER_TOLERANCE = 0.005, 0.03, 0.005, 0.08
WANTED_TOLERANCE = 0.01
# Thickness over pitch up to which a strip is thin.
THIN = 0.1
# Half length over thickness from which a strip is slender.
SLENDER = 5.0
# Searle's parameter beyond which a strip bends more like a plate than like a beam.
PLATE = 10.0


@dataclass(frozen=True)
class PretensionerDuty:
    """What a pretensioner is for.

    Parameters
    ----------
    pretension_n
        Pretension F_p [N]; None if the travel is given instead.
    stroke_m
        Stroke of the wire [m], over which the pretensioner is stretched further.
    travel_m
        Whole travel of the connector [m], pretension and stroke together; if None it follows from both.
    finger_stiffness_n_per_m
        Stiffness of the finger at the same connector [N/m], which the pretensioner must stay below; None without one.

    Raises
    ------
    CallerError
        For a stroke below 0, or another number that is not above 0.
    """

    pretension_n: float | None = None
    stroke_m: float = 0.0
    travel_m: float | None = None
    finger_stiffness_n_per_m: float | None = None

    def __post_init__(self) -> None:
        """Refuse impossible numbers."""
        for name in ("pretension_n", "travel_m", "finger_stiffness_n_per_m"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < math.inf:
                raise CallerError(f"{name} is {value:g}: it must be above 0")
        if not 0.0 <= self.stroke_m < math.inf:
            raise CallerError(f"stroke_m is {self.stroke_m:g}: it must be 0 or more")

    def travel_with(self, stiffness_n_per_m: float) -> float | None:
        """Return the connector's whole travel [m].

        Parameters
        ----------
        stiffness_n_per_m
            Stiffness of the pretensioner [N/m].

        Returns
        -------
        The travel [m]; None if neither it nor a pretension is given.
        """
        if self.travel_m is not None:
            return self.travel_m
        return None if self.pretension_n is None else self.pretension_n / stiffness_n_per_m + self.stroke_m


@dataclass(frozen=True)
class PretensionerDesign:
    """A serpentine with its computed properties.

    Parameters
    ----------
    geometry
        Its dimensions.
    material
        What it is made of.
    process
        How it is made, one of the material's processes.
    duty
        What it is for.
    linear
        Stiffness and stress for small travel, one answer per mesh, coarse to fine.
    guided
        The same with a connector that cannot turn, on the finest mesh.
    curve
        Force and stress over large travel.
    travel_m
        Travel of the connector at which it was judged [m]; None if the duty does not say.
    stress_pa
        Largest von Mises stress at that travel [Pa]; None without one.
    checks
        What was checked, with its outcome.
    """

    geometry: SerpentineGeometry
    material: Material
    process: str
    duty: PretensionerDuty
    linear: tuple[LinearAnswer, ...]
    guided: LinearAnswer
    curve: ForceCurve
    travel_m: float | None
    stress_pa: float | None
    checks: tuple[DesignCheck, ...]

    @property
    def stiffness_n_per_m(self) -> float:
        """Stiffness along the wire for small travel [N/m], of the finest mesh."""
        return self.linear[-1].stiffness_n_per_m

    def stiffness_at(self, thickness_m: float) -> float:
        """Return the stiffness [N/m] of the same serpentine with another thickness in its plane.

        Parameters
        ----------
        thickness_m
            Thickness of the strip [m].

        Returns
        -------
        The stiffness along the wire for small travel, of the finest mesh.
        """
        return linear_answer(self.geometry.with_(thickness_m=thickness_m), self.material).stiffness_n_per_m

    @property
    def holds(self) -> bool:
        """Whether every check does."""
        return all(check.ok for check in self.checks)

    @property
    def mass_kg(self) -> float:
        """Mass of the strip without pad and connector [kg]."""
        length = sum(piece.length_m for piece in self.geometry.centre_line())
        return length * self.geometry.thickness_m * self.geometry.depth_m * self.material.density_kg_per_m3.value


def analyse(
    geometry: SerpentineGeometry,
    material: Material,
    process: str | None = None,
    duty: PretensionerDuty | None = None,
    envelope: AvailableRoom | None = None,
    wanted_n_per_m: float | None = None,
) -> PretensionerDesign:
    """Return the analysis of a serpentine, with all its checks.

    Raises CallerError for a process that is not known for the material or a travel beyond its range, NumericsError if
    the strip finds no balance.
    """
    asked = duty or PretensionerDuty()
    process = material.process_called(process)
    least = material.minimum_thickness_by(process)
    linear = tuple(linear_answer(geometry, material, across) for across in MESHES)
    guided = linear_answer(geometry, material, FINEST, guided=True)
    travel = asked.travel_with(linear[-1].stiffness_n_per_m)
    curve = force_curve(geometry, material, 0.0 if travel is None else travel)
    stress = None if travel is None else stress_at(travel, curve, material)
    checks = [
        *wanted_checks(linear[-1].stiffness_n_per_m, wanted_n_per_m),
        *model_checks(geometry, material, linear, guided),
        *use_checks(geometry, asked, linear[-1].stiffness_n_per_m, curve, travel, stress, material),
        *making_checks(geometry, least, envelope),
    ]
    return PretensionerDesign(geometry, material, process, asked, linear, guided, curve, travel, stress, tuple(checks))


def wanted_checks(stiffness_n_per_m: float, wanted_n_per_m: float | None) -> list[DesignCheck]:
    """Return the check of the stiffness against the requested one; nothing without one."""
    if wanted_n_per_m is None:
        return []
    return [DesignCheck("stiffness", stiffness_n_per_m, wanted_n_per_m, "N/m", "about", WANTED_TOLERANCE)]


def stress_at(travel_m: float, curve: ForceCurve, material: Material) -> float:
    """Return the largest stress at a travel [Pa]. Raises CallerError for one beyond the computed range."""
    stress = curve.stress_at(travel_m)
    if math.isnan(stress):
        raise CallerError(too_far(travel_m, curve, material))
    return stress


def too_far(travel_m: float, curve: ForceCurve, material: Material) -> str:
    """Return the message for a travel beyond the computed range, with force and stress at its end."""
    stress = float(curve.stress_pa[-1])
    return (
        f"a travel of {1e3 * travel_m:.2f} mm is too far: at {1e3 * curve.travel_m[-1]:.2f} mm "
        f"{curve.force_n[-1]:.3g} N pull at it, and its stress of {1e-6 * stress:.1f} MPa is "
        f"{1e-6 * (stress - material.allowable_stress_pa.value):.1f} MPa above the permanent limit of {material.name}"
    )


def model_checks(
    geometry: SerpentineGeometry, material: Material, linear: tuple[LinearAnswer, ...], guided: LinearAnswer
) -> list[DesignCheck]:
    """Return checks of closed form, beam elements and plane stress against each other.

    Formulas are for slender strips, that with square corners also for thin ones, since rounding shortens the beams in
    proportion to the thickness. Outside their validity they are shown and not judged.
    """
    modulus, ratio = material.youngs_modulus_pa.value, material.poisson_ratio.value
    formula = closed_form.stiffness_n_per_m(geometry, modulus)
    stiffest = closed_form.guided_factor(geometry) * formula
    rounded = closed_form.rounded_stiffness_n_per_m(geometry, modulus, ratio)
    joints = np.array(geometry.vertices_m())
    section = modulus * geometry.second_moment_m4, modulus * geometry.depth_m * geometry.thickness_m
    bent = chain_stiffness_n_per_m(joints, *section)
    led = chain_stiffness_n_per_m(joints, *section, guided=True)
    found = linear[-1].stiffness_n_per_m
    slender = "about" if geometry.half_length_m >= SLENDER * geometry.thickness_m else "shown"
    thin = slender if geometry.thickness_m <= THIN * geometry.pitch_m else "shown"
    beams, strip = BEAMS_TOLERANCE, STRIP_TOLERANCE
    return [
        DesignCheck("beam elements against 3EI/[N a^2 (2a+3p)]", bent, formula, "N/m", slender, beams),
        DesignCheck("beam elements, guided end, against its closed form", led, stiffest, "N/m", slender, 2.0 * beams),
        DesignCheck("plane stress against 3EI/[N a^2 (2a+3p)]", found, formula, "N/m", thin, strip),
        DesignCheck("plane stress against rounded corners and shear", found, rounded, "N/m", slender, strip),
        *mesh_checks(linear),
        *corner_checks(geometry, linear[-1], slender),
        DesignCheck("plane stress, guided end, over the free end", guided.stiffness_n_per_m, found, "N/m", "above"),
    ]


def mesh_checks(linear: tuple[LinearAnswer, ...]) -> list[DesignCheck]:
    """Return checks of each mesh against the finest; the coarsest is only shown."""
    finest = linear[-1].stiffness_n_per_m
    checks = []
    for across, answer in zip(MESHES[:-1], linear[:-1], strict=True):
        name = f"plane stress, {across} across, {answer.unknowns} unknowns, against {FINEST} across"
        rule = "shown" if across == MESHES[0] else "about"
        checks.append(DesignCheck(name, answer.stiffness_n_per_m, finest, "N/m", rule, MESH_TOLERANCE))
    return checks


def corner_checks(geometry: SerpentineGeometry, answer: LinearAnswer, rule: str) -> list[DesignCheck]:
    """Return the check of the stress at the corners against that of a curved beam, if they have a radius."""
    curved = closed_form.corner_stress_factor(geometry)
    if not math.isfinite(curved):
        return []
    factor = answer.stress_pa_per_n / closed_form.nominal_stress_pa(geometry, 1.0)
    return [DesignCheck("stress over 6Fa/(bt^2) against a curved beam's", factor, curved, "1", rule, CORNER_TOLERANCE)]


def use_checks(
    geometry: SerpentineGeometry,
    duty: PretensionerDuty,
    stiffness: float,
    curve: ForceCurve,
    travel: float | None,
    stress: float | None,
    material: Material,
) -> list[DesignCheck]:
    """Return checks that it is strong enough, stiff enough for the pretension, and softer than the finger."""
    checks = []
    if travel is not None and stress is not None:
        checks += strength_checks(geometry, curve, travel, stress, material)
    if duty.pretension_n is not None:
        left = max(curve.safe_travel_m - duty.stroke_m, 0.0)
        checks.append(
            DesignCheck("pull that leaves the stroke safe", curve.force_at(left), duty.pretension_n, "N", "above")
        )
        if duty.travel_m is not None:
            reached = curve.force_at(duty.travel_m)
            checks.append(DesignCheck("pull at the whole travel", reached, duty.pretension_n, "N", "above"))
    if duty.finger_stiffness_n_per_m is not None:
        checks.append(DesignCheck("softer than the finger", stiffness, duty.finger_stiffness_n_per_m, "N/m", "below"))
    return checks


def strength_checks(
    geometry: SerpentineGeometry, curve: ForceCurve, travel_m: float, stress_pa: float, material: Material
) -> list[DesignCheck]:
    """Return checks that it is strong enough for its travel, and narrow enough to bend as a beam."""
    moment = curve.force_at(travel_m) * geometry.half_length_m
    width = closed_form.width_parameter(geometry, moment, material.youngs_modulus_pa.value)
    return [
        DesignCheck("largest stress at the whole travel", stress_pa, material.allowable_stress_pa.value, "Pa", "below"),
        DesignCheck("travel until the allowed stress", curve.safe_travel_m, travel_m, "m", "above"),
        DesignCheck("b^2/(R t) against that of a plate", width, PLATE, "1", "below"),
    ]


def making_checks(geometry: SerpentineGeometry, min_m: float, envelope: AvailableRoom | None) -> list[DesignCheck]:
    """Return checks that the process can make it and that it fits the envelope."""
    checks = [
        DesignCheck("thickness", geometry.thickness_m, min_m, "m", "above"),
        DesignCheck("gap between beams", geometry.gap_m, min_m, "m", "above"),
    ]
    if envelope is not None:
        sizes = (geometry.across_m, geometry.along_m, geometry.depth_m)
        names = ("size across the wire", "size along the wire", "size out of plane")
        checks += [
            DesignCheck(name, size, room, "m", "below") for name, size, room in zip(names, sizes, envelope, strict=True)
        ]
    return checks


def finger_problem(stiffness_n_per_m: float, finger_n_per_m: float | None) -> str | None:
    """Return why a pretensioner is too stiff for a finger, or None: most of the force should go to the finger."""
    if finger_n_per_m is None or stiffness_n_per_m < finger_n_per_m:
        return None
    return (
        f"a pretensioner of {stiffness_n_per_m:.1f} N/m is no softer than the finger of {finger_n_per_m:.1f} N/m: "
        f"it is {stiffness_n_per_m - finger_n_per_m:.1f} N/m too stiff, and would take "
        f"{100 * stiffness_n_per_m / (stiffness_n_per_m + finger_n_per_m):.0f} % of the contraction force: a softer one"
    )
