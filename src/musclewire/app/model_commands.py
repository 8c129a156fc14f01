"""Commands that work on files: import, fit, estimate, rules, cite."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app.files import require_figure_file, require_model_file, save_figure
from musclewire.app.options import (
    Columns,
    Force,
    Invert,
    Json,
    Length,
    OutputPath,
    Shunt,
    Zero,
    mapping,
    quantity_option,
)
from musclewire.app.output import emit_json, show
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.signals.recording import MetadataValue, Recording

__all__ = ["add_model_commands"]

RecordingPath = Annotated[
    str,
    typer.Argument(metavar="RECORDING", help="HDF5, CSV or Parquet file, or 'lan-fan-2010-table-2', the paper's."),
]
PUBLISHED = ("lan-fan-2010-table-2",)


def add_model_commands(app: typer.Typer) -> None:
    """Add the commands of this file."""
    app.command(name="import")(import_recordings)
    for command in (fit, estimate, rules, cite):
        app.command()(command)


def import_recordings(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Foreign recordings.")],
    output: OutputPath = None,
    column: Columns = None,
    length: Length = None,
    shunt: Shunt = None,
    zero: Zero = False,
    invert: Invert = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Read foreign recordings and show what was understood; with -o write one as ours."""
    from musclewire.signals import understand

    understood = [understand(path, mapping(column)) for path in files]
    if output is not None:
        if len(files) != 1:
            raise CallerError(f"-o takes one file, {len(files)} were given: import them one by one")
        if output.exists() and not force:
            raise CallerError(f"{output} exists: give another name or --force")
        read(str(files[0]), column, length, shunt, zero, invert).save(output)
    if json:
        emit_json({"files": [item.as_dict() for item in understood]})
        return
    for item in understood:
        show(str(item))
    if output is not None:
        show(f"written to {output}")


def fit(
    recording: RecordingPath,
    output: OutputPath = None,
    order: Annotated[
        str, typer.Option("--order", help="Order of the polynomials, or 'auto' (cross-validation).")
    ] = "6",
    quantity: Annotated[str, typer.Option("--quantity", help="strain, displacement or force.")] = "strain",
    cycle: Annotated[str, typer.Option("--cycle", help="first, last, largest, or a number from 0.")] = "last",
    plot: Annotated[Path | None, typer.Option("--plot", help="Write the figure (.svg, .png, .pdf).")] = None,
    column: Columns = None,
    length: Length = None,
    shunt: Shunt = None,
    zero: Zero = False,
    invert: Invert = False,
    json: Json = False,
) -> None:
    """Fit the self-sensing model to a slow loop; prints gap, residuals, validity range."""
    from musclewire.identify import fit as run_fit

    require_figure_file(plot)
    if output is not None:
        require_model_file(output)
    model = run_fit(
        read(recording, column, length, shunt, zero, invert),
        order=whole_number_or(order, "auto"),
        quantity=quantity,
        cycle=whole_number_or(cycle),
    )
    if output is not None:
        model.save(output)
    if plot is not None:
        save_figure(model.plot(), plot)
    if json:
        emit_json({**model.report(), "model": None if output is None else str(output)})
        return
    show(model.summary())
    if output is not None:
        show(f"model written to {output}")


