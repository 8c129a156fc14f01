"""The schema of simulated rigs' files, and settings of wire and bench."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal, Self, TypeVar

from pydantic import Field, model_validator

from musclewire.errors import CallerError
from musclewire.parameters.parameter_groups import Bench, Parameter, ParameterGroup, Wire, key_hint
from musclewire.parameters.validation import validated
from musclewire.parameters.wire_file import is_wire_file
from musclewire.rigs.air import Surroundings
from musclewire.rigs.kinds import DeviceConfiguration
from musclewire.rigs.load_kinds import Part, Parts
from musclewire.rigs.mounted_wire import LimitsTable
from musclewire.rigs.pulse_width import PulseWidth
from musclewire.rigs.simulated_faults import SimulatedFault
from musclewire.rigs.wire_keys import WireKeys
from musclewire.signals.units import parse_quantity

__all__ = ["RigConfiguration", "changed_group", "with_settings"]

Group = TypeVar("Group", bound=ParameterGroup)


class RigConfiguration(WireKeys, DeviceConfiguration):
    """A rig file: a wire, by name or wire file, a bench by name, and changes to both.

    The keys of wire and circuit are those of real hardware; ``settings`` change all other numbers of wire and bench.

    Parameters
    ----------
    kind
        "simulated".
    wire_length
        Overall length between the terminals [m]; this and the other keys of wire and circuit are by default those of
        wire and bench.
    legs
        Parts of the wire that share the force.
    shunt
        R of Eq. 1 [ohm].
    sense_voltage
        Drive voltage [V] that hardly heats the wire and still gives a reading.
    maximum_voltage
        Highest drive voltage [V] that is ever allowed.
    drive_amplitude
        Amplitude of the slow sine [V].
    pretension
        Force of the cold wire [N].
    ambient_temperature
        Temperature of the air [K].
    sample_period
        Time between samples [s].
    settings
        Other numbers of wire and bench by name, in SI or as text with a unit.
    wire
        Name of a wire (``musclewire simulate --list``), or a wire file next to the rig file.
    bench
        Name of a bench. By default the paper's, with the numbers of the bench that the wire file contains.
    new_wire
        Whether the wire starts before its first cycles (shakedown).
    seed
        Seed of the instruments' noise.
    load
        Load of the wire, part by part; by default the bench's spring.
    surroundings
        How the air moves; by default it does not.
    limits
        Limits of the protection that replace those which follow from wire and circuit.
    fault
        Faults of wire, circuit, channels and clock, with their times.
    pwm
        Heating by pulse width instead of a steady voltage, and when the voltages are read within the pulses.
    """

    kind: Literal["simulated"] = "simulated"
    wire: str = "paper-100um"
    bench: str = "paper"
    new_wire: bool = False
    seed: int = Field(default=1, ge=0)
    load: list[Part] = Field(default_factory=list)
    surroundings: Surroundings = Surroundings()
    limits: LimitsTable = LimitsTable()
    fault: list[SimulatedFault] = Field(default_factory=list)
    pwm: PulseWidth | None = None

    @model_validator(mode="after")
    def _pulses_heat_one_sound_wire(self) -> RigConfiguration:
        if self.pwm is not None and self.fault:
            raise ValueError("[pwm] and [[fault]] do not go together: faults are of a steady drive; leave one out")
        if self.pwm is not None and any(part.second_wire is not None for part in self.load):
            raise ValueError("[pwm] heats one wire: leave out the second one, or [pwm]")
        return self

    @model_validator(mode="after")
    def _parts_fit_together(self) -> RigConfiguration:
        if "load" in self.model_fields_set and not self.load:
            raise ValueError("load is empty: give a [[load]] part, or leave load out for the bench's spring")
        Parts(load=self.load)
        return self

    def with_files_in(self, folder: Path) -> Self:
        """Return a rig file's content with the files it names found next to it, wherever the command was started.

        Parameters
        ----------
        folder
            Folder of the rig file.

        Returns
        -------
        A configuration whose paths are valid from anywhere.
        """

        def found(name: str | None) -> str | None:
            return str(folder / name) if name is not None and is_wire_file(name) else name

        def placed(part: Part) -> Part:
            known = {key: value for key, value in dict(part).items() if key in ("wire", "finger", "file")}
            return part.model_copy(update={key: found(value) for key, value in known.items()})

        return self.model_copy(update={"wire": found(self.wire), "load": [placed(part) for part in self.load]})


def with_settings(wire: Wire, bench: Bench, settings: Mapping[str, float | str], where: str) -> tuple[Wire, Bench]:
    """Return wire and bench with some numbers set by the user, in SI or as text with a unit ("1.7 N").

    Raises CallerError for a name that neither has, suggesting the nearest.
    """
    known = {**dict(bench.items()), **dict(wire.items())}
    changed: dict[str, Parameter] = {}
    for key, given in settings.items():
        if key not in known:
            raise CallerError(f"{where}: unknown setting '{key}'{key_hint(key, known)}")
        value = parse_quantity(given, known[key].unit) if isinstance(given, str) else float(given)
        changed[key] = known[key].model_copy(
            update={"value": value, "kind": "assumed", "source": where, "note": "set by the user"}
        )
    return changed_group(wire, changed, where), changed_group(bench, changed, where)


def changed_group(group: Group, changed: Mapping[str, Parameter], where: str) -> Group:
    """Return a group with those of the changed parameters that it has, checked like a file."""
    own = {key: item.model_dump() for key, item in changed.items() if key in type(group).model_fields}
    return validated(type(group), {**group.model_dump(), **own}, where) if own else group
