"""From the word ``simulated``, a name or a TOML file to an open rig; what the file of a simulated rig may say.

A simulated rig is the wire and the bench that its file names, with the numbers that file and caller change.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeVar, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model, model_validator

from musclewire.errors import CallerError, an_object, argument, nearest_hint
from musclewire.manifest import absent_part, folder_of, loaded, manifests, offered
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
    validated,
)
from musclewire.rigs._air import Surroundings
from musclewire.rigs._beyond_catalogue import StatedCircuit, confirmed_beyond, refuse_beyond_catalogue
from musclewire.rigs._beyond_catalogue import beyond_catalogue as beyond
from musclewire.rigs._device import Metadata
from musclewire.rigs._guarded import GuardedRig
from musclewire.rigs._kinds import DEVICES, DeviceConfiguration, DeviceKind
from musclewire.rigs._load_kinds import Part, Parts
from musclewire.rigs._load_part import second_wire_of
from musclewire.rigs._mounted_wire import (
    NO_TRUTH,
    SHARED_KEYS,
    STATED,
    LimitsTable,
    MountedWire,
    may_be_left_out,
    si_name,
)
from musclewire.rigs._outside import imported_kind, is_outside, known_kind
from musclewire.rigs._own_voltages import PAPER_BENCH, OwnVoltages, hot_wire, own_voltages, with_own_voltages
from musclewire.rigs._remembered_temperature import COLDEST_K, MELTING_K
from musclewire.rigs._rig_key import RigKey
from musclewire.signals import parse_quantity
from musclewire.small_files import read_toml

if TYPE_CHECKING:
    from musclewire.rigs._simulated import SimulatedDevice, SimulatedSpool

Group = TypeVar("Group", bound=ParameterGroup)

SIMULATED = "simulated"
# Rig files that ship with musclewire, each known by its name.
FOLDER = Path(str(files("musclewire.parameters"))) / "data" / "rigs"
# Each key of wire and circuit that is a number of wire or bench, by its name; ``settings`` also accept it by that name.
SETTINGS = {
    key: name
    for key, field in SHARED_KEYS.items()
    if (name := si_name(key, field)) in (*Wire.model_fields, *Bench.model_fields)
}
# Keys of simulated rigs' files that parts outside the core offer.
RIG_KEYS: dict[str, RigKey] = {name: loaded(place) for name, place in offered("rig_keys").items()}


def keys_left_out() -> type[BaseModel]:
    """Return a schema with the keys of wire and circuit, of which each may be left out."""
    types = get_type_hints(MountedWire, include_extras=True)
    fields = {key: (types[key] | None, may_be_left_out(types[key])) for key in SHARED_KEYS}
    schema: type[BaseModel] = create_model(  # type: ignore[call-overload]  # fields by name
        "KeysLeftOut", __config__=ConfigDict(extra="forbid", frozen=True), **fields
    )
    return schema


def offered_keys() -> type[BaseModel]:
    """Return a schema with the keys that parts outside the core offer, of which each may be left out."""
    fields = {name: (key.held, key.field) for name, key in RIG_KEYS.items()}
    schema: type[BaseModel] = create_model("OfferedKeys", **fields)  # type: ignore[call-overload]  # fields by name
    return schema


if TYPE_CHECKING:
    KeysLeftOut = BaseModel
    OfferedKeys = BaseModel
else:
    KeysLeftOut = keys_left_out()
    OfferedKeys = offered_keys()


class WireKeys(KeysLeftOut):
    """The keys of wire and circuit in simulated rigs' files, each by default that of wire or bench.

    Parameters
    ----------
    settings
        Other numbers of wire and bench by name, in SI or as text with a unit.
    """

    settings: dict[str, Annotated[float | str, NO_TRUTH]] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _said_once(self) -> WireKeys:
        for key, name in SETTINGS.items():
            if getattr(self, key) is not None and name in self.settings:
                raise ValueError(f"{key} and settings.{name} are the same number: give {key} only")
        return self

    def numbers_set(self) -> list[str]:
        """Return the names of the numbers of wire and bench that the file sets, by ``settings`` and by keys."""
        return [*self.settings, *(name for key, name in SETTINGS.items() if getattr(self, key) is not None)]

    def number(self, name: str) -> float | str:
        """Return a number that the file sets, in SI, or as text with a unit if ``settings`` have it so."""
        key = next((key for key, own in SETTINGS.items() if own == name and getattr(self, key) is not None), None)
        return self.settings[name] if key is None else float(getattr(self, key))

    def stated(self) -> Metadata:
        """Return what the keys in the file say to a recording but for numbers of wire and bench, which the wire has."""
        said = {name: getattr(self, key) for key, name in STATED.items() if key not in SETTINGS}
        return {name: value for name, value in said.items() if value is not None}


class RigConfiguration(WireKeys, DeviceConfiguration, OfferedKeys):
    """A rig file: a wire, by name or wire file, a bench by name, and changes to both.

    The keys of wire and circuit are those of real hardware; ``settings`` change all other numbers of wire and bench.
    Parts outside the core offer more keys (:class:`RigKey`).

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
    """

    kind: Literal["simulated"] = "simulated"
    wire: str = "paper-100um"
    bench: str = PAPER_BENCH
    new_wire: bool = False
    seed: int = Field(default=1, ge=0)
    load: list[Part] = Field(default_factory=list)
    surroundings: Surroundings = Surroundings()
    limits: LimitsTable = LimitsTable()

    @model_validator(mode="before")
    @classmethod
    def _keys_of_absent_parts(cls, given: Any) -> Any:
        for name in given if isinstance(given, dict) else ():
            absent = None if name in cls.model_fields else absent_part("rig_keys", str(name))
            if absent is not None:
                raise ValueError(str(absent))
        return given

    @model_validator(mode="after")
    def _parts_fit_together(self) -> RigConfiguration:
        if "load" in self.model_fields_set and not self.load:
            raise ValueError("load is empty: give a [[load]] part, or leave load out for the bench's spring")
        Parts(load=self.load)
        return self

    @model_validator(mode="after")
    def _keys_fit_together(self) -> RigConfiguration:
        asked = self.offered_keys()
        if len(asked) > 1:
            written = " and ".join(key.written for key in asked.values())
            raise ValueError(f"{written} do not go together: each asks for another device; leave one out")
        for name, key in asked.items():
            reason = key.misfit(getattr(self, name), self)
            if reason is not None:
                raise ValueError(reason)
        return self

    def offered_keys(self) -> dict[str, RigKey]:
        """Return the keys of parts outside the core with which the file asks for another device, by name."""
        return {name: key for name, key in RIG_KEYS.items() if getattr(self, name)}

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


def shipped_rig_files() -> dict[str, Path]:
    """Return the rig files of the core, then those of the parts that are there, by name."""
    folders = [FOLDER, *(folder_of(manifest.rig_files) for manifest in manifests() if manifest.rig_files)]
    return {file.stem: file for folder in reversed(folders) for file in sorted(folder.glob("*.toml"))}


def read_rig_file(path: str | Path, *, may_import: bool = False) -> DeviceConfiguration:
    """Return a rig file, checked. Raises CallerError naming the file, the key and the nearest right key.

    Only with ``may_import`` is the module of a kind "python:module:Class" imported: for the file that the user named.
    """
    file = Path(path)
    data = read_toml(file, "rig file", "; use the word 'simulated' for the simulated rig")
    if not data:
        raise CallerError(f"rig file {file} states nothing: 'kind = \"simulated\"' is the least of a rig file")
    kind = str(data.get("kind", SIMULATED))
    try:
        if is_outside(kind) and not may_import:
            raise CallerError(f"kind '{kind}' runs code of a module: only a rig that is opened by its path may do that")
        known = imported_kind(kind, file.parent) if is_outside(kind) else DEVICES.find(kind)
    except CallerError as error:
        raise CallerError(f"rig file {file}: {error}") from None
    wire = data.get("wire")
    if issubclass(known.configuration, MountedWire) and isinstance(wire, str) and is_wire_file(wire):
        data["wire"] = str((file.parent / wire).absolute())  # voltages that the file leaves out are the wire file's
    configuration: DeviceConfiguration = validated(known.configuration, data, f"rig file {file}")
    return configuration.with_files_in(file.parent)


def rig_names() -> list[str]:
    """Return the names of the rig files that ship with musclewire, after the word for the paper's bench."""
    return [SIMULATED, *sorted(shipped_rig_files())]