def estimate(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model file from 'musclewire fit'.")],
    recording: RecordingPath,
    output: OutputPath = None,
    column: Columns = None,
    length: Length = None,
    shunt: Shunt = None,
    zero: Zero = False,
    invert: Invert = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Estimate strain from a recording's resistance; errors where it has a reference."""
    from musclewire.identify import estimate as run_estimate
    from musclewire.sensing import load_model

    report = run_estimate(load_model(model), read(recording, column, length, shunt, zero, invert))
    if output is not None:
        if output.exists() and not force:
            raise CallerError(f"{output} exists: give another name or --force")
        report.recording.save(output)
    answer = {
        "samples": len(report.recording),
        "valid_share": report.valid_share,
        "rms_pct": report.rms_pct,
        "max_pct": report.max_pct,
    }
    if json:
        emit_json(answer)
        return
    errors = (
        "no reference to compare with"
        if report.rms_pct is None
        else f"error {report.rms_pct:.3f} % rms, {report.max_pct:.3f} % largest, of stroke"
    )
    show(f"{len(report.recording)} samples, {100 * report.valid_share:.1f} % in range and between B and C; {errors}")


def rules(
    name: Annotated[str, typer.Argument(metavar="[RULES]", help="Name of a rule base, or a TOML file.")] = "zhao-1993",
    plot: Annotated[Path | None, typer.Option("--plot", help="Write the surfaces (.svg, .png, .pdf).")] = None,
    json: Json = False,
) -> None:
    """Show a fuzzy rule base, and its surfaces with --plot."""
    from musclewire.controllers import load_rule_base, plot_rule_surfaces, rule_base_names

    require_figure_file(plot)
    rule_base = load_rule_base(name)
    if plot is not None:
        save_figure(plot_rule_surfaces(rule_base)[0], plot)
    if json:
        emit_json({"known": list(rule_base_names()), **rule_base.model_dump(mode="json")})
        return
    show(str(rule_base))
    for table, rows in rule_base.rules.model_dump().items():
        if isinstance(rows, (list, tuple)):
            show(f"\n{table}: rows error NB..PB, columns change of error NB..PB")
            for row in rows:
                show("  " + " ".join(f"{cell!s:>3}" for cell in row))
    show(f"\nknown: {', '.join(rule_base_names())}")


def cite(json: Json = False) -> None:
    """Say what to cite."""
    from importlib.metadata import version

    from musclewire.parameters.library import read_published

    paper = read_published("lan_fan_2010")
    items = [
        f"musclewire {version('musclewire')}, 2026, BSD-3-Clause; see CITATION.cff",
        f"{paper['authors']}, {paper['year']}: {paper['title']} (method: Eqs. 1 to 7)",
        "Z.-Y. Zhao, M. Tomizuka, S. Isaka, 1993: Fuzzy gain scheduling of PID controllers, doi 10.1109/21.260670 "
        "(rule base zhao-1993)",
        "S. W. Churchill, H. H. S. Chu, 1975: Correlating equations for laminar and turbulent free convection from a "
        "horizontal cylinder, doi 10.1016/0017-9310(75)90222-7 (simulated wires)",
    ]
    if json:
        emit_json({"cite": items})
    else:
        show("\n".join(items))


def read(
    recording: str,
    column: list[str] | None,
    length: str | None,
    shunt: str | None,
    zero: bool = False,
    invert: bool = False,
) -> Recording:
    """Return a recording by path, or the paper's own measured wire by name."""
    from importlib.resources import as_file, files

    from musclewire.signals import read_recording

    known: dict[str, MetadataValue] = {
        "leg_length_m": quantity_option(length, "m", "--length"),
        "shunt_resistance_ohm": quantity_option(shunt, "ohm", "--shunt"),
    }
    metadata = {name: value for name, value in known.items() if value is not None}
    if recording in PUBLISHED and not Path(recording).exists():
        with as_file(files("musclewire.parameters") / "data" / "published" / f"{recording}.csv") as path:
            return read_recording(path, mapping(column), metadata)
    return turned(read_recording(recording, mapping(column), metadata), zero, invert)


def turned(recording: Recording, zero: bool, invert: bool) -> Recording:
    """Return a recording whose mechanical columns count from the first row, or the other way round."""
    changed = {
        name: (-recording[name] if invert and name != "force_n" else recording[name])
        for name in ("displacement_m", "reference_strain", "force_n")
        if name in recording
    }
    if zero:
        changed = {name: values - values[0] for name, values in changed.items()}
    return recording.with_columns(changed)


def whole_number_or(text: str, *words: str) -> Any:
    """Return a whole number, or the text itself where it is one of the words (any word where none are given)."""
    try:
        return int(text)
    except ValueError:
        if words and text not in words:
            raise CallerError(f"'{text}' is neither a whole number nor {' or '.join(words)}") from None
        return text
