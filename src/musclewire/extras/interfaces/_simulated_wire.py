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
    """A wire on its load and in its circuit."""

    name: str
    constants: WireConstants  # load included
    limits: ProtectionLimits  # of the protection; sense voltage, maximum voltage and shunt are among them
    bench: Mapping[str, float]  # numbers by name, in SI
    stepping: StepControl
    undisturbed: bool  # whether the rig has still air and no faults, which are not part of these numbers

    @property
    def sample_period_s(self) -> float:
        """Time between samples [s]."""
        return self.bench["sample_period_s"]


def simulated_wire(rig: str | Path | RigConfiguration = "simulated", **settings: float | str) -> SimulatedWire:
    """Return the wire of a simulated rig with settings, as of ``mw.open_rig``; CallerError for two wires."""
    configuration, where = simulated_configuration(rig)
    device = open_simulated(configuration, where, settings=settings)
    if not isinstance(device.wires, OneWire):
        raise CallerError(f"{where} has two wires: this needs a rig with one")
    quiet = configuration.surroundings.still and not configuration.offered_keys()
    bench, constants = device.spool.bench.values(), device.wires.constants
    return SimulatedWire(device.spool.wire.name, constants, device.facts.limits, bench, device.stepping, quiet)
