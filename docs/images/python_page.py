"""The page reference/python of the site, from the names that are promised to users, and their docstrings."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import musclewire
from musclewire.manifest import manifests_of_others, own_manifests, parts
from musclewire.registry import Registry

STUB = Path(musclewire.__file__).with_suffix(".pyi")
HEAD = """# Python

For everybody who writes scripts.
`help(mw.control)` shows all of a name: each argument with its unit, what is returned, each error, an example.

Numbers are SI everywhere in Python, and the unit ends the name: `drive_voltage_v`, `period_s`. Strain is a fraction.

After `import musclewire as mw` every name below is there; the package imports nothing until one is used. These names
and `compiled` at the end are promised: a release that changes one says so. What a page names otherwise, as
`join_recordings` of `musclewire.identify`, is musclewire's own and may change in any release.
"""
RESULTS = """## What they return

`help(run)` lists what each holds, by names that end in their units: the metrics of a run, the gaps of a sweep, the
parameters of a calibration.
"""
COMPILED = """## A tick of your own in compiled loops

[Write an estimator or a controller](../how-to/add_your_own.md) shows how it is used.
"""
# The core's names by the room that they are from, in the order in which a script meets them.
HEADINGS = {
    "rigs": "Rigs",
    "experiment": "Experiments",
    "identify": "Models, calibration and gains",
    "signals": "Recordings",
    "files": "Recordings",
    "sensing": "Estimators",
    "controllers": "Controllers",
    "parameters": "Wires, alloys and benches",
    "wire": "Wires without a rig",
    "physics": "Physics",
    "manifest": "A part of your own",
    "errors": "Errors",
    "arrays": "Types",
}
# Names that are neither a class nor a function, and so have no docstring.
OTHERS = {
    "PLOTS": "Plots of a recording by name ([your own](../how-to/add_your_own.md#a-plot)).",
    "SWITCHED_OFF": "The fault of a device that was switched off from outside.",
    "FloatArray": "Annotation of an array of floats.",
    "Length": "Annotation of a field [m] that is also read from text with a unit: `12 mm`.",
    "Stiffness": "Annotation of a field [N/m] that is also read from text with a unit: `2 N/mm`.",
}


def page() -> str:
    """Return the whole page."""
    found = sections()
    names = {name: item for items in found.values() for name, item in items.items()}
    parts_of_page = [HEAD]
    parts_of_page += [f"## {heading}\n\n{table(items, 'mw.')}\n" for heading, items in found.items()]
    parts_of_page += [f"{RESULTS}\n{table(results_of(names), '')}\n", f"{COMPILED}\n{table(decorator(), '')}\n"]
    return "\n".join(parts_of_page)


def sections() -> dict[str, dict[str, Any]]:
    """Return every promised name with its object, by heading: of the core by subject, then of each part outside it."""
    rooms = room_of_each_name()
    found: dict[str, dict[str, Any]] = {heading: {} for heading in HEADINGS.values()}
    for name, room in rooms.items():
        found[HEADINGS[room]][name] = getattr(musclewire, name)
    for manifest in own_manifests():
        if manifest.names:
            what = parts()[manifest.name]["what"]
            heading = f"Of the part `{manifest.name}`: {what}"
            found[heading] = {name: getattr(musclewire, name) for name in sorted(manifest.names)}
    return found


def room_of_each_name() -> dict[str, str]:
    """Return the room that each of the core's names is from, by the package's stub."""
    tree = ast.parse(STUB.read_text("utf-8"))
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom) and node.level]
    return {item.name: str(node.module) for node in imports for item in node.names}


def decorator() -> dict[str, Any]:
    """Return the decorator that compiles."""
    module = importlib.import_module("musclewire.compiled")
    return {"musclewire.compiled.compiled": module.compiled}


def results_of(names: dict[str, Any]) -> dict[str, type]:
    """Return the classes of ours that functions return and that are not among the names, in their order."""
    found: dict[str, type] = {}
    for function in filter(inspect.isfunction, names.values()):
        returned = getattr(sys.modules[function.__module__], str(function.__annotations__["return"]), None)
        ours = inspect.isclass(returned) and returned.__module__.startswith("musclewire.")
        if ours and returned.__name__ not in names:
            found[returned.__name__] = returned
    return found


def table(items: dict[str, Any], before: str) -> str:
    """Return names with their arguments and the first line of their docstrings."""
    rows = [
        f"| `{before}{name}{arguments(item)}` | {OTHERS.get(name) or first_line(item)} |"
        for name, item in items.items()
    ]
    return "\n".join(["| Name | What it is |", "|---|---|", *rows])


def arguments(item: Any) -> str:
    """Return the arguments of a function by name; nothing for a class, whose fields are in its help."""
    if not inspect.isfunction(inspect.unwrap(item)):
        return ""
    words = []
    for name, one in inspect.signature(item).parameters.items():
        stars = {one.VAR_POSITIONAL: "*", one.VAR_KEYWORD: "**"}.get(one.kind, "")
        if one.kind is one.KEYWORD_ONLY and "*" not in words and not any(word.startswith("*") for word in words):
            words.append("*")
        words.append(f"{stars}{name}")
    return f"({', '.join(words)})"


def first_line(item: ModuleType | Any) -> str:
    """Return the summary of a docstring, in Markdown; of a registry our own kinds, not those a test has added."""
    if isinstance(item, Registry):
        others = {name for one in manifests_of_others() for name in getattr(one, item.field)}
        names = ", ".join(f"`{name}`" for name in item.own_names() if name not in others)
        return f"Known by name: {names}; `register` adds one."
    summary = " ".join((inspect.getdoc(item) or "").split("\n\n")[0].split()).replace("``", "`")
    return re.sub(r":\w+:(`[^`]+`)", r"\1", summary)
