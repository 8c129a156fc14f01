"""The command that takes a controller out of Python as a C library: export c."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from musclewire.app import (
    ESTIMATOR,
    NAME,
    OUTPUT,
    OVERWRITE,
    RIG,
    RULES,
    SETTINGS,
    Json,
    emit_json,
    read_settings,
    require_zip_file,
    show,
)
from musclewire.extras.board._options import ARDUINO_ZIP, DOUBLE


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
    from musclewire.extras.board._c import write_arduino_zip, write_library
    from musclewire.extras.board._rig_limits import limits_of_rig
    from musclewire.identify import check_made_for, settings_for
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
