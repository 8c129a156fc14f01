"""A designed finger as a file: dimensions with their sources, and the curve computed from them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from musclewire.errors import CallerError
from musclewire.parameters import FingerCurve, FingerFile, Parameter
from musclewire.small_files import toml_text
from musclewire_design._finger.curve import finger_curve
from musclewire_design._finger.finger_study import FingerStudyResult
from musclewire_design._finger.friction import ASSUMED_FRICTION, FRICTION_SOURCE
from musclewire_design._finger.geometry import UNITS, FingerGeometry

FRICTION_KEY = "friction_coefficient"


def geometry_parameters(
    geometry: FingerGeometry, sources: Mapping[str, tuple[str, str]], friction: float = ASSUMED_FRICTION
) -> dict[str, Parameter]:
    """Return dimensions as parameters; ``sources`` gives kind and source by name, the others were derived by design."""
    usual = ("derived", "musclewire design finger")
    values = {**geometry.values(), FRICTION_KEY: friction}
    units = {**UNITS, FRICTION_KEY: "1"}
    named = {
        FRICTION_KEY: ("assumed", FRICTION_SOURCE) if friction == ASSUMED_FRICTION else ("assumed", "given"),
        **sources,
    }
    return {
        key: Parameter(value=value, unit=units[key], kind=kind, source=source)  # type: ignore[arg-type]
        for key, value in values.items()
        for kind, source in [named.get(key, usual)]
    }


def finger_study_file_text(name: str, result: FingerStudyResult) -> str:
    """Return the text of a finger's file for a result: dimensions and curve; every number keeps all its bits."""
    geometry, study = result.geometry, result.study
    sized = "musclewire design finger" if study.request else "given to musclewire design finger"
    kind = "derived" if study.request else "assumed"
    sources = dict.fromkeys(UNITS, (kind, sized))
    sources["youngs_modulus_pa"] = ("datasheet", f"material {study.material.name}")
    description = (
        f"A finger of {study.material.name}, {result.stiffness_n_per_m:.1f} N/m along the tendon, endpoint "
        f"{1e3 * result.at.endpoint_displacement_m:g} mm at {1e3 * result.at.travel_m:.3f} mm"
    )
    parameters = geometry_parameters(geometry, sources, study.friction)
    made = FingerFile(
        format="musclewire-finger",
        version=1,
        name=name,
        description=description,
        geometry=parameters,
        curve=result.curve,
    )
    return toml_text(made.model_dump())


def finger_geometry(finger: FingerFile) -> FingerGeometry:
    """Return the dimensions a finger's file states. Raises CallerError for a file with a curve only."""
    return FingerGeometry.from_parameters(finger.geometry, f"finger {finger.name}")


def recomputed_curve(finger: FingerFile) -> FingerCurve:
    """Return the curve computed again from the dimensions in a finger's file, over the file's travels."""
    if FRICTION_KEY not in finger.geometry:
        raise CallerError(
            f"finger {finger.name}: geometry.{FRICTION_KEY} is missing: write the file again by 'design finger'"
        )
    friction = finger.geometry[FRICTION_KEY].value
    return finger_curve(finger_geometry(finger), np.array(finger.curve.tendon_travel_m), friction)
