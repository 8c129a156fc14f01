"""The parameter files that come with musclewire, by name."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import Any

from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters.catalogue import catalogue_names, catalogue_wire, load_catalogue, same_size_hint
from musclewire.parameters.schema import Alloy, Bench, Wire
from musclewire.parameters.validation import validated

__all__ = ["load_alloy", "load_bench", "load_wire", "names", "published_text", "read_published"]

FOLDERS = {"wire": "wires", "alloy": "alloys", "bench": "benches"}


def names(kind: str) -> list[str]:
    """Return the names of all wires, alloys or benches that come with musclewire; catalogue wires come last."""
    folder = files("musclewire.parameters") / "data" / FOLDERS[kind]
    found = sorted(item.name.removesuffix(".toml") for item in folder.iterdir() if item.name.endswith(".toml"))
    return found + (catalogue_names() if kind == "wire" else [])


def read_named(kind: str, name: str) -> dict[str, Any]:
    """Return the parsed TOML file of a named wire, alloy or bench."""
    if name not in names(kind):
        hint = same_size_hint(name) if kind == "wire" else ""
        raise CallerError(f"there is no {kind} called '{name}'{hint or nearest_hint(name, names(kind))}")
    text = (files("musclewire.parameters") / "data" / FOLDERS[kind] / f"{name}.toml").read_text("utf-8")
    return tomllib.loads(text)


@cache
def load_alloy(name: str) -> Alloy:
    """Return a named alloy. Raises CallerError for an unknown name."""
    return validated(Alloy, read_named("alloy", name), f"alloy {name}")


@cache
def load_wire(name: str) -> Wire:
    """Return a named wire, of a file or of the catalogue. Raises CallerError for an unknown name."""
    if name in catalogue_names():
        rules = load_catalogue().wire
        return catalogue_wire(name, load_wire(rules.high_temperature_shift_wire), load_wire(rules.reference_wire))
    return validated(Wire, read_named("wire", name), f"wire {name}")


@cache
def load_bench(name: str) -> Bench:
    """Return a named bench: spring, circuit, acquisition. Raises CallerError for an unknown name."""
    return validated(Bench, read_named("bench", name), f"bench {name}")


def published_text(name: str) -> str:
    """Return the text of a file of published results."""
    return (files("musclewire.parameters") / "data" / "published" / name).read_text("utf-8")


@cache
def read_published(name: str) -> dict[str, Any]:
    """Return the published results in ``name``.toml as plain data."""
    return tomllib.loads(published_text(f"{name}.toml"))
