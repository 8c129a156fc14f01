"""Check that the docstrings of what is promised to users state units, errors and sources.

    python checks/public_docstrings.py [NAME ...]

Judged are the promised names (``dir(musclewire)``), their public methods, and every published equation of
``physics``; with NAME only what begins with it. What numpydoc can say of a docstring it says (``PROMISED`` below, and
``numpydoc lint`` of every file). Asked besides:

- a parameter, or what is returned, has in brackets the unit that its name ends in, as ``[V]``;
- ``Raises`` has every error that the body raises by name;
- a published equation has its source.

A field of a pydantic model is described by its schema, and a method that a base class documents repeats nothing.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
import textwrap
from collections.abc import Callable, Iterator
from functools import cache, cached_property
from typing import Any

from numpydoc.docscrape import NumpyDocString, get_doc_object
from numpydoc.validate import validate

import musclewire
from musclewire import compiled, physics, rigs, sensing

# Of numpydoc's own checks those that only promised names are held to: what is taken and returned is described.
PROMISED = frozenset({"GL08", "PR01", "PR02", "PR03", "PR07", "RT01"})
# Unit suffixes of names and how docstrings spell them, longest first.
UNITS = {
    "w_per_m2_k": "W/(m2 K)", "w_per_m_k": "W/(m K)", "n_per_m": "N/m", "m_per_n": "m/N", "ohm_per_m": "ohm/m",
    "ohm_per_j": "ohm/J", "w_per_v": "W/V", "k_per_j": "K/J", "n_per_j": "N/J", "m_per_j": "m/J", "per_j": "1/J",
    "pa_per_j": "Pa/J", "pa_per_k": "Pa/K", "n_m2": "N m2",
    "j_per_kg_k": "J/(kg K)", "j_per_kg": "J/kg", "j_per_k": "J/K", "w_per_k": "W/K", "kg_per_m3": "kg/m3",
    "ohm_m": "ohm m", "pa_s": "Pa s", "v_per_s": "V/s", "per_k": "1/K", "per_pa": "1/Pa", "per_s": "1/s", "m2": "m2",
    "ohm": "ohm", "pct": "%", "degc": "degC", "kg": "kg", "pa": "Pa", "hz": "Hz", "us": "us", "ns": "ns", "ms": "ms",
    "v": "V", "a": "A", "m": "m", "n": "N", "s": "s", "k": "K", "w": "W", "j": "J",
}  # fmt: skip
# Names that end like a unit and mean something else: the points A of a loop.
NO_UNIT = frozenset({"heating_a", "cooling_a"})
SOURCE = re.compile(r"doi|Eqs?\. |NASA|TOR-|Reuss|Source|References")


def objects() -> Iterator[tuple[str, Any]]:
    """Yield full name and object of what is judged, methods after their class."""
    promised = [getattr(musclewire, name) for name in dir(musclewire)] + [compiled.compiled]
    equations = [getattr(physics, name) for name in dir(physics)]
    for item in map(inspect.unwrap, filter(callable, promised + equations)):
        if inspect.isclass(item) or inspect.isfunction(item):
            yield f"{item.__module__}.{item.__qualname__}", item
            if inspect.isclass(item) and item.__module__.startswith("musclewire"):
                yield from methods_of(item)


def methods_of(owner: type) -> Iterator[tuple[str, Any]]:
    """Yield the public methods and properties that a class writes itself and no base class documents."""
    for name, item in vars(owner).items():
        written = getattr(item, "__func__", getattr(item, "fget", getattr(item, "func", item)))
        inherited = any(hasattr(base, name) for base in owner.__mro__[1:])
        by_hand = inspect.isfunction(written) and written.__name__ != "<lambda>"
        if by_hand and written.__module__ == owner.__module__ and not inherited and not name.startswith("_"):
            yield f"{owner.__module__}.{owner.__qualname__}.{name}", item


def problems_of(name: str, item: Any) -> list[str]:
    """Return what a docstring lacks, in words."""
    if isinstance(item, (property, cached_property)):
        return unit_problem(name, inspect.getdoc(item) or "", "the summary")
    function = inspect.unwrap(getattr(item, "__func__", item))
    text = inspect.getdoc(function) or ""
    described = {one.name: " ".join(one.desc) for one in NumpyDocString(text)["Parameters"]}
    missing = [] if described_elsewhere(function) else validate(get_doc_object(function))["errors"]
    found = [words for code, words in missing if code in PROMISED and not (code == "RT01" and says_return(text))]
    for parameters, words in described.items():
        for parameter in parameters.split(", "):
            found += unit_problem(parameter, words, f"parameter '{parameter}'")
    if inspect.isfunction(function) and function.__annotations__.get("return") not in ("None", "NoReturn"):
        found += unit_problem(name, text.partition("Returns\n")[2] or text, "Returns")
    explained = {one.type for one in NumpyDocString(text)["Raises"]}
    found += [f"does not say when it raises {error}" for error in raised_by(function) if error not in explained]
    is_equation = name.startswith("musclewire.physics") and inspect.isfunction(function)
    return found + (["no source of the equation"] if is_equation and not SOURCE.search(text) else [])


def described_elsewhere(item: Callable[..., Any]) -> bool:
    """Return whether another place describes parameters: a schema, a base class of ours, a protocol's method."""
    if inspect.isclass(item):
        by_base = any(base.__module__.startswith("musclewire") for base in item.__mro__[1:])
        return by_base or hasattr(item, "model_fields") or hasattr(item, "__members__") or is_protocol(item)
    return "." in item.__qualname__ and item.__name__ in of_protocols()


