"""The FMU of a controller: a saved model with the fuzzy-tuned PID, drive limits and protection."""

from __future__ import annotations

from musclewire.controllers import (
    FUZZY_PID_IN_C,
    DriveLimits,
    Event,
    FuzzyPidSettings,
    ProtectionLimits,
    load_rule_base,
    protection_table,
)
from musclewire.extras.board import collect, constants_header, library_sources
from musclewire.extras.interfaces._fmu.contents import FmuContents, FmuVariables, c_files
from musclewire.sensing import SensingModel

QUANTITY_UNITS = {"strain": "", "displacement": "m", "force": "N"}
MODEL_FILE = "mw_controller_model.c"
LEFT_OUT = (
    "the tracker that distinguishes a cold wire between A and B from one between B and C",
    "the friction of a known load, and the standard deviation of an estimate",
    "a clock: what arrives late or never is the master's to notice",
)


def controller_contents(
    name: str, model: SensingModel, settings: FuzzyPidSettings, limits: ProtectionLimits, sample_period_s: float
) -> FmuContents:
    """Return what is in the FMU of a model with its controller, which ticks every ``sample_period_s``.

    Raises CallerError for limits that contradict each other.
    """
    rules = load_rule_base(settings.rule_base)
    drive = DriveLimits(limits.sense_voltage_v, limits.maximum_voltage_v)
    constants = collect(model, settings, rules, drive, limits)
    header = constants_header(
        constants,
        name=name,
        model=f"{model!r}, {model.source or 'source unknown'}",
        rules=str(rules),
        quantity=model.quantity,
        double=True,
    )
    return FmuContents(
        title=f"{model.quantity} of a shape-memory-alloy wire from its resistance, with fuzzy-tuned PID and protection",
        variables=controller_variables(model, limits, sample_period_s),
        sources={**library_sources(), "mw_constants.h": header, MODEL_FILE: c_files("c_fmu")[MODEL_FILE]},
        step_s=sample_period_s,
        owners=("caller", "protection"),
        left_out=(*LEFT_OUT, *((f"the model's gains: {FUZZY_PID_IN_C}",) if model.gains else ())),
    )


def controller_variables(model: SensingModel, limits: ProtectionLimits, sample_period_s: float) -> FmuVariables:
    """Return the variables of a controller."""
    unit, full = QUANTITY_UNITS[model.quantity], model.quantity_max
    quantity = {"unit": unit, "nominal": full}
    said = f"{model.quantity} of {model.quantity_min:.4g} to {full:.4g} {unit}".rstrip()
    highest_v = limits.maximum_voltage_v
    return FmuVariables.from_files("controller").changed(
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
