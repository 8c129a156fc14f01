"""The command that takes a controller out of Python: export c."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app.commands import add_command
from musclewire.app.options import DOUBLE, NAME, OUTPUT, OVERWRITE, RIG, RULES, SETTINGS, Json
from musclewire.app.output import emit_json, show
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.controllers import FuzzyPidSettings

__all__ = ["add_export_commands"]


def add_export_commands(app: typer.Typer) -> None:
    """Add the group and its command."""
    export = typer.Typer(name="export", no_args_is_help=True, help="Export a model with its controller: c.")

    # A group with a single command would lose its name without this.
    @export.callback()
    def _group() -> None:
        pass

    add_command(export, export_c, "c")
    app.add_typer(export)


@dataclass(frozen=True)
class ControllerOptions:
    """Settings of the controller that differ from its defaults."""

    settings: Annotated[Path | None, SETTINGS] = None
    rules: Annotated[str | None, RULES] = None


def export_c(
    model: Annotated[Path, typer.Argument(help="Model file, as 'musclewire fit' writes it.")],
    output: Annotated[Path, OUTPUT],
    controller: ControllerOptions,
    rig: Annotated[str, RIG] = "simulated",
    double: Annotated[bool, DOUBLE] = False,
    name: Annotated[str, NAME] = "musclewire_wire",
    overwrite: Annotated[bool, OVERWRITE] = False,
    json: Json = False,
) -> None:
    """Model, controller, limits and protection as a self-contained C99 library, with its own test vectors."""
    from musclewire.controllers import DriveLimits
    from musclewire.export.c import write_library
    from musclewire.export.rig_limits import limits_of_rig
    from musclewire.identify.use_of_model import check_made_for, settings_for
    from musclewire.sensing import load_model

    loaded = load_model(model)
    limits, known = limits_of_rig(rig)
    check_made_for(loaded, known)
    chosen = settings_for(loaded, read_settings(controller.settings, controller.rules))
    library = write_library(
        loaded,
        chosen,
        DriveLimits(limits.sense_voltage_v, limits.maximum_voltage_v),
        limits,
        output,
        name,
        double=double,
        overwrite=overwrite,
    )
    answer = {
        "folder": str(output),
        "name": name,
        "files": list(library.files),
        "quantity": loaded.quantity,
        "rule_base": chosen.rule_base,
        "precision": "double" if double else "single",
        "limits": finite_numbers(limits._asdict()),
        "single_error_share": library.single_error_share,
        "golden_rows": library.golden_rows,
    }
    if json:
        emit_json(answer)
    else:
        show(export_text(answer, rig))


def read_settings(path: Path | None, rules: str | None) -> FuzzyPidSettings:
    """Return the controller's settings from a TOML file, and the rule base that an option names instead.

    Raises CallerError naming file and key.
    """
    from musclewire.controllers import FuzzyPidSettings
    from musclewire.parameters.toml_file import read_toml

    given: dict[str, Any] = {} if path is None else read_toml(path, "settings file")
    if rules is not None:
        given["rule_base"] = rules
    try:
        return FuzzyPidSettings(**given)
    except CallerError as error:
        raise CallerError(f"settings file {path}: {error}" if path else str(error)) from None


def finite_numbers(numbers: dict[str, float]) -> dict[str, float | None]:
    """Return the numbers with None for "no limit": a JSON document knows no infinity."""
    return {name: value if abs(value) < float("inf") else None for name, value in numbers.items()}


def export_text(answer: dict[str, Any], rig: str) -> str:
    """Return what was written and how it is tested, for people."""
    limits = answer["limits"]
    lines = [
        f"{answer['folder']}: {answer['quantity']} from resistance, rule base {answer['rule_base']}, "
        f"{answer['precision']} precision",
        f"limits of rig {rig}: shunt {limits['shunt_resistance_ohm']:g} ohm, drive {limits['sense_voltage_v']:g} to "
        f"{limits['maximum_voltage_v']:g} V, resistance {limits['resistance_low_ohm']:.3g} to "
        f"{limits['resistance_high_ohm']:.3g} ohm",
        f"single precision moves an estimate by at most {100.0 * answer['single_error_share']:.2g} % of the full scale",
        f"{len(answer['files'])} files, {answer['golden_rows']} golden vectors: "
        f"cmake -S {answer['folder']} -B build && cmake --build build && ctest --test-dir build",
    ]
    return "\n".join(lines)
