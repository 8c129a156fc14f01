"""The parameter files that ship with musclewire, by name, and the user's own wires, by file."""

from __future__ import annotations

import difflib
import tomllib
from functools import cache
from typing import Any

from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters._catalogue import catalogue_names, catalogue_wire, load_catalogue, same_size_hint
from musclewire.parameters._parameter_groups import Alloy, Bench, Parameter, Wire
from musclewire.parameters._validation import DATA, shipped_names, validated
from musclewire.parameters._wire_file import is_wire_file, read_wire_file

FOLDERS = {"wire": "wires", "alloy": "alloys", "bench": "benches"}


def names(kind: str) -> list[str]:
    """Return the names of all wires, alloys or benches that ship with musclewire; catalogue wires come last."""
    return shipped_names(FOLDERS[kind]) + (catalogue_names() if kind == "wire" else [])


def read_named(kind: str, name: str) -> dict[str, Any]:
    """Return the parsed TOML file of a named wire, alloy or bench."""
    if name not in names(kind):
        hint = wire_hint(name) if kind == "wire" else nearest_hint(name, names(kind))
        raise CallerError(f"there is no {kind} called '{name}'{hint}")
    text = (DATA / FOLDERS[kind] / f"{name}.toml").read_text("utf-8")
    return tomllib.loads(text)


def wire_hint(name: str) -> str:
    """Return the end of a message about an unknown wire: the nearest by size, unless it is spelt like one of ours."""
    ours = {one.partition("-")[0] for one in shipped_names(FOLDERS["wire"])}
    like_ours = difflib.get_close_matches(name.partition("-")[0].lower(), ours, n=1)
    return nearest_hint(name, names("wire")) if like_ours else same_size_hint(name) or nearest_hint(name, names("wire"))


def load_alloy(name: str) -> Alloy:
    """Return an alloy.

    Parameters
    ----------
    name
        A named alloy, or a wire file (.toml), whose alloy it is.

    Returns
    -------
    The alloy, checked.

    Raises
    ------
    CallerError
        For an unknown name or a wrong file.
    """
    return read_wire_file(name).alloy if is_wire_file(name) else named_alloy(name)


def load_wire(name: str) -> Wire:
    """Return a wire.

    Parameters
    ----------
    name
        A named wire, one of the catalogue, or a wire file (.toml), which is read at every call.

    Returns
    -------
    The wire, checked.

    Raises
    ------
    CallerError
        For an unknown name or a wrong file.
    """
    return read_wire_file(name).wire if is_wire_file(name) else named_wire(name)


def bench_known_with(wire: str) -> dict[str, Parameter]:
    """Return the bench's numbers in a wire file; none for wires that ship with musclewire."""
    return dict(read_wire_file(wire).bench) if is_wire_file(wire) else {}


@cache
def named_alloy(name: str) -> Alloy:
    """Return an alloy that ships with musclewire."""
    return validated(Alloy, read_named("alloy", name), f"alloy {name}")


@cache
def named_wire(name: str) -> Wire:
    """Return a wire that ships with musclewire, or one of the catalogue."""
    if name in catalogue_names():
        rules = load_catalogue().wire
        return catalogue_wire(name, named_wire(rules.high_temperature_shift_wire), named_wire(rules.reference_wire))
    return validated(Wire, read_named("wire", name), f"wire {name}")


@cache
def load_bench(name: str) -> Bench:
    """Return a named bench: spring, circuit, acquisition.

    Parameters
    ----------
    name
        Its name.

    Returns
    -------
    The bench, checked.

    Raises
    ------
    CallerError
        For an unknown name.
    """
    return validated(Bench, read_named("bench", name), f"bench {name}")


def published_text(name: str) -> str:
    """Return the text of a file of published results."""
    return (DATA / "published" / name).read_text("utf-8")


@cache
def read_published(name: str) -> dict[str, Any]:
    """Return the published results in ``name``.toml as plain data, with units in the names of the keys."""
    return tomllib.loads(published_text(f"{name}.toml"))
