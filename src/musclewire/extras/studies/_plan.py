"""A study ready to run: its rig, its kind of run, all its runs, and the fingerprint by which a resumed one is known."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

from musclewire.compiled import kernel_source_hash
from musclewire.errors import CallerError, nearest_hint
from musclewire.extras.studies._design import StudyDesign, design_of
from musclewire.extras.studies._run_kind import RUN_KINDS, KindOptions, Quantity, RunKind
from musclewire.extras.studies._study_file import StudyFile
from musclewire.extras.studies._varied_parameters import GridAxis, SampledParameter, parameter_of
from musclewire.extras.studies._varied_rig import VariedKey, VariedRig, key_unit
from musclewire.parameters import is_wire_file, validated
from musclewire.rigs import RigConfiguration, simulated_configuration

RUN = "run."


@dataclass(frozen=True, eq=False)
class Plan:
    """A study, checked completely, and all its runs."""

    file: StudyFile  # the study's file
    rig: VariedRig  # the rig, with the names of what varies on it
    kind: RunKind[Any]  # the kind of run
    options: KindOptions  # what is run, before any of it varies
    keep: Mapping[str, Quantity]  # the quantities that are kept, by name
    design: StudyDesign  # the values of all runs

    @cached_property
    def fingerprint(self) -> str:
        """A hash of the study, of the files that it names and of the engine: a resumed study has the same."""
        files = {str(path): hashlib.sha256(path.read_bytes()).hexdigest() for path in self._files()}
        content = [self.file.model_dump(mode="json"), self.rig.configuration.model_dump(mode="json", fallback=str)]
        design = hashlib.sha256(self.design.samples.tobytes()).hexdigest()
        document = json.dumps([content, sorted(files.values()), design, engine()], sort_keys=True, default=str)
        return hashlib.sha256(document.encode()).hexdigest()[:32]

    def _files(self) -> list[Path]:
        """Return the files that change the study's result: those of wires, parts and models."""
        tables = [self.rig.configuration, *self.rig.configuration.load, self.options]
        values = [value for table in tables for _, value in table]
        values += [value for axis in self.design.axes for value in axis.values]
        texts = [value for value in values if isinstance(value, str)]
        return sorted({Path(text) for text in texts if text.endswith((".toml", ".json")) and Path(text).is_file()})


def engine() -> str:
    """Return what computes the numbers: the version of musclewire and its compiled code; another one may differ."""
    return f"musclewire {version('musclewire')}, kernels {kernel_source_hash()}"


def plan_of(file: StudyFile, where: str, folder: Path) -> Plan:
    """Return a study ready to run; the files that it names are in ``folder``, and messages begin with ``where``."""
    configuration = rig_of(file, where, folder)
    kind = kind_of(file, where, folder)
    given = {key: value for key, value in file.run.items() if key not in ("kind", "keep")}
    # A key that varies need not be given: its first value takes the place in the checks.
    variable = {name: name.removeprefix(RUN) for name in file.parameters if name.startswith(RUN)}
    for name, key in variable.items():
        if key not in kind.options.model_fields:
            hint = nearest_hint(key, kind.options.model_fields)
            raise CallerError(f"{where}: there is no parameter '{name}'{hint}")
    rig = VariedRig(configuration, where, [name for name in file.parameters if name not in variable])
    keys = dict(rig.keys)
    for name, key in variable.items():
        keys[name] = VariedKey(key_unit(kind.options.model_fields[key]), "", ("run", key))
    require_distinct(keys, where)
    parameters = [with_wire_files_found(item, folder) for item in (
        parameter_of(name, keys[name].unit, table) for name, table in file.parameters.items())]  # fmt: skip
    design = sampled_design(file, parameters, where)
    first = dict(zip(design.names, design.rows(0, 1)[0], strict=True))
    run = {**given, **{key: first[name] for name, key in variable.items()}}
    found = {key: found_in(folder, value) for key, value in run.items()}
    options = validated(kind.options, found, f"{where}: run")
    return Plan(file, rig, kind, options, kept_quantities(file, kind.quantities(options), where), design)