def simulated_configuration(rig: str | Path | RigConfiguration) -> tuple[RigConfiguration, str]:
    """Return a simulated rig's configuration and its name in messages. Raises CallerError for another rig."""
    configuration, where = rig_configuration(rig)
    if not isinstance(configuration, RigConfiguration):
        raise CallerError(f"{where} is not simulated: this experiment changes what the wire pulls, on a simulated rig")
    return configuration, where


def rig_configuration(
    rig: str | Path | DeviceConfiguration, *, may_import: bool = False
) -> tuple[DeviceConfiguration, str]:
    """Return a rig's configuration and its name in messages. Raises CallerError for unknown names and wrong files."""
    if not isinstance(rig, DeviceConfiguration | str | Path):
        raise CallerError(
            f"a rig is given by its name, the path of a rig file or a configuration, not by {an_object(rig)}: a device "
            'of your own is named in a rig file, kind = "python:module:Class"'
        )
    if isinstance(rig, DeviceConfiguration):
        return rig.model_copy(update={"beyond_catalogue": True}) if confirmed_beyond() else rig, "rig"
    if str(rig) == SIMULATED:
        return RigConfiguration(), SIMULATED
    named, shipped = offered("rig_names").get(str(rig), str(rig)), shipped_rig_files()
    if named in shipped and (named == str(rig) or not Path(rig).exists()):
        return read_rig_file(shipped[named]), f"rig {named}"
    if Path(rig).suffix != ".toml" and not Path(rig).exists():
        if (absent := absent_part("rig_files", str(rig))) is not None:
            raise absent
        hint = nearest_hint(str(rig), rig_names())
        or_file = " Otherwise give" if hint.endswith("?") else ", or give"
        raise CallerError(f"there is no rig '{rig}'{hint}{or_file} the path of a TOML rig file")
    return read_rig_file(rig, may_import=may_import), f"rig file {rig}"


