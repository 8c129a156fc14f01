"""The command that takes a wire or its controller to other simulation programs: export fmu."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app import NAME, OVERWRITE, RIG, RULES, SETTINGS, AnswerModel, Result, own_help, read_settings
from musclewire.errors import CallerError
from musclewire.extras.board import CONTROLLER_IN_C, ESTIMATOR_IN_C
from musclewire.extras.interfaces._options import SOURCES_ONLY

if TYPE_CHECKING:
    from musclewire.extras.interfaces._fmu import Fmu


class ExportFmuAnswer(AnswerModel):
    """Of ``export fmu``; without a binary platform and compiler are null."""

    file: str
    kind: str
    fmi_version: str
    platform: str | None
    compiler: str | None
    step_s: float
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    parameters: tuple[str, ...]
    files: tuple[str, ...]
    left_out: tuple[str, ...]


@dataclass(frozen=True)
class ControllerRigOptions:
    """Whose circuit and limits a controller has, which it is, and its settings; of no use to a wire."""

    rig: Annotated[str | None, RIG] = None
    estimator: Annotated[str | None, ESTIMATOR_IN_C] = None
    controller: Annotated[str | None, CONTROLLER_IN_C] = None
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
    output: Annotated[Path, own_help("--output", "Folder for the FMU, made if need be.")],
    controller: ControllerRigOptions,
    name: Annotated[str | None, NAME] = None,
    sources_only: Annotated[bool, SOURCES_ONLY] = False,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Wire or controller as a functional mock-up unit (FMI 2.0, co-simulation) with its C sources and a binary."""
    from musclewire.extras.interfaces._fmu import export_fmu as write_fmu
    from musclewire.extras.interfaces._fmu import is_model

    given = [option for option, value in vars(controller).items() if value is not None]
    if given and not is_model(source):
        raise CallerError(f"--{given[0]} belongs to a controller, and {source} is a rig: leave it out, or give a model")
    fuzzy = controller.settings is not None or controller.rules is not None
    answer = fmu_answer(
        write_fmu(
            source,
            output,
            name=name,
            rig=controller.rig or "simulated",
            estimator=controller.estimator or "filter",
            controller=controller.controller or "inverse-model",
            settings=read_settings(controller.settings, controller.rules) if fuzzy else None,
            sources_only=sources_only,
            overwrite=overwrite,
        )
    )
    return Result(answer, fmu_text(answer))


def fmu_answer(fmu: Fmu) -> ExportFmuAnswer:
    """Return what the command export fmu answers."""
    from musclewire.extras.interfaces._fmu import FMI_VERSION

    return ExportFmuAnswer.read_from(
        fmu,
        file=str(fmu.path),
        fmi_version=FMI_VERSION,
        platform=fmu.platform or None,
        compiler=fmu.compiler or None,
        inputs=fmu.names("input"),
        outputs=fmu.names("output"),
        parameters=fmu.names("fixed"),
    )


def fmu_text(answer: ExportFmuAnswer) -> str:
    """Return what was written, for people."""
    binary = (
        f"binary for {answer.platform} by {answer.compiler}"
        if answer.platform
        else "sources only: the importing tool must compile them"
    )
    return "\n".join(
        [
            f"{answer.file}: {answer.kind}, FMI {answer.fmi_version} co-simulation, {binary}",
            f"inputs: {', '.join(answer.inputs)}",
            f"outputs: {', '.join(answer.outputs)}",
            f"{len(answer.parameters)} parameters; communication step by default {answer.step_s:g} s",
            *(f"not in it: {text}" for text in answer.left_out),
        ]
    )
