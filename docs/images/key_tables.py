"""Tables of the keys of TOML files, from the schemas that check these files: their descriptions and docstrings."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from musclewire.parameters import unit_of


def section(title: str, text: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a heading, what is said below it if anything is, and a table."""
    lines = [line(head), "|---" * len(head) + "|", *map(line, rows)]
    table = "\n".join(lines)
    return f"## {title}\n\n{text}{2 * chr(10) if text else ''}{table}\n"


def line(cells: Sequence[str]) -> str:
    """Return a line of a table."""
    return f"| {' | '.join(cells)} |"


def unit_in(field: FieldInfo) -> str:
    """Return the unit of a key, also of one that may be left out."""
    inner = (getattr(kind, "__metadata__", ()) for kind in get_args(field.annotation))
    optional = next((unit for notes in inner for note in notes if (unit := unit_of_note(note))), "")
    return unit_of(field) or optional


def unit_of_note(note: Any) -> str:
    """Return the unit that a validator reads text in, "" for any other note on a type."""
    return str(getattr(getattr(note, "func", None), "unit", ""))


def default_of(field: FieldInfo) -> str:
    """Return a key's default as a rig file would have it."""
    value: Any = field.default
    if field.is_required():
        return "needed"
    if value is None or value is PydanticUndefined or isinstance(value, BaseModel):
        return "none"
    return {True: "true", False: "false"}[value] if isinstance(value, bool) else f"{value}"


def type_in_words(field: FieldInfo) -> str:
    """Return the values allowed at a key without a description: its choices, or a table."""
    choices = [choice for choice in get_args(field.annotation) if isinstance(choice, str)]
    if choices:
        return " or ".join(f'`"{choice}"`' for choice in choices)
    inner = (field.annotation, *get_args(field.annotation))
    if any(isinstance(kind, type) and issubclass(kind, BaseModel) for kind in inner):
        return "a table, as here"
    return field.description or ""


def meanings(model: type[BaseModel]) -> dict[str, str]:
    """Return what the docstrings of a model and what it is made of say of their keys."""
    found: dict[str, str] = {}
    for kind in reversed(model.__mro__):
        text = (kind.__doc__ or "").partition("Attributes:")[2]
        listed = re.findall(r"^\s{8}(\w+): (.*?)(?=^\s{8}\w+: |\Z)", text, re.M | re.S)
        listed += numpydoc_parameters(kind)
        for name, said in listed:
            found[name] = " ".join(said.split()).rstrip(".").replace("``", "`")
    found.pop("kind", None)  # the word itself is shown
    return found


def described(model: type[BaseModel]) -> dict[str, str]:
    """Return what the types of a model's keys say of them."""
    fields = model.model_fields.items()
    return {name: within_a_sentence(field.description).rstrip(".") for name, field in fields if field.description}


def numpydoc_parameters(kind: type) -> list[tuple[str, str]]:
    """Return name and meaning of each of a docstring's ``Parameters``, begun as in the middle of a sentence."""
    text = (kind.__doc__ or "").partition("    Parameters\n    ----------\n")[2].partition("\n\n")[0]
    found = re.findall(r"^ {4}(\w[\w, ]*)\n\s*(.*?)(?=^ {4}\w|\Z)", text, re.M | re.S)
    return [(name, within_a_sentence(said)) for names, said in found for name in names.split(", ")]


def within_a_sentence(said: str) -> str:
    """Return a meaning without units, of which a page has a column, begun as in the middle of a sentence."""
    said = re.sub(r" \[[^\]]+\]", "", said)
    kept = (said[1:2] == " " and said[0] != "A") or said[1:2].isupper()
    return said if kept else said[0].lower() + said[1:]


def first_line(model: type[BaseModel]) -> str:
    """Return the first sentence of a docstring."""
    return (model.__doc__ or "").strip().splitlines()[0].rstrip(".")
