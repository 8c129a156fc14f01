"""Options that several commands share, declared once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from musclewire.errors import CallerError

__all__ = [
    "Columns",
    "Force",
    "Invert",
    "Json",
    "Length",
    "OutputPath",
    "RealTime",
    "RigName",
    "Seed",
    "Shunt",
    "Zero",
    "mapping",
    "quantity_option",
]

EXAMPLES = {
    "--column": "NAME=HEADER or NAME=HEADER:UNIT, as wire_voltage_v='Vw:V'",
    "--set": "NAME=VALUE, as pretension_n='1.9 N'",
}
RigName = Annotated[
    str,
    typer.Argument(
        metavar="RIG",
        help="'simulated', 'finger', 'gripper', or the path of a TOML rig file. To be copied: 'arduino-uno', "
        "'serial-board', 'ni-pci-6229', 'ni-usb-6001'.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout.")]
Seed = Annotated[int | None, typer.Option("--seed", min=0, help="Seed of everything random in a simulated rig.")]
RealTime = Annotated[bool, typer.Option("--real-time", help="Pace a simulated rig by the clock.")]
Force = Annotated[bool, typer.Option("--force", help="Replace an existing recording.")]
Columns = Annotated[
    list[str] | None,
    typer.Option(
        "--column",
        "-c",
        metavar="NAME=HEADER[:UNIT]",
        help="Say which header holds which column. Repeatable.",
    ),
]
Length = Annotated[
    str | None,
    typer.Option("--length", help="Length whose shortening is the strain, as '70 mm': one leg of a V-shaped wire."),
]
Shunt = Annotated[str | None, typer.Option("--shunt", help="Shunt resistance of Eq. 1, as '1.0 ohm'.")]
Zero = Annotated[bool, typer.Option("--zero", help="Count displacement, strain and force from the first row.")]
Invert = Annotated[bool, typer.Option("--invert", help="The sensor reads backwards: negate displacement and strain.")]
OutputPath = Annotated[Path | None, typer.Option("--output", "-o", help="Where to write.")]


def mapping(pairs: list[str] | None, option: str = "--column") -> dict[str, str]:
    """Return repeated NAME=VALUE options as a mapping."""
    found: dict[str, str] = {}
    for pair in pairs or ():
        name, separator, value = pair.partition("=")
        if not (separator and name.strip() and value.strip()):
            raise CallerError(f"{option} {pair}: write {EXAMPLES[option]}")
        found[name.strip()] = value.strip()
    return found


def quantity_option(text: str | None, unit: str, option: str) -> float | None:
    """Return an option such as '70 mm' in SI, None where it was not given.

    Raises CallerError that names the option where the text is no such quantity.
    """
    if text is None:
        return None
    from musclewire.signals.units import parse_quantity

    try:
        return parse_quantity(text, unit)
    except CallerError as error:
        raise CallerError(f"{option}: {error}") from None
