"""Check that the docstring of every public object answers what a caller needs to know, in numpydoc's form.

    python checks/public_docstrings.py [--report-only] [--list] [NAME ...]

Public is what is promised (``dir(musclewire)``: its stub and what the manifests of parts name), the decorator that
compiles, every method of a protocol, every published equation in ``physics``, and what the pages of ``docs/`` name. Of
a public class its own public methods count, too. What is asked of each:

- a summary of one line that ends with a period, known sections in numpydoc's order;
- each parameter under ``Parameters``, in the signature's order, described (of a pydantic model a field's description
  counts); its type is in the annotation and is not repeated; a name with a unit suffix has that unit in brackets, as
  ``[V]``;
- ``Returns`` if something is returned, with the unit that the function's name ends in; without parameters a summary
  that begins with "Return" says it;
- ``Raises`` with every error that the body raises by name, each with its reason;
- the source of a published equation.

A property is complete with its summary, and so is a method that a protocol documents under the same name and
parameters.

What stands on a room's list (``__init__.pyi``) and is not promised is for other rooms. Its docstring may be a summary
alone; as soon as it has sections, they must have everything that is asked of a promised name.

With NAME only what begins with it is judged.
"""

from __future__ import annotations

import argparse
import ast
import enum
import importlib
import inspect
import re
import sys
import textwrap
import typing
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from types import ModuleType
from typing import Any

from numpydoc.docscrape import NumpyDocString, Parameter, get_doc_object
from numpydoc.validate import validate

import musclewire

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ROOT / "src" / "musclewire"
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")))
# Pages of keys and options, in which a bare name is one of these and not a function.
KEY_PAGES = frozenset({"command_line.md", "files.md", "live_api.md", "parameters.md"})

# numpydoc's own checks that we hold; types are in annotations, and summaries in the house's form.
NUMPYDOC_CHECKS = frozenset({"GL03", "GL06", "GL07", "GL08", "SS01", "SS02", "SS03", "SS06"})
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
# What a source of an equation looks like.
SOURCE = re.compile(r"doi|Eqs?\. |NASA|TOR-|Reuss|Source|References")
# Rooms whose every function is a published equation.
EQUATIONS = "musclewire.physics"


@dataclass(frozen=True)
class Public:
    """A public object: its full name, itself as found in its class or module, and why it is public."""

    name: str
    item: Any
    why: str
    for_rooms: bool = False

    @property
    def is_property(self) -> bool:
        """Whether it is read like an attribute."""
        return isinstance(self.item, (property, cached_property))

    @cached_property
    def function(self) -> Callable[..., Any]:
        """The Python function or class itself, out of what wraps it."""
        item = self.item
        if isinstance(item, (staticmethod, classmethod)):
            item = item.__func__
        if isinstance(item, property):
            item = item.fget
        if isinstance(item, cached_property):
            item = item.func
        found: Callable[..., Any] = inspect.unwrap(item)
        return found

    @cached_property
    def doc(self) -> NumpyDocString:
        """The docstring, parsed."""
        return NumpyDocString(inspect.getdoc(self.function) or "")

    @property
    def text(self) -> str:
        """The docstring in one line."""
        return " ".join((inspect.getdoc(self.function) or "").split())

    @cached_property
    def everything(self) -> list[str]:
        """The names of all parameters, of ``*args`` and ``**kwargs`` too."""
        function = self.function
        if inspect.isclass(function) and (issubclass(function, (enum.Enum, BaseException)) or is_protocol(function)):
            return []
        found = list(inspect.signature(function).parameters)
        is_method = inspect.isfunction(function) and found and found[0] in ("self", "cls")
        return found[1:] if is_method else found

    @cached_property
    def parameters(self) -> list[str]:
        """The names of the parameters that must be described."""
        if not self.everything:
            return []
        fields = getattr(self.function, "model_fields", {})  # of a pydantic model, with a description and a unit each
        in_schema = {name for name, field in fields.items() if field.description or names_the_file(field.annotation)}
        given = inspect.signature(self.function).parameters
        starred = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
        named = [name for name in self.everything if not name.startswith("_") and name not in in_schema]
        return [name for name in named if given[name].kind not in starred]


def names_the_file(annotation: Any) -> bool:
    """Return whether a field has one possible value: the format of its file and its version."""
    return typing.get_origin(annotation) is typing.Literal and len(typing.get_args(annotation)) == 1


# --- What is public ---------------------------------------------------------------------------------------------------


def is_protocol(item: Any) -> bool:
    """Return whether a class is a protocol."""
    return bool(getattr(item, "_is_protocol", False))


