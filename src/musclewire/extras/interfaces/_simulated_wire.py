"""The one wire of a simulated rig as plain numbers, for programs that run it without the rig's clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from musclewire.controllers import ProtectionLimits
from musclewire.errors import CallerError
from musclewire.rigs import RigConfiguration, open_simulated, simulated_configuration
from musclewire.wire import OneWire, StepControl, WireConstants


@dataclass(frozen=True)
class SimulatedWire:
    """A wire on its load and in its circuit.

    Parameters
    ----------
    name
        Name of the wire.
    constants
        The simulated wire with its load.
    limits
        Limits of the protection; sense voltage, maximum voltage and shunt are among them.
    bench
        Numbers of the bench by name, in SI.
    stepping
        How the rig divides a sample into steps of the simulation.
    undisturbed
        Whether the rig has still air and no faults; what disturbs it is not part of these numbers.
    """

    name: str
    constants: WireConstants
    limits: ProtectionLimits
    bench: Mapping[str, float]
    stepping: StepControl
    undisturbed: bool

    @property
    def sample_period_s(self) -> float:
        """Time between samples [s]."""
        return self.bench["sample_period_s"]


def simulated_wire(rig: str | Path | RigConfiguration = "simulated", **settings: float | str) -> SimulatedWire:
    """Return the wire of a simulated rig.

    Parameters
    ----------
    rig
        "simulated", the name of another simulated rig, the path of its file, or a configuration.
    settings
        Numbers of wire and bench by name, as ``mw.open_rig`` takes them.

    Returns
    -------
    The wire.

    Raises
    ------
    CallerError
        For a rig that is not simulated or has two wires.
    """
    configuration, where = simulated_configuration(rig)
    device = open_simulated(configuration, where, settings=settings)
    if not isinstance(device.wires, OneWire):
        raise CallerError(f"{where} has two wires: this needs a rig with one")
    quiet = configuration.surroundings.still and not configuration.offered_keys()
    bench, constants = device.spool.bench.values(), device.wires.constants
    return SimulatedWire(device.spool.wire.name, constants, device.facts.limits, bench, device.stepping, quiet)
