"""The command that takes a controller out of Python as a C library, with the limits of its rig: export c."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
from musclewire.controllers import (
    DriveLimits,
    FeedforwardSettings,
    FuzzyPidSettings,
    Gains,
    ProtectionLimits,
)
from musclewire.errors import CallerError, Message, argument, nearest_hint
from musclewire.extras.board._options import ARDUINO_ZIP, CONTROLLER_IN_C, DOUBLE, ESTIMATOR_IN_C
from musclewire.extras.board._serial.device import SerialConfiguration
from musclewire.rigs import Metadata, RigConfiguration, open_rig, rig_configuration
from musclewire.signals import RunFacts

if TYPE_CHECKING:
    from musclewire.sensing import SensingModel

# The estimator that an Uno's flash does not hold.
FILTER = "filter"
FUZZY_PID, INVERSE_MODEL = CONTROLLERS_IN_C = ("fuzzy-pid", "inverse-model")


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

    controller: Annotated[str, CONTROLLER_IN_C] = FUZZY_PID
    settings: Annotated[Path | None, SETTINGS] = None
    rules: Annotated[str | None, RULES] = None


def export_c(
    model: Annotated[Path, typer.Argument(help="Model file, as 'musclewire fit' writes it.")],
    output: Annotated[Path, own_help("--output", "Folder for the library, made if need be.")],
    controller: ControllerOptions,
    rig: Annotated[str, RIG] = "simulated",
    double: Annotated[bool, DOUBLE] = False,
    estimator: Annotated[str, ESTIMATOR_IN_C] = "polynomial",
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
        Gains.read(loaded.gains, f"model file {model}: gains")  # not used here; but what is wrong is said
    limits, known = limits_of_rig(rig)
    check_made_for(loaded, known, f"rig {rig}", "name the rig with your wire by --rig, or fit one")
    chosen = settings_of(controller, loaded, model, known)
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
    if controller.controller == INVERSE_MODEL:
        return Result(answer, text if estimator == FILTER else text + WITHOUT_FILTER)
    return Result(answer, text + BY_FUZZY_PID if loaded.gains else text)


BY_FUZZY_PID = Message(
    "\nthe paper's fuzzy PID drives the wire, and needs some 12 s from cold: this model has gains, and ",
    argument("controller", INVERSE_MODEL),
    " takes them",
)
WITHOUT_FILTER = Message(
    "\nthis estimator does not know what holds the wire, so the controller keeps a heat balance itself: ",
    argument("estimator", FILTER),
    " knows it",
)


def settings_of(
    options: ControllerOptions, loaded: SensingModel, file: Path, known: Metadata
) -> FuzzyPidSettings | FeedforwardSettings:
    """Return the settings of the controller that is asked for, by the gains of the model if it takes them.

    Raises CallerError for a controller without a form in C, and for a model without its gains.
    """
    from musclewire.identify import gains_of, settings_for

    asked = options.controller
    if asked not in CONTROLLERS_IN_C:
        raise CallerError(f"controller '{asked}' has no form in C{nearest_hint(asked, CONTROLLERS_IN_C)}")
    if asked == FUZZY_PID:
        return settings_for(loaded, read_settings(options.settings, options.rules))
    if options.settings is not None or options.rules is not None:
        raise CallerError(f"{INVERSE_MODEL} takes the model's gains: leave out settings and rules of the fuzzy PID")
    gains = gains_of(loaded, RunFacts(known, "this rig").number_or_none("sample_period_s") or 0.0)
    if gains is None or not isinstance(gains.settings, FeedforwardSettings):
        why = f" ({loaded.no_gains})" if loaded.no_gains else ""
        raise CallerError(
            f"{INVERSE_MODEL} needs the gains of its wire, and {file} has none{why}: find them in the wire's slow loop "
            f"by 'musclewire tune {file} LOOP -o {file}'"
        )
    return gains.settings


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
    """Return limits and facts of a rig without driving anything: a simulated one, or a board's rig file.

    Raises CallerError for a rig of another kind.
    """
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