@cache
def modules() -> tuple[ModuleType, ...]:
    """Return all modules of musclewire that can be imported here."""
    found = []
    for path in sorted(SOURCES.rglob("*.py")):
        parts = path.relative_to(SOURCES.parent).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        if not name.endswith("__main__"):
            found.append(importlib.import_module(name))
    return tuple(found)


@cache
def defined() -> dict[str, list[tuple[str, Any]]]:
    """Return the public classes and functions by their bare name: full name and object."""
    found: dict[str, list[tuple[str, Any]]] = {}
    for module in modules():
        for name, item in vars(module).items():
            real = inspect.unwrap(item) if callable(item) else item
            ours = inspect.isclass(real) or inspect.isfunction(real)
            if ours and real.__module__ == module.__name__ and not name.startswith("_") and real.__name__ == name:
                found.setdefault(name, []).append((f"{module.__name__}.{name}", item))
    return found


def home(item: Any) -> tuple[str, Any] | None:
    """Return full name and object of one of our classes or functions; None for anything else."""
    real = inspect.unwrap(item) if callable(item) else item
    if not (inspect.isclass(real) or inspect.isfunction(real)) or not real.__module__.startswith("musclewire"):
        return None
    return f"{real.__module__}.{real.__qualname__}", item


def promised() -> Iterator[tuple[Any, str]]:
    """Yield what is promised to users."""
    for name in dir(musclewire):
        yield getattr(musclewire, name), "musclewire"
    yield importlib.import_module("musclewire.compiled").compiled, "musclewire.compiled"


def equations() -> Iterator[tuple[Any, str]]:
    """Yield the functions of the modules of ``physics``, whose lists are their ``__all__``."""
    for module in modules():
        if module.__name__.startswith(f"{EQUATIONS}."):
            for name in module.__all__:
                yield getattr(module, name), EQUATIONS


def by_rooms() -> Iterator[tuple[Any, str]]:
    """Yield what rooms and parts offer to other rooms: by their stubs, and by ``__all__`` of a room of one file."""
    for module in modules():
        name = module.__name__.removeprefix("musclewire.")
        file = Path(str(module.__file__))
        if not re.fullmatch(r"(extras\.)?[a-z]\w*", name) or name == "extras":
            continue
        stub = file.with_suffix(".pyi")
        listed = names_in_stub(stub) if stub.is_file() else getattr(module, "__all__", ())
        for one in listed:
            yield getattr(module, one), module.__name__


def names_in_stub(stub: Path) -> list[str]:
    """Return the names that a stub offers."""
    imports = [node for node in ast.parse(stub.read_text("utf-8")).body if isinstance(node, ast.ImportFrom)]
    return [item.asname for node in imports for item in node.names if item.asname]


def by_protocols() -> Iterator[tuple[Any, str]]:
    """Yield every protocol."""
    for places in defined().values():
        for _, item in places:
            if inspect.isclass(item) and is_protocol(item):
                yield item, "a protocol"


def by_pages() -> Iterator[tuple[Any, str]]:
    """Yield what the pages name: `Class`, `Class.method`, `function()`, `room.file:name`, `mw.name`, and imports."""
    for page in PAGES:
        for word in set(words_of(page.read_text("utf-8"))):
            found = None if page.name in KEY_PAGES and not re.search(r"[.()]", word) else resolved(word)
            if found is not None:
                yield found, page.relative_to(ROOT).as_posix()


def words_of(text: str) -> Iterator[str]:
    """Yield the names in a page that may be ours."""
    yield from re.findall(r"`([A-Za-z_][\w.]*(?:\(\))?)[^`\n]*`", text)
    yield from re.findall(r"`([a-z][\w.]*:[A-Za-z_][\w.]*)`", text)
    for block in re.findall(r"```python\n(.*?)```", text, re.S):
        yield from re.findall(r"\b(?:musclewire|mw)\.[\w.]+", block)
        for home_name, names in re.findall(r"from (musclewire[\w.]*) import ([\w, ]+)", block):
            yield from (f"{home_name}.{name.strip()}" for name in names.split(","))


def resolved(word: str) -> Any:
    """Return the object a page means by a name, None if it is not one of ours or could be several."""
    if ":" in word:
        return named_in_module(*word.split(":"))
    called, word = word.endswith("()"), word.removesuffix("()")
    first, *rest = word.split(".")
    if first in ("mw", "musclewire") and rest:
        return attribute(musclewire, rest)
    places = [place for place in defined().get(first, []) if not place[0].startswith("musclewire.app.")]
    plain = re.fullmatch(r"[a-z]+", first) or unit_of(first)
    if len(places) != 1 or (plain and not called and not rest):
        return None
    return attribute(places[0][1], rest)


