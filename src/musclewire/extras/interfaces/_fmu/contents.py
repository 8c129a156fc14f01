"""What is in an FMU: a model's variables, its C sources, and what it does not contain."""

from __future__ import annotations

import math
import tomllib
import uuid
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.resources import files
from typing import Any, Literal, NamedTuple
from xml.etree import ElementTree

from musclewire.extras.board import library_license, literal

Kind = Literal["real", "integer", "boolean"]
Role = Literal["input", "output", "fixed", "tunable", "constant"]
KINDS: tuple[Kind, ...] = ("real", "integer", "boolean")


@dataclass(frozen=True)
class FmuVariable:
    """One variable of an FMU."""

    name: str
    role: Role  # a parameter is fixed (set before the end of initialization) or tunable (at any time)
    meaning: str
    unit: str = ""
    kind: Kind = "real"
    start: float = 0.0
    minimum: float = -math.inf
    maximum: float = math.inf
    nominal: float = 0.0
    continuous: bool = True
    type_name: str = ""  # of the enumeration that an integer with names is
    names: tuple[tuple[int, str, str], ...] = ()  # of an integer's values
    starts_with: tuple[str, ...] = ()  # inputs and parameters on which an output depends at rest


def rows_of(name: str) -> list[dict[str, Any]]:
    """Return the rows of a file of ``export/fmu/data``; what is a list there is a tuple."""
    text = (files("musclewire.extras.interfaces._fmu") / "data" / f"{name}.toml").read_text(encoding="utf-8")
    return [
        {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}
        for row in tomllib.loads(text)["variable"]
    ]


@dataclass(frozen=True)
class FmuVariables:
    """All variables of an FMU, those of one kind together: a value reference is a variable's place in this order."""

    ordered: tuple[FmuVariable, ...] = field(default=())

    @classmethod
    def in_order(cls, variables: Iterable[FmuVariable]) -> FmuVariables:
        """Return the variables in the order of their value references."""
        given = tuple(variables)
        return cls(tuple(variable for kind in KINDS for variable in given if variable.kind == kind))

    @classmethod
    def from_files(cls, *names: str) -> FmuVariables:
        """Return the variables of files of ``export/fmu/data``, those of a kind together."""
        return cls.in_order(FmuVariable(**row) for name in names for row in rows_of(name))

    def changed(self, changes: Mapping[str, Mapping[str, Any]]) -> FmuVariables:
        """Return the variables with what differs from FMU to FMU filled in: by name, then by attribute."""
        return FmuVariables(tuple(replace(variable, **changes.get(variable.name, {})) for variable in self.ordered))

    def and_also(self, others: Iterable[FmuVariable]) -> FmuVariables:
        """Return these variables and others."""
        return FmuVariables.in_order((*self.ordered, *others))

    def of_kind(self, kind: Kind) -> Sequence[FmuVariable]:
        """Return the variables of one kind, in order."""
        return [variable for variable in self.ordered if variable.kind == kind]

    def first(self, kind: Kind) -> int:
        """Return the value reference of the first variable of a kind."""
        return sum(len(self.of_kind(other)) for other in KINDS[: KINDS.index(kind)])

    def reference(self, name: str) -> int:
        """Return the value reference of a variable."""
        return next(place for place, variable in enumerate(self.ordered) if variable.name == name)

    def named(self, name: str) -> FmuVariable:
        """Return a variable by its name."""
        return self.ordered[self.reference(name)]


START = """/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Written by musclewire {version} (musclewire export fmu): the variables of modelDescription.xml, in its order. */
#ifndef MW_VARIABLES_H
#define MW_VARIABLES_H

#include <float.h>

#define MW_GUID {guid}
"""
LARGEST = "DBL_MAX"


def variables_header(variables: FmuVariables, guid: str) -> str:
    """Return the text of ``mw_variables.h``."""
    from importlib.metadata import version

    lines = [START.format(version=version("musclewire"), guid=c_text(guid))]
    for kind in KINDS:
        lines += kind_lines(variables, kind)
    for variable in variables.ordered:
        if variable.names:
            lines += names_lines(variable)
    return "\n".join([*lines, "#endif", ""])


