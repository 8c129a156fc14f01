"""The command that grips without a sensor: grip."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app import (
    CLEARANCE,
    OBJECT_STIFFNESS,
    OVERWRITE,
    SEED,
    FigureOptions,
    Result,
    in_si,
    opened_rig,
    option,
    own_help,
    progress_bar,
    quantity,
    require_folder,
    require_recording_file,
    stop_if_asked,
    stops_between_samples,
    tell,
    warn,
)
from musclewire.errors import CallerError, MusclewireError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from musclewire.extras.grip._answer import GripAnswer
    from musclewire.extras.grip._grip import GripRun
    from musclewire.extras.grip._gripper_training import GripperKnowledge
    from musclewire.rigs import RigConfiguration
    from musclewire.wire import ElasticObject

TARGET = quantity("--target", "N", "Grip force to reach and hold at one endpoint, as '0.3 N'.")
TOLERANCE = quantity(
    "--tolerance", "N", "Exit code 1 if the instrument shows a held force further from the target than this.", low=0.0
)
OF_THE_OBJECT = own_help(
    "--known-stiffness", "Known stiffness of the object, as '50 N/m'; by default the power that contact costs shows it."
)
NO_OBJECT = option("--no-object", help="Simulate the grip without any object.")
LEARNED = option("--learned", help="File of the trained gripper (.json): read, or written after training.")

# The gripper is trained on another day than it grips, with other noise and air.
LEARNING_SEED_STEP = 1000


@dataclass(frozen=True)
class GripOptions:
    """The force to hold, and what is known of the object."""

    target: Annotated[str, TARGET] = "0.3 N"
    known_stiffness: Annotated[str | None, OF_THE_OBJECT] = None
    tolerance: Annotated[str | None, TOLERANCE] = None

    def in_si(self) -> tuple[float, float | None]:
        """Return force and stiffness. Raises CallerError if one of them is not above 0."""
        target_n, known = in_si("--target", self.target), in_si("--known-stiffness", self.known_stiffness)
        if not target_n > 0.0:
            raise CallerError(f"--target is {target_n:g} N and must be above 0")
        if known is not None and not known > 0.0:
            raise CallerError(f"--known-stiffness is {known:g} N/m and must be above 0")
        return target_n, known


@dataclass(frozen=True)
class ObjectOptions:
    """The simulated object between the fingers."""

    object_stiffness: Annotated[str | None, OBJECT_STIFFNESS] = None
    clearance: Annotated[str | None, CLEARANCE] = None
    no_object: Annotated[bool, NO_OBJECT] = False

    def of_rig(self, rig: str) -> ElasticObject | None:
        """Return the object between the fingers of a rig, None without one; CallerError for options that contradict."""
        from musclewire.extras.grip._gripper_training import object_of
        from musclewire.wire import ElasticObject

        stiffness = in_si("--object-stiffness", self.object_stiffness)
        clearance = in_si("--clearance", self.clearance)
        if self.no_object:
            if stiffness is not None or clearance is not None:
                raise CallerError("--no-object leaves nothing to touch: leave out --object-stiffness and --clearance")
            return None
        own = object_of(rig)
        block = ElasticObject(stiffness or own.stiffness_n_per_m, own.clearance_m if clearance is None else clearance)
        if stiffness == 0.0 or block.stiffness_n_per_m <= 0.0 or block.clearance_m < 0.0:
            raise CallerError(
                f"an object of {block.stiffness_n_per_m:g} N/m at {block.clearance_m:g} m: give a stiffness above 0, "
                "a clearance of 0 or more"
            )
        return block


def grip(
    block: ObjectOptions,
    goal: GripOptions,
    figure: FigureOptions,
    rig: Annotated[
        str, typer.Argument(metavar="[RIG]", help="'gripper', or a TOML rig file with a finger and a contact.")
    ] = "gripper",
    learned: Annotated[Path | None, LEARNED] = None,
    output: Annotated[Path | None, own_help("--output", "Recording to write (.h5).")] = None,
    seed: Annotated[int | None, SEED] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Close fingers on an object, find contact and hold a force, all by the wires' resistance."""
    from musclewire.experiment import run_warnings
    from musclewire.extras.grip._grip import HOLD_S
    from musclewire.extras.grip._grip import grip as run_grip
    from musclewire.extras.grip._gripper_training import CLOSING_S, REST_S, with_object

    figure.check()
    if output is not None:
        require_recording_file(output, overwrite)
    target_n, known = goal.in_si()
    simulated = block.of_rig(rig)
    configuration = with_object(rig, simulated)
    with stops_between_samples():
        knowledge = knowledge_of(configuration, learned, seed)
        with (
            opened_rig(configuration, seed=seed) as opened,
            progress_bar("Grip", REST_S + CLOSING_S + HOLD_S, opened) as on_sample,
        ):
            run = run_grip(
                opened, knowledge, target_n=target_n, stiffness_n_per_m=known,
                path=output, overwrite=overwrite, on_sample=on_sample,
            )  # fmt: skip
    figure.draw(partial(drawn, run, knowledge))
    answer = grip_answer(run, simulated, known, warn(run_warnings(run)))
    error = tolerance_error(run, in_si("--tolerance", goal.tolerance))
    return Result(answer, grip_text(run, known), holds=run.held, error=error)


