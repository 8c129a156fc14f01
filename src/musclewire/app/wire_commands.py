"""Commands about wires one can buy: simulate a drive, and the catalogue beside the simulation."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from musclewire.app.files import require_figure_file, require_recording_file, save_figure
from musclewire.app.options import Force, Json, quantity_option
from musclewire.app.output import emit_json, progress_bar, say, show
from musclewire.app.stopping import stops_between_samples
from musclewire.app.wire_text import answer_json, answer_text, comparison_json, comparison_text, wires_json, wires_text
from musclewire.errors import CallerError

__all__ = ["add_wire_commands"]


def add_wire_commands(app: typer.Typer) -> None:
    """Add the commands of this file."""
    for command in (simulate, catalogue):
        app.command()(command)


def simulate(
    wire: Annotated[str, typer.Option("--wire", help="A wire by name; --list shows all.")] = "flexinol-0.10-ht",
    supply: Annotated[str | None, typer.Option("--supply", help="Supply voltage, as '5 V'.")] = None,
    current: Annotated[
        str | None, typer.Option("--current", help="Current that is held, as '200 mA'; --supply then limits.")
    ] = None,
    off_after: Annotated[float, typer.Option("--off-after", help="Seconds until switching off.", min=0.01)] = 1.0,
    duration: Annotated[
        float | None, typer.Option("--duration", help="Seconds in all; long enough to cool without it.", max=86400.0)
    ] = None,
    length: Annotated[str, typer.Option("--length", help="Length of the wire.")] = "140 mm",
    load: Annotated[str | None, typer.Option("--load", help="Weight, or pretension of the spring, as '1.4 N'.")] = None,
    stress: Annotated[
        str | None, typer.Option("--stress", help="The load as a stress; '172 MPa' without either.")
    ] = None,
    spring: Annotated[str | None, typer.Option("--spring", help="A spring to pull, as '588.6 N/m'.")] = None,
    shunt: Annotated[
        str | None, typer.Option("--shunt", help="Shunt, as '0.47 ohm'; a fitting one without it.")
    ] = None,
    ambient: Annotated[str, typer.Option("--ambient", help="Temperature of the still air.")] = "22 degC",
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Recording to write (.h5).")] = None,
    plot: Annotated[Path | None, typer.Option("--plot", help="Figure to write (.svg, .png, .pdf).")] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the instruments' noise.")] = 1,
    list_wires: Annotated[bool, typer.Option("--list", help="Show all wires and end.")] = False,
    table: Annotated[
        bool, typer.Option("--table", help="Current, voltage and shunt for all wires at --length, and end.")
    ] = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """A drive through a wire: what supply, shunt and current does my wire want?"""
    if list_wires:
        emit_json(wires_json()) if json else show(wires_text())
        return
    if table:
        refuse_with_table(
            supply=supply, current=current, load=load, spring=spring, shunt=shunt, output=output, plot=plot
        )
        show_table(length, stress, ambient, json)
        return
    from musclewire.experiment.supply_sizing import SupplyRequest, plan_supply, size_supply

    request = SupplyRequest(
        wire=wire,
        supply_v=quantity_option(supply, "V", "--supply"),
        current_a=quantity_option(current, "A", "--current"),
        on_s=off_after,
        duration_s=duration,
        length_m=quantity_option(length, "m", "--length") or 0.0,
        load_n=quantity_option(load, "N", "--load"),
        stress_pa=quantity_option(stress, "Pa", "--stress"),
        spring_n_per_m=quantity_option(spring, "N/m", "--spring") or 0.0,
        shunt_ohm=quantity_option(shunt, "ohm", "--shunt"),
        ambient_k=quantity_option(ambient, "K", "--ambient") or 0.0,
        seed=seed,
    )
    if output is not None:
        require_recording_file(output, force)
    require_figure_file(plot)
    with stops_between_samples(), progress_bar("Drive", plan_supply(request).duration_s, quiet=json) as on_sample:
        answer = size_supply(request, path=output, overwrite=force, on_sample=on_sample)
    if plot is not None:
        from musclewire.experiment.supply_figure import drive_axes

        save_figure(drive_axes(answer), plot)
    if json:
        emit_json(answer_json(answer, output))
    else:
        show(answer_text(answer))
        for warning in answer.warnings:
            say(f"warning: {warning}")
    if answer.numbers.melted:
        raise typer.Exit(1)


def refuse_with_table(**given: object) -> None:
    """Raise CallerError for options that a table of all wires has no use for."""
    for name, value in given.items():
        if value is not None:
            raise CallerError(f"--{name} belongs to one wire: with --table give --length, --stress and --ambient only")


def show_table(length: str, stress: str | None, ambient: str, json: bool) -> None:
    """Print what every wire of the catalogue wants at a length."""
    from musclewire.app.wire_table_text import table_json, table_text
    from musclewire.identify.catalogue_check import PULL_STRESS_PA
    from musclewire.identify.wire_table import wire_table

    length_m = quantity_option(length, "m", "--length") or 0.0
    stress_pa = PULL_STRESS_PA if stress is None else quantity_option(stress, "Pa", "--stress") or 0.0
    ambient_k = quantity_option(ambient, "K", "--ambient") or 0.0
    if not (length_m > 0.0 and stress_pa > 0.0 and 200.0 < ambient_k < 330.0):
        raise CallerError("--table needs a --length and a --stress above 0 and an --ambient from -73 to 57 degC")
    rows = wire_table(length_m, stress_pa, ambient_k)
    if json:
        emit_json(table_json(rows, length_m, stress_pa, ambient_k))
    else:
        show(table_text(rows, length_m, stress_pa, ambient_k))


def catalogue(json: Json = False) -> None:
    """The Flexinol catalogue beside the simulation: contraction after one second, and cooling times."""
    from musclewire.identify.catalogue_table import compare_catalogue

    compared = compare_catalogue()
    if json:
        emit_json(comparison_json(compared))
    else:
        show(comparison_text(compared))
    if not all(one.ok for one in compared):
        raise typer.Exit(1)