def require_rig(rig: str) -> None:
    """Raise CallerError for an unknown name, a missing file and an invalid one; no module is imported for it."""
    if Path(rig).is_file() and is_outside(str(read_toml(Path(rig), "rig file").get("kind", SIMULATED))):
        return  # its keys are those of the class, which only the rig's own process imports
    rig_configuration(rig)


def with_settings(wire: Wire, bench: Bench, settings: Mapping[str, float | str], where: str) -> tuple[Wire, Bench]:
    """Return wire and bench with numbers of the user, SI or text ("1.7 N"). Raises CallerError for unknown names."""
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
            raise CallerError(f"{where}: " + str(problem)) from None
    return group.model_copy(update=own)


def wire_on_bench(
    wire: str, bench: str | None, names: Iterable[str], number: Callable[[str], float | str], where: str
) -> tuple[Wire, Bench]:
    """Return a wire and a bench, by their names, with the numbers that are set; ``number`` gives each by its name.

    Without a bench it is the paper's, with those of its numbers that the wire's file has. Raises CallerError for
    unknown names and wrong numbers.
    """
    named, around = load_wire(wire), load_bench(bench or PAPER_BENCH)
    if bench is None:
        around = changed_group(around, bench_known_with(wire), f"wire file {wire}")
    return with_numbers(named, around, names, number, where)


