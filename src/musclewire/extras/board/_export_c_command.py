"""The command that takes a controller out of Python as a C library, with the limits of its rig: export c."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from musclewire.app import (
    NAME,
    OVERWRITE,
    RIG,
    RULES,
    SETTINGS,
    AnswerModel,
    AnswerRecord,
    Result,
    own_help,
    read_settings,
    require_zip_file,
)
from musclewire.controllers import DriveLimits, FuzzyPidSettings, Gains, ProtectionLimits
from musclewire.errors import CallerError, Message, argument
from musclewire.extras.board._c.loops import FILTER, FUZZY_PID, INVERSE_MODEL, settings_in_c
from musclewire.extras.board._options import ARDUINO_ZIP, CONTROLLER_IN_C, DOUBLE, ESTIMATOR_IN_C
from musclewire.extras.board._serial.device import SerialConfiguration
from musclewire.rigs import Metadata, RigConfiguration, open_rig, rig_configuration
from musclewire.signals import RunFacts


class ExportCAnswer(AnswerModel):
    """Of ``export c``; a limit that there is not is null, and the rule base of a controller without one."""

    folder: str
    arduino_zip: str | None
    name: str
    files: tuple[str, ...]
    quantity: str
    controller: str
    rule_base: str | None
    estimator: str
    precision: str
    limits: Annotated[ProtectionLimits, AnswerRecord(infinite=...)]
    single_error_share: float
    golden_rows: int


@dataclass(frozen=True)
class ControllerOptions:
    """Which controller, and settings of the fuzzy PID that differ from its defaults."""

    controller: Annotated[str, CONTROLLER_IN_C] = INVERSE_MODEL
    settings: Annotated[Path | None, SETTINGS] = None
    rules: Annotated[str | None, RULES] = None

    def fuzzy_settings(self) -> FuzzyPidSettings | None:
        """Return the settings of the fuzzy PID, None if nothing is said of them. Raises CallerError."""
        if self.settings is None and self.rules is None:
            return None
        return read_settings(self.settings, self.rules)


def export_c(
    model: Annotated[Path, typer.Argument(help="Model file, as 'musclewire fit' writes it.")],
    output: Annotated[Path, own_help("--output", "Folder for the library, made if need be.")],
    controller: ControllerOptions,
    rig: Annotated[str, RIG] = "simulated",
    double: Annotated[bool, DOUBLE] = False,
    estimator: Annotated[str, ESTIMATOR_IN_C] = FILTER,
    name: Annotated[str, NAME] = "musclewire_wire",
    arduino_zip: Annotated[Path | None, ARDUINO_ZIP] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Model, controller, limits and protection as a self-contained C99 library, with its own test vectors."""
    from musclewire.extras.board._c import write_arduino_zip, write_library
    from musclewire.identify import check_made_for
    from musclewire.sensing import load_model

    require_zip_file(arduino_zip)
    loaded = load_model(model)
    if loaded.gains:
        Gains.read(loaded.gains, f"model file {model}: gains")  # whoever uses them: what is wrong is said
    limits, known = limits_of_rig(rig)
    check_made_for(loaded, known, f"rig {rig}", "name the rig with your wire by --rig, or fit one")
    chosen = settings_in_c(
        loaded,
        controller.controller,
        controller.fuzzy_settings(),
        sample_period_s=RunFacts(known, "this rig").number_or_none("sample_period_s") or 0.0,
        file=model,
    )
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
    answer = ExportCAnswer.read_from(
        library,
        loaded,
        chosen,
        folder=str(output),
        arduino_zip=None if arduino_zip is None else str(write_arduino_zip(library, arduino_zip)),
        controller=controller.controller,
        rule_base=getattr(chosen, "rule_base", None),
        estimator=estimator,
        precision="double" if double else "single",
        limits=limits,
    )
    text = export_text(answer, rig)
    if loaded.gains and controller.controller == FUZZY_PID:
        text += BY_FUZZY_PID
    elif estimator != FILTER:
        text += WITHOUT_FILTER
    return Result(answer, text)


BY_FUZZY_PID = Message(
    "\nthe paper's fuzzy PID needs some 12 s from cold: ", argument("controller", INVERSE_MODEL), " does not"
)
WITHOUT_FILTER = Message(
    "\nthis estimator does not know what holds the wire, so the controller keeps a heat balance itself: ",
    argument("estimator", FILTER),
    " knows it",
)


def export_text(answer: ExportCAnswer, rig: str) -> str:
    """Return what was written and how it is tested, for people."""
    limits = answer.limits
    by = "" if answer.rule_base is None else f", rule base {answer.rule_base}"
    lines = [
        f"{answer.folder}: {answer.quantity} from resistance, controller {answer.controller}{by}, "
        f"{answer.precision} precision",
        f"limits of rig {rig}: shunt {limits.shunt_resistance_ohm:g} ohm, drive {limits.sense_voltage_v:g} to "
        f"{limits.maximum_voltage_v:g} V, resistance {limits.resistance_low_ohm:.3g} to "
        f"{limits.resistance_high_ohm:.3g} ohm",
        f"single precision moves an estimate by at most {100.0 * answer.single_error_share:.2g} % of the full scale",
        f"{len(answer.files)} files, {answer.golden_rows} golden vectors: "
        f"cmake -S {answer.folder} -B build && cmake --build build && ctest --test-dir build",
    ]
    if answer.estimator == FILTER:
        lines.append("an Arduino Uno has no room for the filter with a sketch: export the polynomial for one")
    if answer.arduino_zip is not None:
        lines.append(f"{answer.arduino_zip}: in the Arduino IDE, Sketch, Include Library, Add .ZIP Library")
    return "\n".join(lines)


def limits_of_rig(rig: str | Path) -> tuple[ProtectionLimits, Metadata]:
    """Return limits and facts of a simulated rig or a board's rig file. Raises CallerError for another kind."""
    configuration, where = rig_configuration(rig)
    if isinstance(configuration, RigConfiguration):
        with open_rig(configuration) as opened:
            return opened.protection_limits, opened.metadata()
    if isinstance(configuration, SerialConfiguration):
        limits = configuration.protection_limits(
            wire_range_v=configuration.wire_range,
            shunt_range_v=configuration.shunt_range,
            readings_noisy=configuration.readings_noisy,
        )
        return limits, configuration.facts()
    raise CallerError(
        f"{where} is no board: an exported controller's limits come from the channels of the board it runs on; write "
        'a rig file with kind = "serial" for it'
    )
