"""Commands that drive a rig: demo, characterize, pretension, control, train."""

from __future__ import annotations

import re
import time
from collections.abc import Mapping
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app.files import require_figure_file, require_model_file, require_recording_file, save_figure
from musclewire.app.on_board import OnBoard, loop_of
from musclewire.app.on_time import Cpu, RealTimePriority, keep_time
from musclewire.app.options import Force, Json, OutputPath, RealTime, RigName, Seed, quantity_option
from musclewire.app.output import emit_json, progress_bar, say, show, warn
from musclewire.app.stopping import stop_if_asked, stops_between_samples
from musclewire.errors import CallerError, RecordingError, nearest_hint

if TYPE_CHECKING:
    from musclewire.controllers.references import Reference
    from musclewire.experiment.metrics import ControlMetrics
    from musclewire.sensing.known_load import KnownSpring
    from musclewire.sensing.model import SensingModel
    from musclewire.signals.recording import Recording

__all__ = ["add_rig_commands"]

Amplitude = Annotated[str | None, typer.Option("--amplitude", help="Amplitude of the slow sine, as '3.2 V'.")]
# Steps as a text: "2.5 mm to 6 mm by 0.5 mm".
STEPS = re.compile(r"(.+?)\s+to\s+(.+?)\s+by\s+(.+)")
# Below this share of sensed samples a closed loop was not closed.
LEAST_VALID_SHARE = 0.8
# What a recording without displacement is good for, which on a board is every recording.
NO_INSTRUMENT = (
    "this rig measures no movement, so there is no gap to tell: the recording has voltages and resistance; for a fit "
    "add a column displacement_m measured beside it (a caliper, a ruler, a video), or control with a model fitted "
    "elsewhere to the same wire and length, as on the simulated rig"
)
Period = Annotated[float, typer.Option("--period", help="Period of the slow sine in seconds.", min=1.0, max=86400.0)]


def add_rig_commands(app: typer.Typer) -> None:
    """Add the commands of this file."""
    for command in (demo, characterize, pretension, control, train):
        app.command()(command)


def demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for report, model and recordings.")] = Path(
        "musclewire-demo"
    ),
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of everything random.")] = 1,
    json: Json = False,
) -> None:
    """The main job on the simulated rig: characterise, fit, control by resistance, report."""
    started = time.perf_counter()
    from musclewire.app.report.page import write_report
    from musclewire.experiment.demo import run_demo

    report = out / "report.html"
    if (out / "model.json").exists():
        require_model_file(out / "model.json")
    if report.is_file():
        report.unlink()  # an interrupted demo must not leave an old report beside new recordings
    with stops_between_samples():
        result = run_demo(out, seed=seed, progress=lambda task, total_s: progress_bar(task, total_s, quiet=json))
    write_report(result, report, time.perf_counter() - started)
    model, metrics = result.model, result.run.metrics
    wall_s = time.perf_counter() - started
    if json:
        emit_json(
            {
                "strain_gap_pct": 100 * result.gaps.strain_gap,
                "resistance_min_ohm": model.resistance_min_ohm,
                "resistance_max_ohm": model.resistance_max_ohm,
                **metrics_json(metrics),
                "best_pretension_n": result.sweep.best.pretension_n,
                "time_step_s": result.run.metadata["time_step_s"],
                "grains": result.run.metadata["grains"],
                "seed": seed,
                "warnings": list(model.warnings),
                "wall_s": wall_s,
                "report": str(report),
            }
        )
        return
    show(f"strain gap {100 * result.gaps.strain_gap:.3f} %, R {model.resistance_min_ohm:.3f} to "
        f"{model.resistance_max_ohm:.3f} ohm")  # fmt: skip
    show(str(metrics))
    show(f"{wall_s:.1f} s; open {report}")