def parameters_of(
    configuration: RigConfiguration,
    where: str,
    *,
    wire: str | None = None,
    bench: str | None = None,
    settings: Mapping[str, float | str] | None = None,
) -> tuple[Alloy, Wire, Bench]:
    """Return alloy, wire and bench of a rig file, changed as ``open_rig`` says. Raises CallerError for wrong ones."""
    name, changed = wire or configuration.wire, settings or {}
    names = dict.fromkeys([*configuration.numbers_set(), *changed])

    def given(name: str) -> float | str:
        return changed[name] if name in changed else configuration.number(name)

    stated = configuration.bench if "bench" in configuration.model_fields_set else None
    chosen, around = wire_on_bench(name, bench or stated, names, given, where)
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

    ``given`` are the names of the numbers that are set and not the wire's own. Raises CallerError for a number that is
    set and that no wire of the catalogue has or survives, unless the file confirms it.
    """
    alloy, wire, bench = parameters
    if not configuration.beyond_catalogue:
        refuse_beyond(wire, bench, given, configuration.limits.changed(), where)
    second = second_wire_of(configuration.load)
    in_series, in_parallel = (1, 1) if second is None else second.on_the_drive
    hot = hot_wire(
        wire,
        alloy,
        wire_length_m=bench["wire_length_m"],
        series_ohm=bench["shunt_resistance_ohm"] + bench["lead_resistance_ohm"],
        ambient_temperature_k=bench["ambient_temperature_k"],
        in_series=in_series,
        in_parallel=in_parallel,
    )
    return with_own_voltages(wire, hot, own, given, bench["acquisition_range_v"])


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


def device_of(
    configuration: RigConfiguration,
    where: str,
    spool: SimulatedSpool,
    *,
    seed: int,
    real_time: bool,
    settings: Mapping[str, float | str],
) -> SimulatedDevice:
    """Return the simulated device of a rig file with the numbers of a spool: the core's, or that of an offered key.

    The spool has the ``settings`` already; they are only checked. Raises CallerError for one that the rig's load leaves
    without effect, and for what the device of an offered key refuses.
    """
    from musclewire.rigs._simulated import SimulatedDevice

    given = {*configuration.numbers_set(), *settings}
    if configuration.load and "spring_stiffness_n_per_m" in given:
        raise CallerError(
            f"{where}: the setting 'spring_stiffness_n_per_m' belongs to the bench's spring, and [[load]] replaces it: "
            "give a part 'spring' with a stiffness"
        )
    opened: Callable[..., SimulatedDevice] = SimulatedDevice
    for name, key in configuration.offered_keys().items():
        opened = partial(loaded(key.device), getattr(configuration, name))
    device = opened(
        spool,
        parts=configuration.load,
        surroundings=configuration.surroundings,
        seed=seed,
        real_time=real_time,
        limits=configuration.limits.changed(),
        stated=configuration.stated(),
    )
    if "pretension_n" in given and not device.has_stage:
        raise CallerError(
            f"{where}: the setting 'pretension_n' needs a stage, and this rig has none: the part 'weight' is the "
            "pretension"
        )
    return device


def open_simulated(
    configuration: RigConfiguration,
    where: str = "rig",
    *,
    wire: str | None = None,
    bench: str | None = None,
    seed: int | None = None,
    real_time: bool = False,
    settings: Mapping[str, float | str] | None = None,
) -> SimulatedDevice:
    """Return the open simulated rig of a rig file, changed as ``open_rig`` says."""
    drawn_from = require_seed(configuration.seed if seed is None else seed, f"{where}: seed")
    # The simulator is loaded when a rig is opened: to check a file, or to open hardware, nobody waits for it.
    from musclewire.rigs._simulated import SimulatedSpool

    alloy, chosen, around = parameters_of(configuration, where, wire=wire, bench=bench, settings=settings)
    spool = SimulatedSpool(chosen, alloy, around, configuration.new_wire)
    return device_of(configuration, where, spool, seed=drawn_from, real_time=real_time, settings=settings or {})


SIMULATED_KIND = DeviceKind(RigConfiguration, open_simulated)


def open_rig(
    rig: str | Path | DeviceConfiguration = "simulated",
    *,
    wire: str | None = None,
    bench: str | None = None,
    seed: int | None = None,
    real_time: bool = False,
    clock_speed: float = 1.0,
    beyond_catalogue: bool = False,
    wire_temperature_k: float | None = None,
    **settings: float | str,
) -> GuardedRig:
    """Open a rig: the wire with its driver and instruments, simulated or real, with the protection around it.

    Use it in a ``with`` block, at whose end the drive is switched off whatever happens inside.

    Parameters
    ----------
    rig
        ``"simulated"`` for the paper's bench, the name of another rig that ships with musclewire (``"finger"``,
        ``"gripper"``), the path of a TOML rig file, or a configuration. A rig file of another kind (``kind = "nidaq"``,
        "serial", "replay", or one that a package has added) opens hardware or a recording. A rig file of kind
        "python:module:Class" runs a class of your own module, which is imported here: open none that you do not trust.
    wire
        Name or wire file (as ``musclewire calibrate`` writes it) of another wire than the simulated rig's own.
    bench
        Name of another bench than the simulated rig's own.
    seed
        Seed of the noise of a simulated rig, or of another kind whose files have the key ``seed``; by default that of
        its file, 1 if it names none.
    real_time
        Whether the computer's clock paces a simulated rig, which otherwise runs as fast as it can. Hardware has a clock
        of its own, and a replay none.
    clock_speed
        How many times as fast as the computer's clock a simulated rig runs with ``real_time``, 0.01 to 1000;
        :func:`musclewire.rigs._abilities.adjustable_clock_of` gives what changes it later.
    beyond_catalogue
        Whether numbers that no wire of the catalogue has or survives, as a length of 60 m or a limit of 5000 K, are
        meant so, as by the rig file's key of that name.
    wire_temperature_k
        How warm the wire of a real rig is [K] if that is not remembered: at the first opening, after a while, after
        another start of the machine. Without it such a wire rests before it is heated.
    **settings
        Numbers of wire and bench by name, in SI or as text with a unit: ``open_rig("simulated", pretension_n=1.7)``.

    Returns
    -------
    The rig, with 0 V at its output.

    Raises
    ------
    CallerError
        For unknown names, impossible numbers and those that no wire of the catalogue has or survives, for settings that
        the rig's own load leaves without effect, a clock speed without a clock, and for wire, bench, seed, clock
        speed and settings of a rig that is not simulated: its numbers are in its file.
    RigError
        If hardware cannot be opened.

    Examples
    --------
    >>> import musclewire as mw
    >>> with mw.open_rig("simulated", pretension_n="1.7 N") as rig:
    ...     rig.metadata()["pretension_n"]
    1.7
    """
    with beyond(beyond_catalogue):
        configuration, where = rig_configuration(rig, may_import=True)
    if wire_temperature_k is not None and not COLDEST_K <= wire_temperature_k <= MELTING_K:
        raise CallerError(f"wire_temperature_k is {wire_temperature_k:g} K: give kelvins, 295.15 for 22 C")
    refuse_useless_speed(clock_speed, real_time, isinstance(configuration, RigConfiguration), where)
    if isinstance(configuration, RigConfiguration):
        simulated = open_simulated(
            configuration, where, wire=wire, bench=bench, seed=seed, real_time=real_time, settings=settings
        )
        if simulated.adjustable_clock is not None:
            simulated.adjustable_clock.set_speed(clock_speed)
        return GuardedRig(simulated, wire_temperature_k=wire_temperature_k)
    if seed is not None and "seed" in type(configuration).model_fields:
        drawn_from = require_seed(seed, f"{where}: seed")
        configuration, seed = configuration.model_copy(update={"seed": drawn_from}), None
    changed = {"wire": wire, "bench": bench, "seed": seed, **settings}
    for name, value in changed.items():
        if value is not None:
            raise CallerError(f"{where}: '{name}' changes a simulated rig; on a real one, change the rig file")
    known = known_kind(configuration.kind) if is_outside(configuration.kind) else DEVICES.find(configuration.kind)
    known_by = f"rig file {Path(rig).resolve()}" if isinstance(rig, str | Path) else None
    opened = GuardedRig(known.open(configuration), known_by, wire_temperature_k)
    opened.air_is_stated = "loss_factor" in configuration.model_fields_set
    if real_time and not opened.paced:
        opened.close()
        raise CallerError(f"{where} has no clock: leave out " + argument("real_time"))
    return opened


def refuse_useless_speed(clock_speed: float, real_time: bool, simulated: bool, where: str) -> None:
    """Raise CallerError for a clock speed that would have no effect on a rig."""
    if clock_speed == 1.0:
        return
    if not simulated:
        raise CallerError(f"{where} is not simulated, its clock runs as it does: leave out " + argument("clock_speed"))
    if not real_time:
        raise CallerError(
            f"{where} has no clock whose speed could be set, it runs as fast as it can: add "
            + argument("real_time", True)
            + ", or leave out "
            + argument("clock_speed")
        )
