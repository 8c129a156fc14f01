"""From the word ``simulated`` or a TOML file to an open rig."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeVar, overload

from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters.library import bench_known_with, load_alloy, load_bench, load_wire
from musclewire.parameters.schema import Bench, Parameter, ParameterGroup, Wire
from musclewire.parameters.toml_file import read_toml
from musclewire.parameters.validation import validated
from musclewire.parameters.wire_file import is_wire_file
from musclewire.rigs.faults import Fault
from musclewire.rigs.guarded import GuardedRig
from musclewire.rigs.hardware import HardwareConfiguration
from musclewire.rigs.load_parts import Part, Parts
from musclewire.rigs.mounted import LimitsTable
from musclewire.rigs.surroundings import Surroundings
from musclewire.signals.units import parse_quantity

if TYPE_CHECKING:
    from musclewire.rigs.simulated import SimulatedRig

__all__ = [
    "RigConfiguration",
    "open_rig",
    "read_rig_file",
    "rig_names",
    "simulated_configuration",
]

SIMULATED = "simulated"
# Rig files that come with musclewire, each called by its name.
FOLDER = Path(str(files("musclewire.parameters"))) / "data" / "rigs"

# Kinds of rigs that are not simulated, and where their configuration stands: loaded only when a file names them.
HARDWARE_KINDS = {
    "replay": ("musclewire.rigs.replay", "ReplayConfiguration"),
    "nidaq": ("musclewire.rigs.nidaq.configuration", "NiDaqConfiguration"),
    "serial": ("musclewire.rigs.serial.configuration", "SerialConfiguration"),
}

Group = TypeVar("Group", bound=ParameterGroup)


class RigConfiguration(BaseModel):
    """A rig file: a wire, by name or wire file, a bench by name, and ``settings`` that change numbers of both.

    Where no bench is named, the paper's is taken with what the wire file knows of its own. ``load`` lists what the wire
    pulls, without any the bench's spring; ``surroundings`` tells how the air moves, without any not at all.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    kind: Literal["simulated"] = "simulated"
    wire: str = "paper-100um"
    bench: str = "paper"
    new_wire: bool = False
    seed: int = Field(default=1, ge=0)
    settings: dict[str, float | str] = {}
    load: list[Part] = []
    surroundings: Surroundings = Surroundings()
    limits: LimitsTable = LimitsTable()
    fault: list[Fault] = []

    @model_validator(mode="after")
    def _parts_fit_together(self) -> RigConfiguration:
        if "load" in self.model_fields_set and not self.load:
            raise ValueError("load is empty: give a [[load]] part, or leave load out for the bench's spring")
        Parts(load=self.load)
        return self


def read_rig_file(path: str | Path) -> RigConfiguration | HardwareConfiguration:
    """Return a rig file, checked. Raises CallerError naming the file, the key and the nearest right key."""
    file = Path(path)
    data = read_toml(file, "rig file", "; use the word 'simulated' for the simulated rig")
    kind = str(data.get("kind", SIMULATED))
    if kind in HARDWARE_KINDS:
        return validated(hardware_model(kind), data, f"rig file {file}").beside(file.parent)
    if kind != SIMULATED:
        known = [SIMULATED, *HARDWARE_KINDS]
        raise CallerError(f"rig file {file}: there is no kind of rig '{kind}'{nearest_hint(kind, known)}")
    return beside(validated(RigConfiguration, data, f"rig file {file}"), file.parent)


def hardware_model(kind: str) -> type[HardwareConfiguration]:
    """Return the model of a kind's rig file."""
    module, name = HARDWARE_KINDS[kind]
    model: type[HardwareConfiguration] = getattr(import_module(module), name)
    return model


def beside(configuration: RigConfiguration, folder: Path) -> RigConfiguration:
    """Return a rig file's content with the files it names found beside it, wherever the command was started."""

    def found(name: str | None) -> str | None:
        return str(folder / name) if name is not None and is_wire_file(name) else name

    def placed(part: Part) -> Part:
        named = {key: found(getattr(part, key)) for key in ("wire", "finger", "file") if hasattr(part, key)}
        return part.model_copy(update=named)

    return configuration.model_copy(
        update={"wire": found(configuration.wire), "load": [placed(part) for part in configuration.load]}
    )


def rig_names() -> list[str]:
    """Return the names of the rig files that come with musclewire, after the word for the paper's bench."""
    return [SIMULATED, *(item.stem for item in sorted(FOLDER.glob("*.toml")))]


def simulated_configuration(rig: str | Path | RigConfiguration) -> tuple[RigConfiguration, str]:
    """Return what a simulated rig is; ``rig_configuration`` for experiments that change what the wire pulls.

    Raises CallerError for a rig that is not simulated.
    """
    configuration, where = rig_configuration(rig)
    if not isinstance(configuration, RigConfiguration):
        raise CallerError(f"{where} is not simulated: this experiment changes what the wire pulls, on a simulated rig")
    return configuration, where