def named_in_module(module: str, name: str) -> Any:
    """Return the object that ``module:object`` names, the package's name left out; of a field the class that has it."""
    owner, *rest = name.split(".")
    found = attribute(musclewire, [*module.split("."), owner])
    member = attribute(found, rest)
    return member if callable(member) else found


def attribute(item: Any, names: list[str]) -> Any:
    """Return an attribute of an attribute ..., importing modules on the way; None if there is none."""
    for name in names:
        if inspect.ismodule(item) and not hasattr(item, name):
            try:
                importlib.import_module(f"{item.__name__}.{name}")
            except ImportError:
                return None
        item = inspect.getattr_static(item, name, None) if inspect.isclass(item) else getattr(item, name, None)
    return item


def public_objects() -> dict[str, Public]:
    """Return all public objects by full name, methods of public classes included."""
    found: dict[str, Public] = {}
    for source in (promised, equations, by_protocols, by_pages, by_rooms):
        for item, why in source():
            if isinstance(item, (property, cached_property)):
                continue  # its class is named with it, or it is none of ours
            place = home(item)
            if place is None or place[0] in found:
                continue
            for_rooms = source is by_rooms
            found[place[0]] = Public(*place, why, for_rooms)
            if inspect.isclass(item):
                for name, one in methods_of(item):
                    found[f"{place[0]}.{name}"] = Public(f"{place[0]}.{name}", one, why, for_rooms)
    return found


def methods_of(owner: type) -> Iterator[tuple[str, Any]]:
    """Yield the public methods and properties that a class defines itself, in written form."""
    for name, item in vars(owner).items():
        is_method = isinstance(item, (property, cached_property, staticmethod, classmethod)) or inspect.isfunction(item)
        is_method = is_method and getattr(item, "__name__", "") != "<lambda>"  # the default of a field
        if is_method and not name.startswith("_"):
            real = Public(name, item, "").function
            if getattr(real, "__module__", "") == owner.__module__:
                yield name, item


# --- What each must say -----------------------------------------------------------------------------------------------


def problems_of(public: Public) -> list[str]:
    """Return what a docstring lacks, in words."""
    if not inspect.getdoc(public.function):
        return ["no docstring"]
    found = [text for code, text in validate(get_doc_object(public.function))["errors"] if code in NUMPYDOC_CHECKS]
    name = public.name.rsplit(".", 1)[1]
    if public.is_property:
        return found + unit_problem(name, public.text, "the summary")
    if is_promised(public) or (public.for_rooms and not has_sections(public.doc)):
        return found
    found += parameter_problems(public)
    if not inspect.isclass(public.function) and returns_something(public.function):
        returned = " ".join(" ".join((one.name, one.type, *one.desc)) for one in public.doc["Returns"])
        if not public.parameters and public.text.startswith("Return "):
            returned = returned or public.text
        found += unit_problem(name, returned, "Returns") if returned else ["no Returns"]
    found += raise_problems(public)
    is_equation = public.name.startswith(EQUATIONS) and not inspect.isclass(public.function)
    if is_equation and not SOURCE.search(public.text):
        found.append("no source of the equation")
    return found


def has_sections(doc: NumpyDocString) -> bool:
    """Return whether a docstring says what its object takes, returns or raises."""
    return any(doc[section] for section in ("Parameters", "Returns", "Raises"))


@cache
def promises() -> dict[tuple[str, tuple[str, ...]], Public]:
    """Return the methods of our protocols by name and parameters."""
    methods = {}
    for item, why in by_protocols():
        for name, method in methods_of(item):
            one = Public(f"{item.__module__}.{item.__qualname__}.{name}", method, why)
            if not one.is_property:
                methods[name, tuple(one.everything)] = one
    return methods


def is_promised(public: Public) -> bool:
    """Return whether a method is one that a protocol documents: an implementation does not repeat it."""
    if public.is_property or inspect.isclass(public.function) or "." not in public.function.__qualname__:
        return False
    promise = promises().get((public.function.__name__, tuple(public.everything)))
    return promise is not None and promise.name != public.name


def parameter_problems(public: Public) -> list[str]:
    """Return what the section Parameters lacks: each parameter of the signature in its order, described, with unit."""
    described = described_in(public.doc)
    inherited = {name for base in bases_of(public.function) for name in described_in(base)}
    found = [
        f"parameter '{name}' is not described" for name in public.parameters if name not in {*described, *inherited}
    ]
    found += [f"there is no parameter '{name}'" for name in described if name.lstrip("*") not in public.everything]
    common = [name for name in described if name in public.parameters]
    by_keyword = hasattr(public.function, "model_fields")
    if not by_keyword and common != [name for name in public.parameters if name in common]:
        found.append("parameters are in another order than in the signature")
    for name, one in described.items():
        if one.type:
            found.append(f"parameter '{name}' repeats a type ('{one.type}'): it is in the annotation")
        text = " ".join(one.desc)
        found += unit_problem(name, text, f"parameter '{name}'") if text else [f"parameter '{name}': no description"]
    return found


