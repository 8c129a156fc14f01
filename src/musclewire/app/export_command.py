"""The commands that take a controller or a wire out of Python: export c, export fmu."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app.commands import add_command
from musclewire.app.files import require_zip_file
from musclewire.app.options import (
    ARDUINO_ZIP,
    DOUBLE,
    ESTIMATOR,
    NAME,
    OUTPUT,
    OVERWRITE,
    RIG,
    RULES,
    SETTINGS,
    SOURCES_ONLY,
    Json,
)
from musclewire.app.output import emit_json, show
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.controllers import FuzzyPidSettings
    from musclewire.export.fmu import Fmu

__all__ = ["add_export_commands"]


def add_export_commands(app: typer.Typer) -> None:
    """Add the group and its commands."""
    export = typer.Typer(
        name="export", no_args_is_help=True, help="Export a model with its controller, or a simulated wire: c, fmu."
    )
    add_command(export, export_c, "c")
    add_command(export, export_fmu, "fmu")
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
    estimator: Annotated[str, ESTIMATOR] = "polynomial",
    name: Annotated[str, NAME] = "musclewire_wire",
    arduino_zip: Annotated[Path | None, ARDUINO_ZIP] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
    json: Json = False,
) -> None:
    """Model, controller, limits and protection as a self-contained C99 library, with its own test vectors."""
    from musclewire.controllers import DriveLimits
    from musclewire.export.c import write_arduino_zip, write_library
    from musclewire.export.rig_limits import limits_of_rig
    from musclewire.identify.use_of_model import check_made_for, settings_for
    from musclewire.sensing import load_model

    require_zip_file(arduino_zip)
    loaded = load_model(model)
    limits, known = limits_of_rig(rig)
    check_made_for(loaded, known, f"rig {rig}", "name the rig with your wire by --rig, or fit one")
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
        estimator=estimator,
    )
    answer = {
        "folder": str(output),
        "arduino_zip": None if arduino_zip is None else str(write_arduino_zip(library, arduino_zip)),
        "name": name,
        "files": list(library.files),
        "quantity": loaded.quantity,
        "rule_base": chosen.rule_base,
        "estimator": estimator,
        "precision": "double" if double else "single",
        "limits": finite_numbers(limits._asdict()),
        "single_error_share": library.single_error_share,
        "golden_rows": library.golden_rows,
    }
    if json:
        emit_json(answer)
    else:
        show(export_text(answer, rig))


@dataclass(frozen=True)
class ControllerRigOptions:
    """Whose circuit and limits a controller has, and its settings; of no use to a wire."""

    rig: Annotated[str | None, RIG] = None
    settings: Annotated[Path | None, SETTINGS] = None
    rules: Annotated[str | None, RULES] = None


def export_fmu(
    source: Annotated[
        str,
        typer.Argument(
            metavar="RIG_OR_MODEL",
            help="Simulated rig ('simulated', 'finger', a rig file): its wire on its load. Model file (.json): its "
            "controller.",
        ),
    ],
    output: Annotated[Path, OUTPUT],
    controller: ControllerRigOptions,
    name: Annotated[str | None, NAME] = None,
    sources_only: Annotated[bool, SOURCES_ONLY] = False,
    overwrite: Annotated[bool, OVERWRITE] = False,
    json: Json = False,
) -> None:
    """Wire or controller as a functional mock-up unit (FMI 2.0, co-simulation) with its C sources and a binary."""
    from musclewire.export.fmu import export_fmu as write_fmu
    from musclewire.export.fmu import is_model

    given = [option for option, value in vars(controller).items() if value is not None]
    if given and not is_model(source):
        raise CallerError(f"--{given[0]} belongs to a controller, and {source} is a rig: leave it out, or give a model")
    answer = fmu_answer(
        write_fmu(
            source,
            output,
            name=name,
            rig=controller.rig or "simulated",
            settings=read_settings(controller.settings, controller.rules) if is_model(source) else None,
            sources_only=sources_only,
            overwrite=overwrite,
        )
    )
    if json:
        emit_json(answer)
    else:
        show(fmu_text(answer))


def fmu_answer(fmu: Fmu) -> dict[str, Any]:
    """Return what the command export fmu answers."""
    from musclewire.export.fmu import FMI_VERSION

    return {
        "file": str(fmu.path),
        "kind": fmu.kind,
        "fmi_version": FMI_VERSION,
        "platform": fmu.platform or None,
        "compiler": fmu.compiler or None,
        "step_s": fmu.step_s,
        "inputs": fmu.names("input"),
        "outputs": fmu.names("output"),
        "parameters": fmu.names("fixed"),
        "files": list(fmu.files),
        "left_out": list(fmu.left_out),
    }


def read_settings(path: Path | None, rules: str | None) -> FuzzyPidSettings:
    """Return the controller's settings from a TOML file, and the rule base that an option names instead.

    Raises CallerError naming file and key.
    """
    from musclewire.controllers import FuzzyPidSettings
    from musclewire.parameters.validation import read_toml

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
    if answer["arduino_zip"] is not None:
        lines.append(f"{answer['arduino_zip']}: in the Arduino IDE, Sketch, Include Library, Add .ZIP Library")
    return "\n".join(lines)


def fmu_text(answer: dict[str, Any]) -> str:
    """Return what was written, for people."""
    binary = (
        f"binary for {answer['platform']} by {answer['compiler']}"
        if answer["platform"]
        else "sources only: the importing tool must compile them"
    )
    return "\n".join(
        [
            f"{answer['file']}: {answer['kind']}, FMI {answer['fmi_version']} co-simulation, {binary}",
            f"inputs: {', '.join(answer['inputs'])}",
            f"outputs: {', '.join(answer['outputs'])}",
            f"{len(answer['parameters'])} parameters; communication step by default {answer['step_s']:g} s",
            *(f"not in it: {text}" for text in answer["left_out"]),
        ]
    )