def kind_lines(variables: FmuVariables, kind: Kind) -> list[str]:
    """Return the places and the table of all variables of one kind."""
    upper, members = kind.upper(), variables.of_kind(kind)
    return [
        f"#define MW_FIRST_{upper} {variables.first(kind)}u",
        f"#define MW_{upper}S {len(members)}u",
        *(f"#define MW_{upper}_{variable.name.upper()} {place}" for place, variable in enumerate(members)),
        table(f"MW_{upper}_TABLE", [row(variable) for variable in members] or ["{0, MW_INPUT, 0, 0, 0}"]),
        "",
    ]


def row(variable: FmuVariable) -> str:
    """Return the initialiser of one variable."""
    numbers = ", ".join(bounded(value) for value in (variable.start, variable.minimum, variable.maximum))
    return f"{{{c_text(variable.name)}, MW_{variable.role.upper()}, {numbers}}}"


def names_lines(variable: FmuVariable) -> list[str]:
    """Return the names of an enumeration's values, by value."""
    named = {number: name for number, name, _ in variable.names}
    texts = [c_text(named.get(number, "reserved")) for number in range(max(named) + 1)]
    return [table(f"MW_{variable.type_name.upper()}_NAMES", texts), ""]


def table(name: str, rows: Iterable[str]) -> str:
    """Return a macro with an initialiser, one row a line."""
    body = ", \\\n".join(f"    {text}" for text in rows)
    return f"#define {name} {{ \\\n{body} \\\n}}"


def bounded(value: float) -> str:
    """Return a number as a C literal; an infinite one as the largest finite number."""
    if math.isinf(value):
        return LARGEST if value > 0.0 else f"-{LARGEST}"
    return literal(value)


def c_text(text: str) -> str:
    """Return a text as a C string literal."""
    plain = text.encode("ascii", "replace").decode().replace("\\", "\\\\").replace('"', '\\"')
    return f'"{plain}"'


class FmuUnit(NamedTuple):
    """A unit by its exponents of SI base units, and units to show it in: name, factor and offset from SI."""

    exponents: dict[str, int]
    shown: tuple[tuple[str, float, float], ...] = ()


UNITS = {
    "V": FmuUnit({"kg": 1, "m": 2, "s": -3, "A": -1}),
    "A": FmuUnit({"A": 1}),
    "ohm": FmuUnit({"kg": 1, "m": 2, "s": -3, "A": -2}),
    "1/ohm": FmuUnit({"kg": -1, "m": -2, "s": 3, "A": 2}),
    "ohm m": FmuUnit({"kg": 1, "m": 3, "s": -3, "A": -2}),
    "K": FmuUnit({"K": 1}, (("degC", 1.0, -273.15),)),
    "1/K": FmuUnit({"K": -1}),
    "K/Pa": FmuUnit({"K": 1, "kg": -1, "m": 1, "s": 2}),
    "Pa/K": FmuUnit({"kg": 1, "m": -1, "s": -2, "K": -1}),
    "Pa": FmuUnit({"kg": 1, "m": -1, "s": -2}, (("MPa", 1e-6, 0.0),)),
    "N": FmuUnit({"kg": 1, "m": 1, "s": -2}),
    "N/m": FmuUnit({"kg": 1, "s": -2}),
    "m": FmuUnit({"m": 1}, (("mm", 1e3, 0.0),)),
    "m2": FmuUnit({"m": 2}),
    "s": FmuUnit({"s": 1}),
    "1/s": FmuUnit({"s": -1}),
    "J": FmuUnit({"kg": 1, "m": 2, "s": -2}),
    "W": FmuUnit({"kg": 1, "m": 2, "s": -3}),
    "J/K": FmuUnit({"kg": 1, "m": 2, "s": -2, "K": -1}),
    "W/(m2 K)": FmuUnit({"kg": 1, "s": -3, "K": -1}),
}
CAUSALITY = {
    "input": ("input", "continuous", None),
    "output": ("output", "continuous", "calculated"),
    "fixed": ("parameter", "fixed", "exact"),
    "tunable": ("parameter", "tunable", "exact"),
    "constant": ("local", "constant", "exact"),
}
TAGS = {"real": "Real", "integer": "Integer", "boolean": "Boolean"}