def rig_of(file: StudyFile, where: str, folder: Path) -> RigConfiguration:
    """Return the rig of a study, by name, by a file next to the study's, or by the keys in the study's file."""
    if isinstance(file.rig, dict):
        return validated(RigConfiguration, file.rig, f"{where}: rig").with_files_in(folder)
    given: str | Path = folder / file.rig if file.rig.endswith(".toml") else file.rig
    configuration, _ = simulated_configuration(given)
    return configuration


def kind_of(file: StudyFile, where: str, folder: Path) -> RunKind[Any]:
    """Return the kind of run that a study names, or the one at "module:attribute", next to its file or installed."""
    name = file.run.get("kind")
    if not isinstance(name, str):
        raise CallerError(f"{where}: run.kind is missing; known: {', '.join(RUN_KINDS.names())}")
    try:
        found = kind_at(name, folder) if ":" in name else RUN_KINDS.find(name)
    except CallerError as error:
        raise CallerError(f"{where}: run.kind: {error}") from None
    if not isinstance(found, RunKind):
        raise CallerError(f"{where}: run.kind: '{name}' is a {type(found).__name__}, not a RunKind")
    return found


def kind_at(name: str, folder: Path) -> Any:
    """Return what "module:attribute" names. Raises CallerError if it is not there."""
    module, _, attribute = name.partition(":")
    place = str(folder.resolve())
    if place not in sys.path:  # local workers get the same path
        sys.path.append(place)
    try:
        return getattr(import_module(module), attribute)
    except (ImportError, AttributeError) as problem:
        raise CallerError(f"there is no '{name}' next to the study file or installed ({problem})") from None


def require_distinct(keys: Mapping[str, VariedKey], where: str) -> None:
    """Raise CallerError if two parameters are the same number: ``pretension`` and ``pretension_n``, for example."""
    seen: dict[tuple[str, tuple[str | int, ...]], str] = {}
    for name, key in keys.items():
        same = seen.setdefault((key.group, key.place), name)
        if same != name:
            raise CallerError(f"{where}: parameters.{same} and parameters.{name} are the same number: give one of them")


def with_wire_files_found(item: GridAxis | SampledParameter, folder: Path) -> GridAxis | SampledParameter:
    """Return a parameter with the wire files among its values found next to the study's file."""
    if isinstance(item, SampledParameter) or item.unit:
        return item
    return item._replace(values=tuple(found_in(folder, value) for value in item.values))


def found_in(folder: Path, value: Any) -> Any:
    """Return the name of a file as a path that is valid from anywhere; any other value as it is."""
    is_file = isinstance(value, str) and (is_wire_file(value) or value.endswith(".json"))
    return str((folder / value).resolve()) if is_file else value


def sampled_design(file: StudyFile, parameters: list[GridAxis | SampledParameter], where: str) -> StudyDesign:
    """Return the runs of a study. Raises CallerError if a distribution is not sampled."""
    sampling = file.sampling
    drawn = [item.name for item in parameters if isinstance(item, SampledParameter)]
    if sampling is None:
        if drawn:
            raise CallerError(f"{where}: {drawn[0]} is a distribution: say [sampling] method and samples, or give it "
                              "'points' or 'values'")  # fmt: skip
        return design_of(parameters, "random", 1, file.seed)
    try:
        return design_of(parameters, sampling.method, sampling.samples, file.seed)
    except CallerError as error:
        raise CallerError(f"{where}: {error}") from None


def kept_quantities(file: StudyFile, quantities: Mapping[str, Quantity], where: str) -> dict[str, Quantity]:
    """Return the quantities that a study keeps; by default every one that is a number."""
    given = file.run.get("keep")
    if given is None:
        return {name: item for name, item in quantities.items() if not item.is_series and not item.is_text}
    if not isinstance(given, list) or not given or not all(isinstance(name, str) for name in given):
        raise CallerError(f"{where}: run.keep must be a list of quantities; known: {', '.join(quantities)}")
    for name in given:
        if name not in quantities:
            raise CallerError(f"{where}: run.keep: there is no quantity '{name}'{nearest_hint(name, quantities)}")
    return {name: quantities[name] for name in given}
