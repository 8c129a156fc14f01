"""Air that takes less heat than still air: found by the power with which a model's slow loop passed B."""

from __future__ import annotations

import math

from musclewire.errors import CallerError
from musclewire.parameters import load_alloy, load_wire
from musclewire.rigs import Rig
from musclewire.sensing import SensingModel

# Below this fraction of the power that still air needs, B was passed in calmer or warmer air. By the alloy's numbers
# wires of the catalogue pass it with 0.82 to 0.95 of that power.
CALM_FRACTION = 0.75


def still_air_b_power_w(rig: Rig) -> float | None:
    """Return the power [W] with which a rig's wire passes B in still air, by alloy and tension; None if not known.

    There martensite and austenite are in balance: at B the first grains have turned.
    """
    facts, limits = rig.metadata(), rig.protection_limits
    name, force_n = facts.get("wire"), facts.get("pretension_n")
    try:
        wire = load_wire(str(name))
    except CallerError:
        return None
    alloy = load_alloy(wire.alloy)
    legs = max(1, round(float(facts.get("wire_length_m") or rig.leg_length_m) / rig.leg_length_m))
    leg_force_n = force_n / legs if isinstance(force_n, float) else wire.nominal_force_n.value
    stress_pa = leg_force_n / (0.25 * math.pi * wire.diameter_m.value**2)
    balance_k = alloy.martensite_temperature_k.value + wire.temperature_shift_k.value
    balance_k += stress_pa / alloy.martensite_stress_rate_pa_per_k.value
    return limits.heat_loss_w_per_k * max(0.0, balance_k - limits.ambient_temperature_k)


def heed_air(rig: Rig, model: SensingModel) -> None:
    """Lower what a rig's protection allows if a model's slow loop passed B with less power than still air needs."""
    needed_w, passed_w = still_air_b_power_w(rig), model.b_power_w
    if needed_w is None or not 0.0 < passed_w < CALM_FRACTION * needed_w:
        return
    rig.lower_heat_loss(
        rig.protection_limits.heat_loss_w_per_k * passed_w / needed_w,
        f"the model's slow loop passed B with {passed_w:.3g} W where still air needs {needed_w:.3g} W",
    )