def rig_configuration(
    rig: str | Path | RigConfiguration | HardwareConfiguration,
) -> tuple[RigConfiguration | HardwareConfiguration, str]:
    """Return what a rig is and how messages call it: from a name, the path of a rig file, or as it is.

    Raises CallerError for a name or file that is not there, and for a wrong file.
    """
    if isinstance(rig, (RigConfiguration, HardwareConfiguration)):
        return rig, "rig"
    if str(rig) == SIMULATED:
        return RigConfiguration(), SIMULATED
    if str(rig) in rig_names():
        return read_rig_file(FOLDER / f"{rig}.toml"), f"rig {rig}"
    if Path(rig).suffix != ".toml" and not Path(rig).exists():
        hint = nearest_hint(str(rig), rig_names())
        or_file = " Otherwise give" if hint.endswith("?") else ", or give"
        raise CallerError(f"there is no rig '{rig}'{hint}{or_file} the path of a TOML rig file")
    return read_rig_file(rig), f"rig file {rig}"


def with_settings(wire: Wire, bench: Bench, settings: Mapping[str, float | str], where: str) -> tuple[Wire, Bench]:
    """Return wire and bench with some numbers set by the user, in SI or as text with a unit ("1.7 N").

    Raises CallerError for a name that neither has, suggesting the nearest.
    """
    known = {**dict(bench.items()), **dict(wire.items())}
    changed: dict[str, Parameter] = {}
    for key, given in settings.items():
        if key not in known:
            raise CallerError(f"{where}: unknown setting '{key}'{nearest_hint(key, known)}")
        value = parse_quantity(given, known[key].unit) if isinstance(given, str) else float(given)
        changed[key] = known[key].model_copy(
            update={"value": value, "kind": "assumed", "source": where, "note": "set by the user"}
        )
    return changed_group(wire, changed, where), changed_group(bench, changed, where)


def changed_group(group: Group, changed: Mapping[str, Parameter], where: str) -> Group:
    """Return a group with those of the changed parameters that it has, checked like a file."""
    own = {key: item.model_dump() for key, item in changed.items() if key in type(group).model_fields}
    return validated(type(group), {**group.model_dump(), **own}, where) if own else group


@overload
def open_rig(
    rig: RigConfiguration | Literal["simulated", "finger", "gripper"] = ...,
    *,
    wire: str | None = ...,
    bench: str | None = ...,
    seed: int | None = ...,
    real_time: bool = ...,
    **settings: float | str,
) -> SimulatedRig: ...
@overload
def open_rig(
    rig: str | Path | RigConfiguration | HardwareConfiguration,
    *,
    wire: str | None = ...,
    bench: str | None = ...,
    seed: int | None = ...,
    real_time: bool = ...,
    **settings: float | str,
) -> GuardedRig: ...
def open_rig(
    rig: str | Path | RigConfiguration | HardwareConfiguration = "simulated",
    *,
    wire: str | None = None,
    bench: str | None = None,
    seed: int | None = None,
    real_time: bool = False,
    **settings: float | str,
) -> GuardedRig:
    """Open a rig: ``"simulated"`` for the paper's bench, another name, or the path of a TOML rig file.

    ``wire`` and ``bench`` name others than the rig's; ``wire`` may be a wire file, as ``musclewire calibrate`` writes
    it. ``real_time`` paces a simulated rig by the computer's clock; hardware has a clock of its own, and a replay none.
    ``settings`` change numbers of both by name, in SI or as text with a unit, as in ``open_rig("simulated",
    pretension_n=1.7)``. A rig file of real hardware opens that; its numbers stand in its file, so wire, bench, seed and
    settings are refused for it. Raises CallerError for unknown names, impossible numbers, and settings that the rig's
    own load leaves without effect; RigError where hardware cannot be opened.
    """
    configuration, where = rig_configuration(rig)
    if isinstance(configuration, RigConfiguration):
        return open_simulated(configuration, where, wire, bench, seed, real_time, settings)
    changed = {"wire": wire, "bench": bench, "seed": seed, **settings}
    for name, value in changed.items():
        if value is not None:
            raise CallerError(f"{where}: '{name}' changes a simulated rig; on a real one, change the rig file")
    opened = configuration.open()
    if real_time and not opened.paced:
        opened.close()
        raise CallerError(f"{where} has no clock: leave --real-time (real_time) away")
    return opened


def open_simulated(
    configuration: RigConfiguration,
    where: str,
    wire: str | None,
    bench: str | None,
    seed: int | None,
    real_time: bool,
    settings: Mapping[str, float | str],
) -> SimulatedRig:
    """Return the open simulated rig of a rig file, changed as ``open_rig`` says."""
    from musclewire.rigs.simulated import SimulatedRig

    name = wire or configuration.wire
    named = load_wire(name)
    around = load_bench(bench or configuration.bench)
    if bench is None and "bench" not in configuration.model_fields_set:
        around = changed_group(around, bench_known_with(name), f"wire file {name}")
    given = {**configuration.settings, **settings}
    chosen, around = with_settings(named, around, given, where)
    if configuration.load and "spring_stiffness_n_per_m" in given:
        raise CallerError(
            f"{where}: the setting 'spring_stiffness_n_per_m' is of the bench's spring, and [[load]] takes its place: "
            "give a part 'spring' with a stiffness"
        )
    opened = SimulatedRig(
        load_alloy(chosen.alloy),
        chosen,
        around,
        parts=configuration.load,
        surroundings=configuration.surroundings,
        seed=configuration.seed if seed is None else seed,
        new_wire=configuration.new_wire,
        real_time=real_time,
        limits=configuration.limits.changed(),
        faults=configuration.fault,
    )
    if "pretension_n" in given and not opened.has_stage:
        raise CallerError(
            f"{where}: the setting 'pretension_n' has no stage to set: the part 'weight' is the pretension"
        )
    return opened