def drawn(run: GripRun, knowledge: GripperKnowledge, *, style: str) -> Axes:
    """Return the drawn grip; loads what draws only now."""
    from musclewire.extras.grip._grip_figure import plot_grip

    return plot_grip(run, knowledge, style=style)


def tolerance_error(run: GripRun, tolerance_n: float | None) -> MusclewireError | None:
    """Return by how much a held force misses its tolerance, or that no instrument shows it; else None."""
    if tolerance_n is None or not run.held:
        return None
    if run.true_force_n is None:
        return CallerError("--tolerance needs a load cell at the endpoint: this rig has none, leave it out")
    missed_n = run.true_force_n - run.target_n
    if abs(missed_n) <= tolerance_n:
        return None
    return MusclewireError(f"the held force misses its target by {missed_n:+.3f} N, more than {tolerance_n:g} N")


def knowledge_of(configuration: RigConfiguration, file: Path | None, seed: int | None) -> GripperKnowledge:
    """Return what the gripper has learned: from a file, or learned now and, with a file named, written there."""
    from musclewire.extras.grip._gripper_training import train_gripper

    if file is not None and file.exists():
        return knowledge_from(file, configuration)
    if file is not None:
        if file.suffix != ".json":
            raise CallerError(f"{file}: what a gripper has learned is a .json file, end its name so")
        require_folder(file)
    chosen = configuration.seed if seed is None else seed
    tell("training: free closings, and grips of a known block with a load cell")
    knowledge = train_gripper(configuration, seed=chosen + LEARNING_SEED_STEP, on_sample=stop_if_asked)
    if file is not None:
        knowledge.save(file)
    return knowledge


def knowledge_from(file: Path, configuration: RigConfiguration) -> GripperKnowledge:
    """Return what a file says, refused if it was learned on another gripper."""
    from musclewire.extras.grip._gripper_training import gripper_of, load_knowledge
    from musclewire.rigs import open_rig

    knowledge = load_knowledge(file)
    with open_rig(configuration) as opened:
        try:
            knowledge.gripper.require_same(gripper_of(opened))
        except CallerError as error:
            raise CallerError(f"{file}: {error}") from None
    return knowledge


def grip_answer(run: GripRun, block: ElasticObject | None, known: float | None, warnings: list[str]) -> GripAnswer:
    """Return what is known of a grip: the estimates, and what instruments and the simulation show."""
    from musclewire.extras.grip._answer import GripAnswer

    estimated_n, true_n = run.estimated_force_n, run.true_force_n
    return GripAnswer.read_from(
        run,
        contact=run.contact_s is not None,
        contact_score=float(run["contact_score"].max()),
        true_clearance_m=None if block is None else block.clearance_m,
        known_stiffness_n_per_m=known,
        used_stiffness_n_per_m=run.stiffness_n_per_m,
        true_stiffness_n_per_m=None if block is None else block.stiffness_n_per_m,
        error_n=None if estimated_n is None or true_n is None else estimated_n - true_n,
        samples=len(run),
        ended=run.metadata["ended"],
        warnings=warnings,
    )


def grip_text(run: GripRun, known: float | None) -> str:
    """Return a grip in words."""
    if run.contact_s is None:
        return f"no contact: the fingers closed and opened again (score up to {run['contact_score'].max():.2f})"
    opening = 0.0 if run.opening_m is None else 1e3 * run.opening_m
    lines = [f"contact {run.contact_s:.2f} s into closing, endpoints {opening:.2f} mm closed{at_force(run)}"]
    if not run.held:
        return "\n".join([*lines, f"{run.target_n:g} N was not reached: the fingers closed fully"])
    if known is None:
        lines.append(f"stiffness of the object by power: {run.stiffness_n_per_m:.0f} N/m, a rough number")
    lines.append(f"held: target {run.target_n:g} N, estimated {run.estimated_force_n:.3f} N{at_instrument(run)}")
    lines.append(f"a rigid object would have {run.most_force_n:.3f} N at this resistance")
    return "\n".join(lines)


def at_instrument(run: GripRun) -> str:
    """Return the force the instrument showed in the hold and how far the estimate was off, in words."""
    if run.true_force_n is None or run.estimated_force_n is None:
        return ""
    error_n, missed_n = run.estimated_force_n - run.true_force_n, run.true_force_n - run.target_n
    return (
        f", instrument {run.true_force_n:.3f} N: estimate off by {error_n:+.3f} N, target missed by {missed_n:+.3f} N"
    )


def at_force(run: GripRun) -> str:
    """Return what the instrument showed when contact was found, in words."""
    if run.true_force_at_contact_n is None:
        return ""
    return f"; the instrument showed {run.true_force_at_contact_n:.3f} N then"
