"""Simulated rigs from their files: the schema, the numbers of wire and bench that a file changes, and the device."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self, TypeVar

from pydantic import Field, ValidationError, model_validator

from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters import (
    Alloy,
    Bench,
    Parameter,
    ParameterGroup,
    Wire,
    bench_known_with,
    checked,
    first_problem,
    is_wire_file,
    load_alloy,
    load_bench,
    load_wire,
    require_seed,
)
from musclewire.rigs._air import Surroundings
from musclewire.rigs._beyond_catalogue import StatedCircuit, refuse_beyond_catalogue
from musclewire.rigs._kinds import DeviceConfiguration, DeviceKind
from musclewire.rigs._load_kinds import Part, Parts
from musclewire.rigs._load_part import Supply
from musclewire.rigs._mounted_wire import LimitsTable, WireKeys
from musclewire.rigs._own_voltages import OwnVoltages, own_voltages, with_own_voltages
from musclewire.rigs._pulse_width import PulseWidth, sampling_problem
from musclewire.rigs._simulated_faults import SimulatedFault
from musclewire.signals import parse_quantity

if TYPE_CHECKING:
    from musclewire.rigs._simulated import SimulatedDevice, SimulatedSpool

Group = TypeVar("Group", bound=ParameterGroup)


class RigConfiguration(WireKeys, DeviceConfiguration):
    """A rig file: a wire, by name or wire file, a bench by name, and changes to both.

    The keys of wire and circuit are those of real hardware; ``settings`` change all other numbers of wire and bench.

    Parameters
    ----------
    kind
        "simulated".
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
    return with_numbers(wire, bench, settings, settings.__getitem__, where)


def with_numbers(
    wire: Wire, bench: Bench, names: Iterable[str], number: Callable[[str], float | str], where: str
) -> tuple[Wire, Bench]:
    """Return wire and bench with these numbers set by the user; ``number`` gives each by its name."""
    known = {**dict(bench.items()), **dict(wire.items())}
    changed: dict[str, Parameter] = {}
    for name in names:
        if name not in known:
            raise CallerError(f"{where}: unknown setting '{name}'{nearest_hint(name, known)}")
        given = number(name)
        if isinstance(given, bool):
            raise CallerError(f"{where}: {name} is {str(given).lower()}, which is no number: give one with its unit")
        value = parse_quantity(given, known[name].unit) if isinstance(given, str) else float(given)
        changed[name] = known[name].model_copy(
            update={"value": value, "kind": "assumed", "source": where, "note": "set by the user"}
        )
    return changed_group(wire, changed, where), changed_group(bench, changed, where)


def changed_group(group: Group, changed: Mapping[str, Parameter], where: str) -> Group:
    """Return a group with those of the changed parameters that it has, checked like a file."""
    own: dict[str, Parameter] = {}
    for name, item in changed.items():
        if name not in type(group).model_fields:
            continue
        try:
            own[name] = Parameter(**dict(item))
            checked(name, own[name], type(group).model_fields[name])
        except ValidationError as error:
            raise CallerError(f"{where}: {name}.{first_problem(error, Parameter)}") from None
        except ValueError as problem:
            raise CallerError(f"{where}: {problem}") from None
    return group.model_copy(update=own)


def open_simulated(
    configuration: RigConfiguration,
    where: str,
    wire: str | None,
    bench: str | None,
    seed: int | None,
    real_time: bool,
    settings: Mapping[str, float | str],
) -> SimulatedDevice:
    """Return the open simulated rig of a rig file, changed as ``open_rig`` says."""
    drawn_from = require_seed(configuration.seed if seed is None else seed, f"{where}: seed")
    # The simulator is loaded when a rig is opened: to check a file, or to open hardware, nobody waits for it.
    from musclewire.rigs._simulated import SimulatedSpool

    alloy, chosen, around = parameters_of(configuration, where, wire, bench, settings)
    spool = SimulatedSpool(chosen, alloy, around, configuration.new_wire)
    return device_of(configuration, where, spool, seed=drawn_from, real_time=real_time, settings=settings)


def parameters_of(
    configuration: RigConfiguration,
    where: str,
    wire: str | None,
    bench: str | None,
    settings: Mapping[str, float | str],
) -> tuple[Alloy, Wire, Bench]:
    """Return alloy, wire and bench of a rig file with all settings. Raises CallerError for wrong ones."""
    name = wire or configuration.wire
    named = load_wire(name)
    around = load_bench(bench or configuration.bench)
    if bench is None and "bench" not in configuration.model_fields_set:
        around = changed_group(around, bench_known_with(name), f"wire file {name}")
    names = dict.fromkeys([*configuration.numbers_set(), *settings])

    def given(name: str) -> float | str:
        return settings[name] if name in settings else configuration.number(name)

    chosen, around = with_numbers(named, around, names, given, where)
    alloy = load_alloy(chosen.alloy)
    return alloy, driven_wire(configuration, (alloy, chosen, around), own_voltages(name), names, where), around


