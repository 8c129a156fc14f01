"""The simulated wire as systems of python-control: sample by sample with all its memory, and along one branch."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import control
import numpy as np

from musclewire.arrays import FloatArray
from musclewire.extras.interfaces._control_systems.heating import heat_flow_of, heated_to
from musclewire.extras.interfaces._control_systems.linearisation import LinearWire, Motion
from musclewire.extras.interfaces._control_systems.operating_points import OperatingPoint
from musclewire.extras.interfaces._simulated_wire import simulated_wire
from musclewire.rigs import RigConfiguration
from musclewire.wire import WireState, advance, resting_state

READINGS = ("wire_voltage_v", "shunt_voltage_v", "displacement_m", "force_n")
BRANCH_OUTPUTS = ("displacement_m", "strain", "resistance_ohm", "force_n", "temperature_k")


def wire_system(rig: str | Path | RigConfiguration = "simulated") -> tuple[Any, FloatArray]:
    """Return a rig's wire on its load as a nonlinear system in discrete time, and its state cold and at rest.

    Parameters
    ----------
    rig
        A simulated rig with one wire: its name, its file, or a configuration; its air is taken as still.

    Returns
    -------
    A ``control.NonlinearIOSystem`` with the rig's sample period, and the state to begin with. Its input is the drive
    voltage [V]. Its outputs are the readings of the sample that has just ended, without noise: wire voltage [V], shunt
    voltage [V], displacement [m] and force [N], so that a controller between them closes no algebraic loop. Its state
    is all that the simulated wire remembers, by name, and those readings: a run is the simulator's to the bit.

    Raises
    ------
    CallerError
        For a rig that is not simulated or has two wires.
    """
    wire = simulated_wire(rig)
    constants, rest = wire.constants, resting_state(wire.constants)
    count, layout = rest.numbers.size, rest.row.dtype

    def updated(_time_s: float, x: FloatArray, u: FloatArray, _params: dict[str, Any]) -> FloatArray:
        before = WireState(np.array(x[:count]), layout)
        after, means = advance(before, constants, float(np.ravel(u)[0]), wire.sample_period_s, wire.stepping)
        return np.concatenate([after.numbers, [getattr(means, name) for name in READINGS]])

    def readings(_time_s: float, x: FloatArray, _u: FloatArray, _params: dict[str, Any]) -> FloatArray:
        return x[count:]

    system = control.nlsys(
        updated,
        readings,
        inputs=["drive_voltage_v"],
        outputs=list(READINGS),
        states=[*names_of(rest), *(f"last_{name}" for name in READINGS)],
        dt=wire.sample_period_s,
        name="wire",
    )
    return system, np.concatenate([rest.numbers, [0.0, 0.0, 0.0, constants.pretension_n]])


def names_of(state: WireState) -> list[str]:
    """Return a name for each number of a wire's row, those of an array with their place."""
    names: list[str] = []
    for item in state.fields:
        size = int(np.prod(state.row.dtype[item.name].shape, dtype=int))
        names += [item.name] if item.length is None else [f"{item.name}_{place}" for place in range(size)]
    return names


def branch_system(point: OperatingPoint, motion: Motion = "branch") -> Any:
    """Return a wire that moves one way as a smooth nonlinear system in continuous time, with one state.

    Parameters
    ----------
    point
        The operating point at which the system is to be used.
    motion
        "branch": the whole branch on which the point lies, from its start to beyond the point, both ways along it;
        "minor loop": from the point back, in the direction opposite to that in which it was reached.

    Returns
    -------
    A ``control.NonlinearIOSystem``. Its state is the enthalpy [J], its input the drive voltage [V], its outputs
    displacement [m], strain, resistance [ohm], force [N] and temperature [K]. A solution that turns back has left it:
    the wire's memory is not part of the state. ``wire_system`` has it.

    Raises
    ------
    NumericsError
        While it runs, if the wire finds no balance with its load.
    """
    constants = point.wire.constants
    memory = point.start if motion == "branch" else point.state

    def rate(_time_s: float, x: FloatArray, u: FloatArray, _params: dict[str, Any]) -> FloatArray:
        flow = heat_flow_of(heated_to(memory, constants, float(x[0])), constants, float(np.ravel(u)[0]))
        return np.array([flow.power_w - flow.loss_w])

    def shown(_time_s: float, x: FloatArray, _u: FloatArray, _params: dict[str, Any]) -> FloatArray:
        state = heated_to(memory, constants, float(x[0]))
        strain, force_n = state.connector_contraction, state.stress_pa * constants.legs * constants.area_m2
        return np.array([strain * constants.leg_length_m, strain, state.resistance_ohm, force_n, state.temperature_k])

    return control.nlsys(
        rate,
        shown,
        inputs=["drive_voltage_v"],
        outputs=list(BRANCH_OUTPUTS),
        states=["enthalpy_j"],
        name=f"wire on the {point.branch} branch" if motion == "branch" else "wire in a minor loop",
    )


def linear_system(linear: LinearWire) -> Any:
    """Return a linear wire as a state space system in continuous time.

    Parameters
    ----------
    linear
        The wire, linearised at an operating point.

    Returns
    -------
    A ``control.StateSpace`` with the names of :func:`branch_system`, all relative to the operating point.
    """
    slopes = [
        linear.displacement_m_per_j,
        linear.strain_per_j,
        linear.resistance_ohm_per_j,
        linear.force_n_per_j,
        linear.temperature_k_per_j,
    ]
    return control.ss(
        [[linear.rate_per_s]],
        [[linear.power_w_per_v]],
        [[slope] for slope in slopes],
        np.zeros((len(slopes), 1)),
        inputs=["drive_voltage_v"],
        outputs=list(BRANCH_OUTPUTS),
        states=["enthalpy_j"],
        name=f"linear wire, {linear.motion}",
    )
