"""A designed finger as a file: dimensions with where each comes from, and the curve computed from them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from musclewire.design.finger.curve import finger_curve
from musclewire.design.finger.friction import ASSUMED_FRICTION, FRICTION_SOURCE
from musclewire.design.finger.geometry import UNITS, FingerGeometry
from musclewire.errors import CallerError
from musclewire.parameters.finger_file import FingerCurve, FingerFile, finger_file_text
from musclewire.parameters.schema import Parameter

if TYPE_CHECKING:
    from musclewire.design.finger.question import FingerAnswer

__all__ = [
    "answer_file_text",
    "curve_of_file",
    "curve_travels_m",
    "geometry_of_file",
    "geometry_parameters",
]

FRICTION_KEY = "friction_coefficient"
CURVE_POINTS = 57
# The curve goes on beyond the travel the finger was designed for: wires differ.
CURVE_REACH = 4.0 / 3.0


def curve_travels_m(longest_m: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the travels of a curve in a file, (57,) [m], from 0 to ``longest_m``."""
    return np.asarray(np.linspace(0.0, longest_m, CURVE_POINTS))


def geometry_parameters(
    geometry: FingerGeometry, sources: Mapping[str, tuple[str, str]], friction: float = ASSUMED_FRICTION
) -> dict[str, Parameter]:
    """Return dimensions as parameters; ``sources`` gives kind and source by name, all else was derived by design."""
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


def answer_file_text(name: str, answer: FingerAnswer) -> str:
    """Return the text of a finger's file for an answer: dimensions and curve."""
    geometry, question = answer.geometry, answer.question
    sized = "musclewire design finger" if question.request else "given to musclewire design finger"
    kind = "derived" if question.request else "assumed"
    sources = dict.fromkeys(UNITS, (kind, sized))
    sources["youngs_modulus_pa"] = ("datasheet", f"material {question.material.name}")
    description = (
        f"A finger of {question.material.name}, {answer.stiffness_n_per_m:.1f} N/m along the tendon, endpoint "
        f"{1e3 * answer.at.endpoint_displacement_m:g} mm at {1e3 * answer.at.travel_m:.3f} mm"
    )
    return finger_file_text(name, description, geometry_parameters(geometry, sources, question.friction), answer.curve)


def geometry_of_file(finger: FingerFile) -> FingerGeometry:
    """Return the dimensions a finger's file states. Raises CallerError for a file with a curve only."""
    return FingerGeometry.from_parameters(finger.geometry, f"finger {finger.name}")


def curve_of_file(finger: FingerFile) -> FingerCurve:
    """Return the curve computed afresh from the dimensions in a finger's file, over the file's travels."""
    if FRICTION_KEY not in finger.geometry:
        raise CallerError(f"finger {finger.name}: geometry.{FRICTION_KEY} is missing")
    friction = finger.geometry[FRICTION_KEY].value
    return finger_curve(geometry_of_file(finger), np.array(finger.curve.tendon_travel_m), friction)