def driven_wire(
    configuration: RigConfiguration,
    parameters: tuple[Alloy, Wire, Bench],
    own: OwnVoltages,
    given: Collection[str],
    where: str,
) -> Wire:
    """Return a rig's wire with the voltages that its numbers ask for, where neither they nor the file state them.

    Parameters
    ----------
    configuration
        The rig file.
    parameters
        Alloy, wire and bench with all their numbers.
    own
        Voltages of the wire as it is named, and what they are for.
    given
        The numbers that are set and not the wire's own, by name.
    where
        The rig file's name in messages.

    Returns
    -------
    The wire with its own amplitude and maximum.

    Raises
    ------
    CallerError
        For a number that is set and that no wire of the catalogue has or survives, unless the file confirms it.
    """
    alloy, wire, bench = parameters
    if not configuration.beyond_catalogue:
        refuse_beyond(wire, bench, given, configuration.limits.changed(), where)
    return with_own_voltages(wire, alloy, bench, own, given, on_the_drive(configuration))


def refuse_beyond(wire: Wire, bench: Bench, given: Collection[str], limits: Mapping[str, float], where: str) -> None:
    """Raise CallerError for a number that is set and that no wire of the catalogue has or survives."""
    numbers: dict[str, tuple[str, ParameterGroup]] = {
        "wire_length": ("wire_length_m", bench),
        "diameter_m": ("diameter_m", wire),
        "maximum_voltage": ("maximum_voltage_v", wire),
        "drive_amplitude": ("drive_amplitude_v", wire),
    }
    stated = {key: group[name] for key, (name, group) in numbers.items() if name in given}
    circuit = StatedCircuit(bench["wire_length_m"], bench["shunt_resistance_ohm"], stated)
    refuse_beyond_catalogue(circuit, limits, where)


def on_the_drive(configuration: RigConfiguration) -> tuple[int, int]:
    """Return how many wires the drive sees in series and in parallel."""
    supplies = [part.second_wire.supply for part in configuration.load if part.second_wire is not None]
    return 1 + (Supply.SERIES in supplies), 1 + (Supply.PARALLEL in supplies)


def device_of(
    configuration: RigConfiguration,
    where: str,
    spool: SimulatedSpool,
    *,
    seed: int,
    real_time: bool,
    settings: Mapping[str, float | str],
) -> SimulatedDevice:
    """Return the simulated device of a rig file with the numbers of a spool, with a steady drive or heated by pulses.

    ``settings`` are those that the numbers already have; they are only checked. Raises CallerError for one that the
    rig's load leaves without effect, and for pulses whose readings are useless.
    """
    from musclewire.rigs._simulated import SimulatedDevice
    from musclewire.rigs._simulated_pwm import PulsedDevice

    given = {*configuration.numbers_set(), *settings}
    if configuration.load and "spring_stiffness_n_per_m" in given:
        raise CallerError(
            f"{where}: the setting 'spring_stiffness_n_per_m' belongs to the bench's spring, and [[load]] replaces it: "
            "give a part 'spring' with a stiffness"
        )
    pwm = configuration.pwm
    problem = None if pwm is None else sampling_problem(pwm, spool.bench.sense_voltage_v.value)
    if problem is not None and problem.useless:
        raise CallerError(f"[pwm] {problem.text}")
    device = (SimulatedDevice if pwm is None else partial(PulsedDevice, pwm))(
        spool,
        parts=configuration.load,
        surroundings=configuration.surroundings,
        seed=seed,
        real_time=real_time,
        limits=configuration.limits.changed(),
        faults=configuration.fault,
        stated=configuration.stated(),
    )
    if "pretension_n" in given and not device.has_stage:
        raise CallerError(
            f"{where}: the setting 'pretension_n' needs a stage, and this rig has none: the part 'weight' is the "
            "pretension"
        )
    return device


def opened(configuration: RigConfiguration) -> SimulatedDevice:
    """Return the simulated device of a rig file without changes."""
    return open_simulated(configuration, "rig", None, None, None, False, {})


SIMULATED = DeviceKind(RigConfiguration, opened)
