"""The group of commands that size what a wire pulls: design pretensioner, design finger."""

from __future__ import annotations

import typer

from musclewire.app.commands import add_command
from musclewire.app.design.finger_command import finger
from musclewire.app.design.pretensioner_command import pretensioner

__all__ = ["add_design_commands"]


def add_design_commands(app: typer.Typer) -> None:
    """Add the group and its commands."""
    design = typer.Typer(
        name="design", no_args_is_help=True, help="Size the parts that a wire pulls: pretensioner, finger."
    )
    add_command(design, pretensioner)
    add_command(design, finger)
    app.add_typer(design)
