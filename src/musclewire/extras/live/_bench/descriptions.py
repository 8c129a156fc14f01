"""What a page is shown of rigs, models and findings: plain values that JSON can hold, null for NaN and infinity."""

from __future__ import annotations

from typing import Any

import numpy as np

from musclewire.controllers import Event, State, protection_table
from musclewire.experiment import ControlMetrics, Examination, PretensionSweep
from musclewire.rigs import GuardedRig, HasStage, ability
from musclewire.sensing import SHOWN_AS, SensingModel, evaluate

BRANCH_POINTS = 120
# Facts of a rig's metadata that a page shows by their own names.
FACTS = ("wire", "wire_length_m", "wire_diameter_m", "pretension_n", "maximum_force_n")


def described_rig(rig: GuardedRig, name: str, *, simulated: bool) -> dict[str, Any]:
    """Return what is fixed while a rig is open."""
    facts = rig.metadata()
    return {
        "name": name,
        "simulated": simulated,
        "sample_period_s": rig.sample_period_s,
        "sense_voltage_v": rig.sense_voltage_v,
        "maximum_voltage_v": rig.maximum_voltage_v,
        "drive_amplitude_v": rig.drive_amplitude_v,
        "shunt_resistance_ohm": rig.shunt_resistance_ohm,
        "leg_length_m": rig.leg_length_m,
        "has_stage": ability(rig, HasStage) is not None,
        "reference_columns": list(rig.reference_columns),
        "limits": rig.protection_limits._asdict(),
        **{key: facts.get(key) for key in FACTS},
        "wiring": wiring(
            simulated=simulated, voltage=f"{rig.maximum_voltage_v:g} V", shunt=f"{rig.shunt_resistance_ohm:g} ohm"
        ),
    }


def wiring(
    *, simulated: bool, voltage: str = "the rig file's voltage", shunt: str = "the rig file's value"
) -> list[str]:
    """Return what to wire, in the order of the current; before a rig is open, without its numbers."""
    if simulated:
        return ["Nothing is to be wired: this rig is simulated."]
    return [
        f"Supply of at most {voltage}, through a fuse and the switch that cuts it, to the driver.",
        "Driver's output to one end of the wire; the channel of the wire's voltage across the wire itself.",
        f"Other end of the wire to the shunt of {shunt}, the shunt to ground.",
        "Channel of the shunt's voltage across the shunt itself; one common ground.",
        "Keep fingers, paper and plastic away from the wire: it is above 100 C before anything is seen.",
    ]


def described_protection(rig: GuardedRig) -> dict[str, Any]:
    """Return the protection in words, with its estimated temperature and how far that is from the limit."""
    protection, limits = rig.protection, rig.protection_limits
    row = protection_table().row(protection.event) if protection.event is not Event.NONE else None
    return {
        "state": State(protection.state).name.lower(),
        "event": "" if row is None else row.name,
        "cause": "" if row is None else row.cause,
        "remedy": "" if row is None else row.remedy,
        "temperature_k": protection.temperature_k,
        "maximum_temperature_k": limits.maximum_temperature_k,
        "margin_k": limits.maximum_temperature_k - protection.temperature_k,
    }


def described_model(model: SensingModel, file: str) -> dict[str, Any]:
    """Return a model with both branches as points."""
    fraction = np.linspace(model.normalised_min, model.normalised_max, BRANCH_POINTS)
    ohm = model.resistance_min_ohm + fraction * (model.resistance_max_ohm - model.resistance_min_ohm)
    branches = {
        name: {"value": evaluate(coefficients, fraction).tolist(), "resistance_ohm": ohm.tolist()}
        for name, coefficients in (("heating", model.heating_coefficients), ("cooling", model.cooling_coefficients))
    }
    return {
        "file": file,
        "quantity": model.quantity,
        "unit": SHOWN_AS[model.quantity][1],
        "lowest": model.quantity_min,
        "highest": model.quantity_max,
        "gap_pct": 100.0 * model.hysteresis_gap,
        "branches": branches,
        "warnings": list(model.warnings),
    }


def described_examination(found: Examination) -> dict[str, Any]:
    """Return the doctor's findings."""
    checks = [
        {"name": one.name, "ok": one.ok, "text": valued(one.value, one.unit, one.advice)}
        for one in found.findings.worst_first
    ]
    skipped = [{"name": one.name, "text": one.reason} for one in found.findings.unchecked]
    return {"ok": found.ok, "count": found.findings.summary, "checks": checks, "skipped": skipped}


def valued(value: float | str | None, unit: str, advice: str) -> str:
    """Return a measured value with its unit before what it means."""
    if value is None:
        return advice
    shown = value if isinstance(value, str) else f"{value:.4g} {unit if unit != '1' else ''}".strip()
    return f"{shown}: {advice}" if advice else shown


def described_sweep(sweep: PretensionSweep) -> dict[str, Any]:
    """Return the settings of a sweep with their gaps, and the best."""
    rows = [
        {
            "pretension_n": row.pretension_n,
            "gap_pct": row.gap_pct(sweep.quantity),
            "largest_strain_pct": row.stroke_pct,
        }
        for row in sweep.rows
    ]
    best_n = None if sweep.best is None else sweep.best.pretension_n
    said = [*sweep.failures, *sweep.warnings, *filter(None, [sweep.advice])]
    return {"rows": rows, "best_n": best_n, "warnings": said}


def described_metrics(metrics: ControlMetrics) -> dict[str, Any]:
    """Return how well a closed loop followed its target."""
    return {
        "text": str(metrics),
        "mae_mean_pct": metrics.mae_mean_pct,
        "rms_pct": metrics.rms_pct,
        "tracking_rms_pct": metrics.tracking_rms_pct,
        "valid_share": metrics.valid_share,
    }