class ModelDescription(NamedTuple):
    """What the first lines of a model description say, with the step that a tool should take by default [s]."""

    name: str
    title: str
    guid: str
    step_s: float
    sources: Sequence[str]
    log_owners: Sequence[tuple[str, str]]


def description_text(about: ModelDescription, variables: FmuVariables) -> str:
    """Return the text of ``modelDescription.xml``."""
    root = model_element(about)
    add_simulation(root, about)
    add_units(root, variables.ordered)
    add_types(root, variables.ordered)
    categories = ElementTree.SubElement(root, "LogCategories")
    for owner, meaning in about.log_owners:
        ElementTree.SubElement(categories, "Category", {"name": owner, "description": meaning})
    ElementTree.SubElement(root, "DefaultExperiment", {"startTime": "0.0", "stepSize": repr(about.step_s)})
    add_variables(root, variables)
    add_structure(root, variables)
    ElementTree.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'


def model_element(about: ModelDescription) -> ElementTree.Element:
    """Return the root of a model description."""
    from importlib.metadata import version

    return ElementTree.Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0",
            "modelName": about.name,
            "guid": about.guid,
            "description": about.title,
            "version": version("musclewire"),
            "license": "BSD-3-Clause",
            "generationTool": f"musclewire {version('musclewire')}",
            "variableNamingConvention": "flat",
            "numberOfEventIndicators": "0",
        },
    )


def add_simulation(root: ElementTree.Element, about: ModelDescription) -> None:
    """Add what the FMU can do, and its C files."""
    simulation = ElementTree.SubElement(
        root,
        "CoSimulation",
        {
            "modelIdentifier": about.name,
            "canHandleVariableCommunicationStepSize": "true",
            "canNotUseMemoryManagementFunctions": "true",
        },
    )
    files = ElementTree.SubElement(simulation, "SourceFiles")
    for source in about.sources:
        ElementTree.SubElement(files, "File", {"name": source})


def add_units(root: ElementTree.Element, variables: Iterable[FmuVariable]) -> None:
    """Add the units that the variables have."""
    used = sorted({variable.unit for variable in variables if variable.unit})
    if not used:
        return
    definitions = ElementTree.SubElement(root, "UnitDefinitions")
    for name in used:
        unit = UNITS[name]
        element = ElementTree.SubElement(definitions, "Unit", {"name": name})
        ElementTree.SubElement(element, "BaseUnit", {base: str(power) for base, power in unit.exponents.items()})
        for shown, factor, offset in unit.shown:
            ElementTree.SubElement(
                element, "DisplayUnit", {"name": shown, "factor": repr(factor), "offset": repr(offset)}
            )


def add_types(root: ElementTree.Element, variables: Iterable[FmuVariable]) -> None:
    """Add the enumerations."""
    enumerations = [variable for variable in variables if variable.names]
    if not enumerations:
        return
    definitions = ElementTree.SubElement(root, "TypeDefinitions")
    for variable in enumerations:
        named = ElementTree.SubElement(definitions, "SimpleType", {"name": variable.type_name})
        items = ElementTree.SubElement(named, "Enumeration")
        for number, name, meaning in variable.names:
            described = {"description": meaning} if meaning else {}
            ElementTree.SubElement(items, "Item", {"name": name, "value": str(number), **described})


def add_variables(root: ElementTree.Element, variables: FmuVariables) -> None:
    """Add all variables in the order of their value references."""
    listed = ElementTree.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(variables.ordered):
        causality, variability, initial = CAUSALITY[variable.role]
        if variability == "continuous" and not (variable.kind == "real" and variable.continuous):
            variability = "discrete"
        given = {
            "name": variable.name,
            "valueReference": str(reference),
            "description": variable.meaning,
            "causality": causality,
            "variability": variability,
        }
        if initial is not None:
            given["initial"] = initial
        element = ElementTree.SubElement(listed, "ScalarVariable", given)
        tag = "Enumeration" if variable.names else TAGS[variable.kind]
        ElementTree.SubElement(element, tag, numbers_of(variable, started=initial != "calculated"))


