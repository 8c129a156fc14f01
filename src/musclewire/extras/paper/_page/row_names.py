"""What the rows of the reproduction are called on its page: words of the field, conditions and units in symbols."""

from __future__ import annotations

import functools
import re
import tomllib
from collections.abc import Mapping
from importlib.resources import files
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from musclewire.extras.paper._reproduce import ReproductionRow

NAME = re.compile(r"(?P<subject>\w+)\.(?P<key>\w+)(?:\[(?P<conditions>[^\]]+)\])?")
QUANTITY = re.compile(r"(?P<number>\d+(?:\.\d+)?)(?P<unit>um|N|V|MPa|x|)")
SPOKEN_UNITS = {"um": "µm wire", "x": "× the spring"}


class RowName(NamedTuple):
    """A row's name in words, its unit, and the condition it holds under, "" for none."""

    words: str
    unit: str
    condition: str

    @property
    def heading(self) -> str:
        """Words with the unit in brackets."""
        return f"{self.words} [{self.unit}]" if self.unit else self.words

    @property
    def whole(self) -> str:
        """Words and condition, without the unit."""
        return f"{self.words}: {self.condition}" if self.condition else self.words


@functools.cache
def row_words() -> Mapping[str, Mapping[str, str]]:
    """Return the file of words."""
    return tomllib.loads((files("musclewire.extras.paper._page") / "row_words.toml").read_text("utf-8"))


def row_name(row: ReproductionRow) -> RowName:
    """Return what a row is called; a row without words keeps its key, spoken."""
    found = NAME.fullmatch(row.name)
    if found is None:
        return RowName(row.name, unit_text(row.unit), "")
    words, key, subject = row_words()["words"], found["key"], found["subject"]
    spoken = words.get(f"{subject}.{key}", words.get(key, key.replace("_", " ").capitalize()))
    return RowName(spoken, unit_text(row.unit), condition_text(subject, found["conditions"] or ""))


def unit_text(unit: str) -> str:
    """Return a row's unit in symbols; "" for a plain number."""
    return row_words()["units"].get(unit, unit)


def condition_text(subject: str, conditions: str) -> str:
    """Return the conditions of a row: "125um,1.70N" is "125 µm wire, 1.70 N"; two of one kind are compared."""
    pieces = conditions.split(",") if conditions else []
    spoken = [one_condition(subject, piece) for piece in pieces]
    units = [found["unit"] for piece in pieces if (found := QUANTITY.fullmatch(piece))]
    return (" against " if len(units) == 2 and units[0] == units[1] else ", ").join(spoken)


def one_condition(subject: str, piece: str) -> str:
    """Return one condition: words of its own, or a number with its unit."""
    words = row_words()
    found = QUANTITY.fullmatch(piece)
    if piece in words["conditions"] or found is None:
        return words["conditions"].get(piece, piece)
    unit = found["unit"] or words["target_units"].get(subject, "")
    return f"{found['number']} {SPOKEN_UNITS.get(unit, unit)}".strip()