def described_in(doc: NumpyDocString) -> dict[str, Parameter]:
    """Return the entries of a docstring's section Parameters, one for each name."""
    return {name.strip(): one for one in doc["Parameters"] for name in one.name.split(",")}


def bases_of(item: Callable[..., Any]) -> Iterator[NumpyDocString]:
    """Yield the docstrings of the classes of ours that a class inherits its fields from, and of its ``__init__``."""
    if inspect.isclass(item):
        yield NumpyDocString(inspect.getdoc(vars(item).get("__init__")) or "")
        for base in item.__mro__[1:]:
            if base.__module__.startswith("musclewire"):
                yield NumpyDocString(inspect.getdoc(base) or "")


def unit_of(name: str) -> str | None:
    """Return the unit that a name ends in, as docstrings spell it; None for a name without one."""
    endings = [ending for ending in UNITS if name.endswith(f"_{ending}") and name not in NO_UNIT]
    return UNITS[max(endings, key=len)] if endings else None


def unit_problem(name: str, text: str, place: str) -> list[str]:
    """Return that a text does not state the unit of a name."""
    unit = unit_of(name)
    return [] if unit is None or f"[{unit}]" in text else [f"{place} does not state the unit [{unit}]"]


def returns_something(function: Callable[..., Any]) -> bool:
    """Return whether a function is annotated to return anything but None."""
    return str(getattr(function, "__annotations__", {}).get("return", "None")) not in ("None", "NoReturn")


def raise_problems(public: Public) -> list[str]:
    """Return which errors a body raises by name that the section Raises does not explain."""
    explained = {one.type: one.desc for one in public.doc["Raises"]}
    found = [f"does not say when it raises {name}" for name in raised_by(public.function) if name not in explained]
    return found + [f"Raises {name}: no reason" for name, why in explained.items() if not why]


def raised_by(item: Callable[..., Any]) -> list[str]:
    """Return the names of the error classes in the raise statements of a function, or of a class's construction."""
    if inspect.isclass(item):
        makers = (vars(item).get(name) for name in ("__init__", "__post_init__"))
        files = {sys.modules[item.__module__].__file__}  # not generated ones, nor typing's for a protocol
        written = [maker for maker in makers if inspect.isfunction(maker) and maker.__code__.co_filename in files]
        return sorted({name for maker in written for name in raised_by(maker)})
    tree = ast.parse(textwrap.dedent(inspect.getsource(item)))
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Raise) and node.exc is not None:
            error = node.exc.func if isinstance(node.exc, ast.Call) else node.exc
            name = getattr(error, "id", "")
            if name.endswith(("Error", "Interrupt", "Stop")) and name[0].isupper():
                found.add(name)
    return sorted(found)


# --- The report -------------------------------------------------------------------------------------------------------


def report(incomplete: dict[str, list[str]], public: dict[str, Public]) -> str:
    """Return what is missing per object, counted by room, and the percentage that is complete."""
    lines = [f"{name} ({public[name].why})\n    " + "\n    ".join(found) for name, found in incomplete.items()]
    rooms = Counter(name.split(".")[1] for name in incomplete)
    if rooms:
        lines.append("incomplete: " + ", ".join(f"{room} {count}" for room, count in rooms.most_common()))
    complete = len(public) - len(incomplete)
    lines.append(f"{complete} of {len(public)} public docstrings are complete, {100 * complete / len(public):.1f} %")
    return "\n".join(lines)


def main() -> int:
    """Print what is missing; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="judge only what begins with it: musclewire.sensing")
    parser.add_argument("--report-only", action="store_true", help="end with exit code 0 whatever is missing")
    parser.add_argument("--list", action="store_true", help="list the public objects instead")
    arguments = parser.parse_args()
    chosen = {name: one for name, one in sorted(public_objects().items())
              if not arguments.names or name.startswith(tuple(arguments.names))}  # fmt: skip
    if arguments.list:
        print("\n".join(f"{name} ({one.why})" for name, one in chosen.items()))
        return 0
    incomplete = {name: found for name, one in chosen.items() if (found := problems_of(one))}
    print(report(incomplete, chosen))
    return 1 if incomplete and not arguments.report_only else 0


if __name__ == "__main__":
    sys.exit(main())
