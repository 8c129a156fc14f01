"""The FMU of a controller: a saved model with its estimator, its controller, drive limits and protection."""

from __future__ import annotations

from typing import NamedTuple

from musclewire.controllers import (
    DriveLimits,
    Event,
    ProtectionLimits,
    protection_table,
)
from musclewire.extras.board import ControllerSettings, collect, constants_header, library_sources
from musclewire.extras.interfaces._fmu.contents import FmuContents, FmuVariables, c_files
from musclewire.sensing import PAPER_ESTIMATOR, SensingModel

QUANTITY_UNITS = {"strain": "", "displacement": "m", "force": "N"}
MODEL_FILE = "mw_controller_model.c"
LEFT_OUT = (
    "the friction of a known load, and the standard deviation of an estimate",
    "a clock: what arrives late or never is the master's to notice",
)
NO_TRACKER = "the tracker that distinguishes a cold wire between A and B from one between B and C"


class LoopInFmu(NamedTuple):
    """A model with its estimator, its controller and that one's settings, and its limits."""

    model: SensingModel
    estimator: str
    controller: str
    settings: ControllerSettings
    limits: ProtectionLimits


def controller_contents(name: str, loop: LoopInFmu, sample_period_s: float) -> FmuContents:
    """Return what is in a loop's FMU; CallerError for an estimator without a form in C and limits that contradict."""
    model, settings, limits = loop.model, loop.settings, loop.limits
    drive = DriveLimits(limits.sense_voltage_v, limits.maximum_voltage_v)
    constants = collect(model, settings, None, drive, limits, loop.estimator)
    header = constants_header(
        constants,
        name=name,
        model=f"{model!r}, {model.source or 'source unknown'}",
        settings=settings,
        quantity=model.quantity,
        double=True,
    )
    return FmuContents(
        title=f"{model.quantity} of a wire from its resistance, by {loop.controller}, and protection",
        variables=controller_variables(loop, sample_period_s),
        sources={**library_sources(), "mw_constants.h": header, MODEL_FILE: c_files("c_fmu")[MODEL_FILE]},
        step_s=sample_period_s,
        owners=("caller", "protection"),
        left_out=(NO_TRACKER, *LEFT_OUT) if loop.estimator == PAPER_ESTIMATOR else LEFT_OUT,
    )


def controller_variables(loop: LoopInFmu, sample_period_s: float) -> FmuVariables:
    """Return the variables of a controller."""
    model, limits = loop.model, loop.limits
    unit, full = QUANTITY_UNITS[model.quantity], model.quantity_max
    quantity = {"unit": unit, "nominal": full}
    said = f"{model.quantity} of {model.quantity_min:.4g} to {full:.4g} {unit}".rstrip()
    highest_v = limits.maximum_voltage_v
    return FmuVariables.from_files("controller", loop.controller).changed(
        {
            "wire_voltage_v": {"nominal": highest_v},
            "shunt_voltage_v": {"nominal": highest_v},
            "target": {**quantity, "start": model.quantity_min, "meaning": f"target: {said}"},
            "estimate": {**quantity, "meaning": f"estimate: {said}"},
            "control_period_s": {"start": sample_period_s},
            "drive_voltage_v": {"maximum": highest_v},
            **protection_names(),
        }
    )


def protection_names() -> dict[str, dict[str, object]]:
    """Return the names of states and events of the protection table."""
    table = protection_table()
    causes = {row.number: row.cause for row in table.event}
    states = tuple((row.number, row.name, "") for row in table.state)
    events = tuple((event.value, event.name.lower(), causes.get(event.value, "")) for event in Event)
    return {"protection_state": {"names": states}, "protection_event": {"names": events}}