def numbers_of(variable: FmuVariable, *, started: bool) -> dict[str, str]:
    """Return unit, bounds and start value as a variable's element has them."""
    found = {}
    if variable.names:
        found["declaredType"] = variable.type_name
    if variable.unit:
        found["unit"] = variable.unit
        if UNITS[variable.unit].shown:
            found["displayUnit"] = UNITS[variable.unit].shown[0][0]
    if variable.kind == "real":
        bounds = {"min": variable.minimum, "max": variable.maximum, "nominal": variable.nominal}
        found |= {name: repr(value) for name, value in bounds.items() if math.isfinite(value) and value != 0.0}
        if variable.minimum == 0.0:
            found["min"] = "0.0"
    if started:
        found["start"] = start_text(variable)
    return found


def start_text(variable: FmuVariable) -> str:
    """Return a start value as the schema of its type requires it."""
    if variable.kind == "real":
        return repr(float(variable.start))
    if variable.kind == "boolean":
        return "true" if variable.start else "false"
    return str(int(variable.start))


def add_structure(root: ElementTree.Element, variables: FmuVariables) -> None:
    """Add the outputs: none depends on an input of its own communication point, at rest only on those named."""
    structure = ElementTree.SubElement(root, "ModelStructure")
    outputs = [variable for variable in variables.ordered if variable.role == "output"]
    for name in ("Outputs", "InitialUnknowns"):
        listed = ElementTree.SubElement(structure, name)
        for variable in outputs:
            known = sorted(variables.reference(one) + 1 for one in variable.starts_with)
            needed = " ".join(map(str, known)) if name == "InitialUnknowns" else ""
            place = str(variables.reference(variable.name) + 1)
            ElementTree.SubElement(listed, "Unknown", {"index": place, "dependencies": needed})


# Exports of the same content have the same GUID, those of other content another.
NAMESPACE = uuid.UUID("6d1e5c1e-6f0b-5b0c-9a53-8f7f2b6a3c10")
LOG_OWNERS = {
    "caller": "what the importing tool or its user must change: a value, an order of calls",
    "numerics": "a step that could not be computed: communicate in shorter steps",
    "protection": "what the controller's protection did, and why",
}


class FmuContents(NamedTuple):
    """A model to export."""

    title: str
    variables: FmuVariables
    sources: Mapping[str, str]  # all its C files but those that every FMU has
    step_s: float  # communication step that tools should take by default
    owners: tuple[str, ...]
    left_out: tuple[str, ...]  # what the rig or model has and the FMU has not


def c_files(folder: str, *, without: tuple[str, ...] = ()) -> dict[str, str]:
    """Return the C files of a folder of ``musclewire.extras.interfaces``, by name."""
    return {
        item.name: item.read_text(encoding="utf-8")
        for item in (files("musclewire.extras.interfaces") / folder).iterdir()
        if item.name.endswith((".c", ".h")) and item.name not in without
    }


def fmu_sources(contents: FmuContents, guid: str) -> dict[str, str]:
    """Return all C files of an FMU by name."""
    models = tuple(name for name in c_files("c_fmu") if name.endswith("_model.c"))
    return {
        **c_files("c_fmu", without=models),
        **contents.sources,
        "mw_variables.h": variables_header(contents.variables, guid),
    }


def fmu_texts(name: str, contents: FmuContents) -> dict[str, str]:
    """Return every text of an FMU by its path in the archive."""
    nameless = fmu_sources(contents, "")
    text_of_all = "\n".join(f"{file}\n{nameless[file]}" for file in sorted(nameless))
    guid = f"{{{uuid.uuid5(NAMESPACE, f'{name}{contents.title}{contents.step_s!r}{text_of_all}')}}}"
    sources = fmu_sources(contents, guid)
    compiled = sorted(file for file in sources if file.endswith(".c"))
    owners = [(owner, LOG_OWNERS[owner]) for owner in contents.owners]
    about = ModelDescription(name, contents.title, guid, contents.step_s, compiled, owners)
    license_text = library_license()
    return {
        "modelDescription.xml": description_text(about, contents.variables),
        **{f"sources/{file}": text for file, text in sorted(sources.items())},
        "documentation/licenses/license.txt": license_text,
    }
