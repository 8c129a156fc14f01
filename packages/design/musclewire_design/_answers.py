"""What the design commands print with --json."""

from __future__ import annotations

from typing import Annotated

from musclewire.app import AnswerModel, AnswerRecord, Finite
from musclewire.parameters import FingerCurve
from musclewire_design._design_checks import DesignCheck
from musclewire_design._finger.comparison import PullingScheme
from musclewire_design._finger.finger_study import ObjectContact
from musclewire_design._finger.wire import WireOnFinger

Words = tuple[str, ...]
Numbers = tuple[float, ...]
JudgedNumber = Annotated[DesignCheck, AnswerRecord(without=("tolerance",), infinite=..., ok=bool)]


class FingerDimensions(AnswerModel):
    """The dimensions of a finger."""

    overall_length_m: float
    plate_length_m: float
    columns: int
    column_width_m: float
    column_height_m: float
    tendon_offset_m: float
    beam_thickness_m: float
    beam_depth_m: float
    inward_angle_rad: float
    plate_thickness_m: float
    youngs_modulus_pa: float
    segment_length_m: float


class FingerAnswer(AnswerModel):
    """Of ``design finger``; null without an object, without a wire, and without a file."""

    stiffness_n_per_m: float
    stress_max_pa: float
    geometry: FingerDimensions
    endpoint_m: float
    travel_m: float
    travel_available_m: float
    tendon_force_n: float
    pulling_force_n: float
    easing_force_n: float
    friction_share: float
    tendon_force_per_endpoint_force: float
    endpoint_compliance_m_per_n: float
    range_over_length: float
    bend_rad: float
    checks: tuple[JudgedNumber, ...]
    foam: Annotated[ObjectContact, AnswerRecord(without=("at",))] | None
    wire: Annotated[WireOnFinger, AnswerRecord()] | None
    schemes: tuple[Annotated[PullingScheme, AnswerRecord(without=("angles_rad",))], ...]
    holds: bool
    curve: FingerCurve
    warnings: Words
    finger: str | None
    drawings: Words
    solids: Words


class SerpentineDimensions(AnswerModel):
    """The dimensions of a serpentine."""

    beams: int
    half_length_m: float
    pitch_m: float
    thickness_m: float
    depth_m: float
    corner_radius_m: float
    across_m: float
    along_m: float


class SerpentineCurve(AnswerModel):
    """Force and stress over travel."""

    travel_m: Numbers
    force_n: Numbers
    stress_pa: Numbers


class PretensionerAnswer(AnswerModel):
    """Of ``design pretensioner``; numbers that were not asked for, or are not finite, are null."""

    stiffness_n_per_m: float
    stiffness_guided_n_per_m: float
    stress_max_pa: Finite
    stress_allowable_pa: float
    stress_yield_pa: float
    pretension_n: float | None
    travel_m: float | None
    safe_travel_m: float
    finger_share: float | None
    geometry: SerpentineDimensions
    envelope_m: Numbers | None
    material: str
    process: str
    mass_kg: float
    curve: SerpentineCurve
    checks: tuple[JudgedNumber, ...]
    holds: bool


class IncludedMaterial(AnswerModel):
    """A material that comes with musclewire, and its smallest thickness by process."""

    name: str
    youngs_modulus_pa: float
    poisson_ratio: float
    yield_stress_pa: float
    allowable_stress_pa: float
    density_kg_per_m3: float
    minimum_thickness_m: dict[str, float]


class MaterialsAnswer(AnswerModel):
    """Of ``design pretensioner --list``."""

    materials: tuple[IncludedMaterial, ...]


PretensionerAnswers = PretensionerAnswer | MaterialsAnswer
