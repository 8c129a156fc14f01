"""The modelDescription.xml of an FMI 2.0 co-simulation FMU."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple
from xml.etree import ElementTree

from musclewire.extras.interfaces._fmu.variables import FmuVariable, FmuVariables


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


def known_units() -> list[str]:
    """Return the units that variables may have."""
    return list(UNITS)


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
