"""docs/reference/python.md from the names that the package and its rooms offer, and their docstrings."""

from __future__ import annotations

import importlib
import inspect
import sys
from types import ModuleType
from typing import Any

import musclewire
from musclewire.registry import Registry

HEAD = """# Python

<!-- Written by `python docs/images/draw.py pages` from the docstrings; a test holds this page to them. Do not edit it
by hand. -->

For everybody who writes scripts.
`help(mw.control)` shows all of a name: each argument with its unit, what is returned, each error, an example.

Numbers are SI everywhere in Python, and the unit ends the name: `drive_voltage_v`, `period_s`. Strain is a fraction.

## `import musclewire as mw`

What a script needs. The package imports nothing until a name is used.
"""
RESULTS = """## What they return

`help(run)` lists what each holds: the metrics of a run, the gaps of a sweep, the parameters of a calibration.
"""
# Rooms whose names a script of one's own has use for; those of the others serve musclewire itself.
ROOMS = (
    "sensing",
    "controllers",
    "identify",
    "signals",
    "figures",
    "parameters",
    "errors",
    "registry",
    "interfaces.environments",
    "interfaces.control_systems",
)
# Names that are neither a class nor a function, and so have no docstring.
OTHERS = {
    "EstimatorFactory": "A function that makes an estimator: takes an `EstimatorSetup`, returns an `Estimator`.",
    "ControllerFactory": "A function that makes a controller: takes a `ControllerSetup`, returns a `Controller`.",
    "ENVIRONMENT": "Name of the environments in Gymnasium's registry.",
    "PLOTS": "Plots of a recording by name ([your own](../how-to/plot_what_you_recorded.md#a-plot-of-your-own)).",
    "COLUMNS": "Columns that a recording may have, by name, each with its unit ([files](files.md)).",
}


def page() -> str:
    """Return the whole page."""
    names = {name: getattr(musclewire, name) for name in musclewire.__all__}
    parts = [f"{HEAD}\n{table(names, 'mw.')}\n", f"{RESULTS}\n{table(results_of(names), '')}\n"]
    for room in ROOMS:
        module = importlib.import_module(f"musclewire.{room}")
        own = {name: getattr(module, name) for name in module.__all__ if name not in names}
        parts.append(f"## `musclewire.{room}`\n\n{first_line(module)}\n\n{table(own, '')}\n")
    return "\n".join(parts)


def results_of(names: dict[str, Any]) -> dict[str, type]:
    """Return the classes that functions return and that are not offered by the package itself, in their order."""
    found: dict[str, type] = {}
    for function in filter(inspect.isfunction, names.values()):
        returned = getattr(sys.modules[function.__module__], str(function.__annotations__["return"]), None)
        if inspect.isclass(returned) and returned.__name__ not in names:
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
        return f"Known by name: {', '.join(f'`{name}`' for name in item.own_names())}; `register` adds one."
    return " ".join((inspect.getdoc(item) or "").split("\n\n")[0].split()).replace("``", "`")
