"""The order and the groups in which ``musclewire --help`` lists the commands: as a reader meets them."""

from __future__ import annotations

import typer

__all__ = ["PANELS", "arrange"]

# Title of a group, and its commands in the order in which a reader meets them.
PANELS = {
    "Begin here, on the simulated wire": ("demo", "serve"),
    "The basic loop: record, fit, move": ("characterize", "fit", "tune", "control", "home", "grip"),
    "A wire on a bench": ("flash", "doctor", "pretension", "train", "protection"),
    "Recordings": ("import", "estimate", "calibrate", "recover"),
    "Choose, simulate and design": ("simulate", "catalogue", "linearise", "design"),
    "Studies and the paper": ("sweep", "robustness", "reproduce", "rules", "bench", "cite"),
    "Take it elsewhere": ("export", "schema"),
}


def arrange(app: typer.Typer) -> None:
    """Put every command and group of commands into its panel, in the panels' order; others come last, by themselves."""
    panel_of = {name: title for title, names in PANELS.items() for name in names}
    order = {name: place for place, name in enumerate(panel_of)}
    named = {id(one): one.name or getattr(one.callback, "__name__", "") for one in app.registered_commands}
    for command in app.registered_commands:
        command.rich_help_panel = panel_of.get(named[id(command)])
    app.registered_commands.sort(key=lambda one: order.get(named[id(one)], len(order)))
    for group in app.registered_groups:
        of_group = group.typer_instance.info if group.typer_instance else group
        group.rich_help_panel = panel_of.get(str(of_group.name))