def is_protocol(item: Any) -> bool:
    """Return whether a class is a protocol."""
    return bool(getattr(item, "_is_protocol", False))


@cache
def of_protocols() -> frozenset[str]:
    """Return the names of the methods that protocols of rigs and sensing document for all who implement them."""
    protocols = [item for room in (rigs, sensing) for name in dir(room) if is_protocol(item := getattr(room, name))]
    return frozenset(name for protocol in protocols for name in vars(protocol) if not name.startswith("_"))


def says_return(text: str) -> bool:
    """Return whether the summary of a function without sections says what is returned."""
    return text.startswith("Return ") and "\nParameters\n" not in text


def unit_of(name: str) -> str | None:
    """Return the unit that a name ends in, as docstrings spell it; None for a name without one."""
    name = name.rpartition(".")[2]
    endings = [ending for ending in UNITS if name.endswith(f"_{ending}") and name not in NO_UNIT]
    return UNITS[max(endings, key=len)] if endings else None


def unit_problem(name: str, text: str, place: str) -> list[str]:
    """Return that a text does not state the unit of a name."""
    unit = unit_of(name)
    return [] if unit is None or f"[{unit}]" in text else [f"{place} does not state the unit [{unit}]"]


def raised_by(item: Callable[..., Any]) -> set[str]:
    """Return the names of the error classes in the raise statements of a function."""
    if not inspect.isfunction(item):
        return set()
    raised = [
        node.exc
        for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(item))))
        if isinstance(node, ast.Raise)
    ]
    names = {getattr(error.func if isinstance(error, ast.Call) else error, "id", "") for error in raised}
    return {name for name in names if name.endswith(("Error", "Interrupt", "Stop")) and name[0].isupper()}


def main() -> int:
    """Print what is missing; exit code 1 if anything is."""
    chosen = [(name, item) for name, item in dict(objects()).items() if name.startswith(tuple(sys.argv[1:]) or "")]
    incomplete = [(name, found) for name, item in chosen if (found := problems_of(name, item))]
    for name, found in incomplete:
        print(name, *found, sep="\n    ")
    print(f"{len(chosen) - len(incomplete)} of {len(chosen)} docstrings of promised names and equations are complete")
    return 1 if incomplete else 0


if __name__ == "__main__":
    sys.exit(main())
