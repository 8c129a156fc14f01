"""Parts lists of the circuits in the wiring guide: each part with value, reason, source, price and connections.

Prices are estimates in euros for one piece, as of the month that the list states; none was looked up in a shop. The
pins of the parts are the netlist: drawing, wiring table, schematic and layout of a circuit come from it.
"""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters import validated
from musclewire.small_files import read_toml

Checked = ConfigDict(extra="forbid", frozen=True)


class CircuitPin(BaseModel):
    """One pin of a part: its number, its name where it has one, and the net that it is on."""

    model_config = Checked

    pin: str = Field(min_length=1)
    name: str = ""
    net: str = Field(min_length=1)


class CircuitPart(BaseModel):
    """One part: its label in the drawing, its value, kind and purpose, the source of its numbers, and its pins."""

    model_config = Checked

    label: str = Field(min_length=1)
    value: str = Field(min_length=1)
    what: str = Field(min_length=3)
    why: str = Field(min_length=3)
    price_eur: Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
    source: str = Field(min_length=3)
    board: bool = False
    symbol: str = ""  # in KiCad's libraries, as the footprint; none if the part is not on the circuit board
    footprint: str = ""
    pins: tuple[CircuitPin, ...] = ()


class PartsList(BaseModel):
    """All parts of one circuit, for one wire; ``prices_of`` is the month of the estimates."""

    model_config = Checked

    name: str
    description: str
    wire: str
    prices_of: Annotated[str, Field(pattern=r"^\d{4}-\d{2}$")]
    part: tuple[CircuitPart, ...] = Field(min_length=1)

    @property
    def total_eur(self) -> float:
        """Sum of the estimated prices."""
        return sum(part.price_eur for part in self.part)

    def values(self) -> dict[str, str]:
        """Return the values by the parts' labels."""
        return {part.label: part.value for part in self.part}

    def nets(self) -> dict[str, list[tuple[str, CircuitPin]]]:
        """Return what each net joins: the parts' labels, each with its pin."""
        joined: dict[str, list[tuple[str, CircuitPin]]] = {}
        for part in self.part:
            for pin in part.pins:
                joined.setdefault(pin.net, []).append((part.label, pin))
        return joined

    def pin(self, label: str, number: str) -> CircuitPin:
        """Return a part's pin by its number. Raises CallerError for an unknown one."""
        for part in self.part:
            for pin in part.pins:
                if (part.label, pin.pin) == (label, number):
                    return pin
        raise CallerError(f"the circuit '{self.name}' has no pin {number} at a part '{label}': add it to the list")


def folder_of_parts() -> Path:
    """Return the folder of the lists."""
    return Path(str(files("musclewire.extras.board"))) / "parts_lists"


def parts_names() -> list[str]:
    """Return the names of all lists."""
    return sorted(item.stem for item in folder_of_parts().glob("*.toml"))


@cache
def load_parts(name: str) -> PartsList:
    """Return a list of parts by one of ``parts_names``. Raises CallerError for an unknown name or a wrong file."""
    if name not in parts_names():
        raise CallerError(f"there is no parts list '{name}'{nearest_hint(name, parts_names())}")
    path = folder_of_parts() / f"{name}.toml"
    return validated(PartsList, read_toml(path, "parts list"), f"parts list {path}")