def characterize(
    rig: RigName,
    output: Annotated[Path, typer.Option("--output", "-o", help="Recording to write (.h5).")],
    amplitude: Amplitude = None,
    period: Period = 90.0,
    cycles: Annotated[int, typer.Option("--cycles", help="Cycles; the last is the one analysed.", min=1)] = 2,
    seed: Seed = None,
    real_time: RealTime = False,
    real_time_priority: RealTimePriority = False,
    cpu: Cpu = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Heat and cool the wire slowly (the slow sine) and record it."""
    from musclewire.experiment.force_limit import force_warnings
    from musclewire.experiment.open_loop import characterize as run_characterize
    from musclewire.rigs.configuration import open_rig

    require_recording_file(output, force)
    with stops_between_samples(), open_rig(rig, seed=seed, real_time=real_time) as opened:
        volts = quantity_option(amplitude, "V", "--amplitude")
        refused = keep_time(opened, real_time_priority, cpu)
        with progress_bar("Slow sine", cycles * period, quiet=json) as on_sample:
            recording = run_characterize(
                opened,
                amplitude_v=volts,
                period_s=period,
                cycles=cycles,
                path=output,
                overwrite=force,
                on_sample=on_sample,
            )
    answer: dict[str, Any] = {
        "recording": str(output),
        "samples": len(recording),
        **loop_json(recording),
        "warnings": [*refused, *warn(force_warnings(recording))],
    }
    if json:
        emit_json(answer)
    else:
        show(f"{len(recording)} samples in {output}")
        show(answer.get("problem") or answer.get("note") or loop_text(answer))
    if "problem" in answer:
        raise typer.Exit(1)


def loop_json(recording: Recording) -> dict[str, Any]:
    """Return what the last loop of a recording shows, or under ``problem`` why it shows none.

    Without an instrument for the movement there is nothing to show, which is no problem: ``note`` says how to go on.
    """
    from musclewire.identify.loop_gaps import loop_gaps
    from musclewire.identify.recordings import reference_quantity

    keys = ("strain_gap_pct", "displacement_gap_pct", "force_gap_pct", "stroke_pct")
    if reference_quantity(recording, "strain") is None and "displacement_m" not in recording:
        return {**dict.fromkeys(keys), "note": NO_INSTRUMENT}
    try:
        gaps = loop_gaps(recording)
    except RecordingError as error:
        # The recording is sound and kept; it only shows no loop, which is worth knowing now.
        return {**dict.fromkeys(keys), "problem": str(error)}
    shares = (gaps.strain_gap, gaps.displacement_gap, gaps.force_gap, gaps.segments.strain_max)
    return {key: None if share is None else 100 * share for key, share in zip(keys, shares, strict=True)}


def loop_text(answer: Mapping[str, Any]) -> str:
    """Return the gaps of a loop in words; of the displacement only where it is not the wire's own."""
    gaps = [("strain", answer["strain_gap_pct"]), ("displacement", answer["displacement_gap_pct"])]
    if answer["displacement_gap_pct"] is not None and isclose(answer["displacement_gap_pct"], answer["strain_gap_pct"]):
        gaps.pop()
    gaps.append(("force", answer["force_gap_pct"]))
    said = (f"{name} gap {gap:.3f} %" for name, gap in gaps if gap is not None)
    return ", ".join([*said, f"stroke {answer['stroke_pct']:.2f} %"])


def pretension(
    rig: RigName,
    at: Annotated[list[str] | None, typer.Option("--at", help="A pretension to try, as '1.9 N'. Repeatable.")] = None,
    quantity: Annotated[
        str, typer.Option("--quantity", help="What is to be sensed: strain, displacement or force.")
    ] = "strain",
    amplitude: Amplitude = None,
    period: Period = 90.0,
    cycles: Annotated[int, typer.Option("--cycles", help="Cycles at each setting.", min=1)] = 2,
    folder: Annotated[Path | None, typer.Option("--folder", help="Keep the recording of each setting here.")] = None,
    plot: Annotated[Path | None, typer.Option("--plot", help="Write the figure (.svg, .png, .pdf).")] = None,
    seed: Seed = None,
    json: Json = False,
) -> None:
    """Sweep the pretension, compare the hysteresis gaps, name the best for the quantity."""
    from musclewire.experiment.pretension import pretension_sweep
    from musclewire.rigs.configuration import open_rig

    require_figure_file(plot)
    forces = [force for text in at or () if (force := quantity_option(text, "N", "--at")) is not None] or None
    with stops_between_samples(), open_rig(rig, seed=seed) as opened:
        sweep = pretension_sweep(
            opened,
            forces,
            quantity=quantity,
            amplitude_v=quantity_option(amplitude, "V", "--amplitude"),
            period_s=period,
            cycles=cycles,
            folder=folder,
            on_setting=None if json else lambda force: say(f"pretension {force:.2f} N"),
            on_sample=stop_if_asked,
        )
    for failure in sweep.failures:
        say(f"not usable: {failure}")
    warnings = warn(sweep.warnings)
    if plot is not None:
        save_figure(sweep.plot(), plot)
    rows = [
        {
            "pretension_n": row.pretension_n,
            "strain_gap_pct": row.strain_gap_pct,
            "force_gap_pct": row.force_gap_pct,
            "displacement_gap_pct": row.displacement_gap_pct,
            "stroke_pct": row.stroke_pct,
        }
        for row in sweep.rows
    ]
    if json:
        emit_json(
            {
                "rows": rows,
                "best_pretension_n": sweep.best.pretension_n,
                "failures": list(sweep.failures),
                "warnings": warnings,
            }
        )
        return
    for row in sweep.rows:
        gaps = {name: row.gap_pct(name) for name in dict.fromkeys((quantity, "strain", "force"))}
        shown = (f"{name} gap {'-' if gap is None else format(gap, '6.3f')} %" for name, gap in gaps.items())
        show(f"{row.pretension_n:6.2f} N   {'   '.join(shown)}")
    show(f"best: {sweep.best.pretension_n:.2f} N")


def control(
    rig: RigName,
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model file from 'musclewire fit'.")],
    quantity: Annotated[str, typer.Option("--quantity", help="strain, displacement or force.")] = "strain",
    stiffness: Annotated[
        str | None,
        typer.Option("--stiffness", help="Force from a model of strain: the load's stiffness, as '588.6 N/m'."),
    ] = None,
    reference: Annotated[
        str,
        typer.Option(
            "--reference", help="'staircase', steps of your own as '2.5 mm to 6 mm by 0.5 mm', or a file with targets."
        ),
    ] = "staircase",
    output: OutputPath = None,
    rules: Annotated[
        str, typer.Option("--rules", help="Rule base of the fuzzy tuning; see 'musclewire rules'.")
    ] = "zhao-1993",
    recalibrate: Annotated[
        bool, typer.Option("--recalibrate", help="First sweep once and anchor R_min, R_max anew.")
    ] = False,
    on_board: OnBoard = False,
    seed: Seed = None,
    real_time: RealTime = False,
    real_time_priority: RealTimePriority = False,
    cpu: Cpu = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Closed loop: move the wire by its own resistance; MAE of each step."""
    from musclewire.controllers import FuzzyPidSettings
    from musclewire.experiment.closed_loop import APPROACH_S
    from musclewire.experiment.force_limit import force_warnings
    from musclewire.experiment.timing import timing_json
    from musclewire.experiment.training import recalibrate as anchor
    from musclewire.rigs.configuration import open_rig
    from musclewire.sensing import load_model

    loaded = load_model(model)
    load = known_spring(loaded, model, quantity, quantity_option(stiffness, "N/m", "--stiffness"))
    target = read_reference(reference, quantity)
    settings = FuzzyPidSettings(rule_base=rules)
    if output is not None:
        require_recording_file(output, force)
    follow = loop_of(loaded, settings, load, recalibrate, on_board)
    with stops_between_samples(), open_rig(rig, seed=seed, real_time=real_time) as opened:
        refused = keep_time(opened, real_time_priority, cpu)
        if recalibrate:
            with progress_bar("Anchoring R_min and R_max", 90.0, quiet=json) as anchoring:
                loaded = anchor(opened, loaded, on_sample=anchoring).model
        if target is None:
            target = staircase_for(loaded, load, opened.leg_length_m)
        with progress_bar("Closed loop", APPROACH_S + target.duration_s, quiet=json) as on_sample:
            run = follow(opened, loaded, target, path=output, overwrite=force, on_sample=on_sample)
    answer = {
        **metrics_json(run.metrics),
        **timing_json(run.metadata),
        "known_stiffness_n_per_m": None if load is None else load.stiffness_n_per_m,
        "known_friction_n": None if load is None else load.friction_n,
        "ended": run.metadata["ended"],
        "samples": len(run),
        "warnings": [*refused, *warn(force_warnings(run))],
    }
    if json:
        emit_json(answer)
    else:
        show(str(run.metrics))
    if run.metrics.valid_share < LEAST_VALID_SHARE:
        say(
            f"musclewire: only {100 * run.metrics.valid_share:.0f} % of the samples could be sensed; this does not hold"
        )
        raise typer.Exit(1)


def train(
    rig: RigName,
    amplitude: Amplitude = None,
    period: Period = 30.0,
    most_cycles: Annotated[int, typer.Option("--most-cycles", help="Give up after this many.", min=2)] = 60,
    folder: Annotated[Path | None, typer.Option("--folder", help="Keep the recording of each cycle here.")] = None,
    seed: Seed = None,
    json: Json = False,
) -> None:
    """Cycle a new wire until its loop repeats."""
    from musclewire.experiment.training import TrainingCycle
    from musclewire.experiment.training import train as run_train
    from musclewire.rigs.configuration import open_rig

    def say_cycle(cycle: TrainingCycle) -> None:
        change = "" if cycle.change is None else f", moved by {100 * cycle.change:.2f} % over five cycles"
        say(f"cycle {cycle.number}: R {cycle.resistance_min_ohm:.3f} to {cycle.resistance_max_ohm:.3f} ohm, "
            f"stroke {100 * cycle.stroke:.3f} %{change}")  # fmt: skip

    with stops_between_samples(), open_rig(rig, seed=seed) as opened:
        training = run_train(
            opened,
            amplitude_v=quantity_option(amplitude, "V", "--amplitude"),
            period_s=period,
            most_cycles=most_cycles,
            folder=folder,
            on_cycle=None if json else say_cycle,
            on_sample=stop_if_asked,
        )
    warnings = warn(training.warnings)
    if json:
        cycles = [vars(cycle) for cycle in training.cycles]
        emit_json({"settled": training.settled, "cycles": cycles, "warnings": warnings})
    else:
        show("settled" if training.settled else f"not settled after {len(training.cycles)} cycles")
    if not training.settled:
        raise typer.Exit(1)


def metrics_json(metrics: ControlMetrics) -> dict[str, Any]:
    """Return the metrics of a closed loop under the keys of the interface."""
    key, factor = {"strain": ("target_pct", 100.0), "displacement": ("target_m", 1.0), "force": ("target_n", 1.0)}[
        metrics.quantity
    ]
    steps = [
        {
            key: round(factor * step.target, 10),
            "direction": step.direction,
            "mae_pct": step.mae_pct,
            "estimate_mae_pct": step.estimate_mae_pct,
            "tracking_mae_pct": step.tracking_mae_pct,
        }
        for step in metrics.steps
    ]
    return {
        "steps": steps,
        "mae_max_pct": metrics.mae_max_pct,
        "mae_mean_pct": metrics.mae_mean_pct,
        "valid_share": metrics.valid_share,
        "rms_pct": metrics.rms_pct,
        "estimate_rms_pct": metrics.estimate_rms_pct,
        "tracking_rms_pct": metrics.tracking_rms_pct,
    }


def known_spring(loaded: SensingModel, path: Path, quantity: str, stiffness: float | None) -> KnownSpring | None:
    """Return the load whose stiffness is known, None without one.

    Raises CallerError where the model does not sense the quantity, directly or by a stiffness.
    """
    from musclewire.identify.recordings import QUANTITIES
    from musclewire.sensing.known_load import KnownSpring

    if quantity not in QUANTITIES:
        raise CallerError(f"there is no quantity '{quantity}'{nearest_hint(quantity, QUANTITIES)}")
    if stiffness is None:
        if loaded.quantity == quantity:
            return None
        way = " or, for a known load, give --stiffness" if quantity == "force" else ""
        raise CallerError(
            f"model {path} senses {loaded.quantity}, not {quantity}: fit one with --quantity {quantity}{way}"
        )
    if quantity != "force":
        raise CallerError(f"--stiffness turns strain into force, but --quantity is {quantity}: give --quantity force")
    friction = loaded.wire.get("guide_friction_n")
    return KnownSpring(stiffness, float(friction) if isinstance(friction, (int, float)) else 0.0)


def staircase_for(loaded: SensingModel, load: KnownSpring | None, leg_length_m: float) -> Reference:
    """Return the built-in staircase for a model, in force where a load's stiffness is known."""
    from musclewire.experiment.staircases import staircase_within
    from musclewire.sensing.known_load import force_model

    return staircase_within(loaded if load is None else force_model(loaded, load.stiffness_n_per_m, leg_length_m))


def read_reference(reference: str, quantity: str) -> Reference | None:
    """Return steps that the text tells, or the targets in a recording file; None for the built-in staircase."""
    from musclewire.controllers import sampled_reference, staircase
    from musclewire.identify.recordings import COLUMN_SUFFIX
    from musclewire.signals import read_recording
    from musclewire.signals.units import parse_quantity

    if reference == "staircase":
        return None
    if steps := STEPS.fullmatch(reference.strip()):
        unit = {"strain": "", "displacement": "m", "force": "N"}[quantity]
        start, stop, by = (parse_quantity(text, unit) for text in steps.groups())
        return staircase(start, stop, by)
    if not Path(reference).exists():
        raise CallerError(
            f"there is no reference '{reference}'{nearest_hint(reference, ['staircase'])}, or give a file"
        )
    table = read_recording(reference)
    return sampled_reference(table["time_s"] - table["time_s"][0], table[f"target_{COLUMN_SUFFIX[quantity]}"])
