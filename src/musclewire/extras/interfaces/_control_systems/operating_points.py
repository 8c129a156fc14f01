"""Where a wire rests at a constant drive: its operating points, on the way up and on the way down."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from musclewire.errors import CallerError
from musclewire.extras.interfaces._control_systems.heating import heat_flow_of, heated_to
from musclewire.extras.interfaces._simulated_wire import SimulatedWire, simulated_wire
from musclewire.rigs import RigConfiguration
from musclewire.wire import WireState, resting_state

Branch = Literal["heating", "cooling"]
# Points between cold and hottest at which a branch is looked at before its root is searched for.
SCAN_POINTS = 400
# An enthalpy is found to this fraction of the whole range.
ENTHALPY_TOLERANCE = 1e-13


@dataclass(frozen=True)
class OperatingPoint:
    """A wire at rest at a constant drive voltage: heat in equals heat out, and the load is balanced."""

    wire: SimulatedWire  # the wire on its load and in its circuit
    state: WireState  # the simulated wire there, with the memory of how it came
    start: WireState  # the simulated wire at the beginning of its branch: cold at rest, or hot at the maximum voltage
    drive_voltage_v: float  # the drive that holds it there
    branch: Branch  # how it was reached: "heating" from cold, or "cooling" from the maximum voltage

    @property
    def displacement_m(self) -> float:
        """Displacement of the connector [m]."""
        return self.state.connector_contraction * self.wire.constants.leg_length_m

    @property
    def strain(self) -> float:
        """Strain as a fraction, contraction positive."""
        return self.state.connector_contraction

    @property
    def temperature_k(self) -> float:
        """Temperature of the wire [K]."""
        return self.state.temperature_k

    @property
    def resistance_ohm(self) -> float:
        """Resistance of the wire [ohm]."""
        return self.state.resistance_ohm

    @property
    def force_n(self) -> float:
        """Force of all legs together [N]."""
        constants = self.wire.constants
        return self.state.stress_pa * constants.legs * constants.area_m2


def operating_point(
    displacement_m: float, rig: str | Path | RigConfiguration = "simulated", *, branch: Branch = "heating"
) -> OperatingPoint:
    """Return the operating point of a rig's wire at a displacement of its connector.

    Parameters
    ----------
    displacement_m
        Displacement of the connector [m], positive for a shorter wire.
    rig
        A simulated rig with one wire: its name, its file, or a configuration; its air is taken as still.
    branch
        "heating": reached from cold. "cooling": reached from where the maximum voltage holds the wire.

    Returns
    -------
    The operating point, with the drive voltage that holds it.

    Raises
    ------
    CallerError
        For a displacement that the wire does not reach on this branch within the rig's drive voltages, with those that
        it does.
    NumericsError
        If the wire finds no balance with its load.
    """
    wire = simulated_wire(rig)
    cold = resting_state(wire.constants)
    hot = steady_state(wire, cold, wire.limits.maximum_voltage_v)
    start, end = (cold, hot) if branch == "heating" else (hot, cold)
    leg_m = wire.constants.leg_length_m

    def missing_m(enthalpy_j: float) -> float:
        return heated_to(start, wire.constants, enthalpy_j).connector_contraction * leg_m - displacement_m

    low_m, high_m = (displacement_m + missing_m(state.enthalpy_j) for state in (cold, hot))
    if not low_m < displacement_m < high_m:
        raise CallerError(
            f"on the {branch} branch this wire rests between {1e3 * low_m:.3g} and {1e3 * high_m:.3g} mm, and not at "
            f"{1e3 * displacement_m:.3g} mm: choose a displacement between them"
        )
    enthalpy_j = first_root(missing_m, start.enthalpy_j, end.enthalpy_j)
    state = heated_to(start, wire.constants, enthalpy_j)
    return OperatingPoint(wire, state, start, holding_voltage_v(wire, state), branch)


def holding_voltage_v(wire: SimulatedWire, state: WireState) -> float:
    """Return the drive voltage [V] whose power equals the wire's loss to the air."""
    loss_w = heat_flow_of(state, wire.constants, 0.0).loss_w
    return (state.resistance_ohm + wire.constants.series_resistance_ohm) * sqrt(max(loss_w, 0.0) / state.resistance_ohm)


def steady_state(wire: SimulatedWire, start: WireState, drive_voltage_v: float) -> WireState:
    """Return the wire as a constant drive voltage holds it after it has been heated from ``start``."""
    constants = wire.constants

    def flow_w(enthalpy_j: float) -> float:
        flow = heat_flow_of(heated_to(start, constants, enthalpy_j), constants, drive_voltage_v)
        return flow.power_w - flow.loss_w

    step_j = constants.latent_heat_j + 100.0 * constants.heat_capacity_j_per_k
    beyond_j = start.enthalpy_j + step_j
    while flow_w(beyond_j) > 0.0:
        beyond_j += step_j
    return heated_to(start, constants, first_root(flow_w, start.enthalpy_j, beyond_j))


def first_root(function: Callable[[float], float], start: float, end: float) -> float:
    """Return where a function first changes its sign on the way from ``start`` to ``end``."""
    places = np.linspace(start, end, SCAN_POINTS)
    before = function(float(places[0]))
    for low, high in zip(places[:-1].tolist(), places[1:].tolist(), strict=True):
        after = function(high)
        if before * after <= 0.0:
            return float(brentq(function, low, high, xtol=ENTHALPY_TOLERANCE * abs(end - start)))
        before = after
    raise CallerError("no drive voltage within the rig's limits holds the wire there: choose another displacement")
