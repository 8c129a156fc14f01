"""A file that describes one tendon-driven finger: its geometry, and its response to a pull at the tendon."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.parameters._parameter_groups import Parameter
from musclewire.parameters._validation import load_named, shipped_names

MIN_POINTS = 5
EVEN_TOLERANCE = 1e-6


class FingerCurve(BaseModel):
    """A finger's response to tendon travel; every column is (n_points,) over the same evenly spaced travels from 0.

    Force and displacement hold for a finger that touches nothing; a force f [N] that pushes its endpoint back, at the
    same tendon travel, adds ``tendon_force_per_endpoint_force * f`` to the tendon's force and reduces the endpoint's
    displacement by ``endpoint_compliance_m_per_n * f``. Forces are those of both tendon legs together.

    Parameters
    ----------
    tendon_travel_m
        Travel of the tendon [m], rising from 0 in equal steps.
    tendon_force_n
        Force of the tendon [N], rising.
    endpoint_displacement_m
        Displacement of the endpoint [m], rising.
    tendon_force_per_endpoint_force
        Rise of the tendon's force per force at the endpoint.
    endpoint_compliance_m_per_n
        Reduction of the endpoint's displacement per force at it [m/N].
    friction_share
        Rise of the connector's force by friction along the tendon while it pulls, as a fraction of the force without
        friction; while it eases the force falls by as much (capstan law to first order).
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    tendon_travel_m: list[float] = Field(min_length=MIN_POINTS)
    tendon_force_n: list[float]
    endpoint_displacement_m: list[float]
    tendon_force_per_endpoint_force: list[float]
    endpoint_compliance_m_per_n: list[float]
    friction_share: list[float]

    @model_validator(mode="after")
    def _columns_belong_together(self) -> FingerCurve:
        travel = np.asarray(self.tendon_travel_m)
        for name in type(self).model_fields:
            column = getattr(self, name)
            if len(column) != travel.size:
                raise ValueError(
                    f"{name} has {len(column)} numbers, tendon_travel_m has {travel.size}: give one for each travel"
                )
            if not all(math.isfinite(value) for value in column):
                raise ValueError(f"{name} holds a number that is not finite: write it again by 'design finger'")
        steps = np.diff(travel)
        if travel[0] != 0.0 or steps[0] <= 0.0 or np.ptp(steps) > EVEN_TOLERANCE * travel[-1]:
            raise ValueError(
                f"tendon_travel_m must rise from 0 in equal steps, not by {steps.min():g} to {steps.max():g} from "
                f"{travel[0]:g}"
            )
        for name in ("tendon_force_n", "endpoint_displacement_m"):
            if np.any(np.diff(getattr(self, name)) <= 0.0):
                raise ValueError(
                    f"{name} must rise with tendon_travel_m, not by {np.diff(getattr(self, name)).min():g}"
                )
        if min(self.endpoint_compliance_m_per_n) <= 0.0 or min(self.friction_share) < 0.0:
            raise ValueError(
                f"endpoint_compliance_m_per_n (from {min(self.endpoint_compliance_m_per_n):g}) must be above 0, "
                f"friction_share (from {min(self.friction_share):g}) 0 or more"
            )
        return self

    @property
    def stiffness_n_per_m(self) -> float:
        """Stiffness along the tendon at the beginning of its travel [N/m]: the paper's k_f."""
        return (self.tendon_force_n[1] - self.tendon_force_n[0]) / self.tendon_travel_m[1]


class FingerFile(BaseModel):
    """A finger: its name, the inputs of its computation, and its curve.

    Parameters
    ----------
    format
        Always ``musclewire-finger``.
    version
        Version of the format: 1.
    name
        Name of the finger.
    description
        Description of the finger in a sentence.
    geometry
        Numbers that the curve was computed from, each with unit, kind and source.
    curve
        The finger's response to the travel of its tendon.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    format: Literal["musclewire-finger"]
    version: Literal[1]
    name: str
    description: str = ""
    geometry: dict[str, Parameter] = {}
    curve: FingerCurve


def finger_names() -> list[str]:
    """Return the names of the fingers that ship with musclewire."""
    return shipped_names("fingers")


def load_finger(name: str) -> FingerFile:
    """Return a finger that ships with musclewire, by name, or one of a file (.toml), which is read at every call."""
    return load_named(FingerFile, "fingers", "finger", name)
