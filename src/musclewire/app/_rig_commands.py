"""Commands that drive a rig by a given voltage: demo, characterize, pretension, train."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from musclewire.app._figure_options import FigureOptions
from musclewire.app._files import require_model_file, require_recording_file
from musclewire.app._options import (
    AMPLITUDE,
    AT,
    COMPARED_QUANTITY,
    MAX_CYCLES,
    NO_MINOR_LOOP,
    OVERWRITE,
    PERIOD,
    SEED,
    UNTIL_LEVEL,
    RigName,
    in_si,
    own_help,
)
from musclewire.app._output import Result, progress_bar, say, table, tell, warn
from musclewire.app._rig_options import SlowSineOptions, TimingOptions
from musclewire.app._stopping import opened_rig, stop_if_asked, stops_between_samples
from musclewire.errors import CallerError, RecordingError

if TYPE_CHECKING:
    from musclewire.app._answers import CharacterizeAnswer
    from musclewire.experiment import OnSample, PretensionRow, PretensionSweep
    from musclewire.rigs import GuardedRig
    from musclewire.signals import Recording

# What a recording without displacement is good for, which on a board is every recording.
NO_INSTRUMENT = (
    "this rig measures no movement, so there is no gap to report: 'musclewire fit' with --wire and the wire's name "
    "makes a model of the resistance alone; a column displacement_m from an instrument of your own (a caliper, a "
    "ruler, a video) makes a better one"
)


def demo(
    figure: FigureOptions,
    output: Annotated[Path, own_help("--output", "Folder for report, model and recordings.")] = Path("musclewire-demo"),
    seed: Annotated[int, SEED] = 1,
) -> Result:
    """The main job on the simulated rig: characterize, fit, control by resistance, report."""
    started = time.perf_counter()
    from musclewire.app._answers import DemoAnswer
    from musclewire.app._report.page import write_report
    from musclewire.experiment import friction_warnings, run_demo, run_warnings, step_warnings
    from musclewire.judge import judgement_of

    figure.check()
    report = output / "report.html"
    if (output / "model.json").exists():
        require_model_file(output / "model.json")
    if report.is_file():
        report.unlink()  # an interrupted demo must not leave an old report with new recordings
    with stops_between_samples():
        result = run_demo(output, seed=seed, progress=lambda task, total_s: progress_bar(task, total_s))
    write_report(result, report, time.perf_counter() - started)
    figure.draw(result.run.plot)
    wall_s = time.perf_counter() - started
    model, run, sweep = result.model, result.run, result.sweep
    # Drives, loads and pretensions are the demo's own choice: which limits they exceed is in its report.
    warn((*judgement_of(run).warnings, *friction_warnings(run), *step_warnings(run)))
    answer = DemoAnswer.of_run(
        run.metrics,
        strain_gap_pct=100 * result.gaps.strain_gap,
        resistance_min_ohm=model.resistance_min_ohm,
        resistance_max_ohm=model.resistance_max_ohm,
        best_pretension_n=None if sweep.best is None else sweep.best.pretension_n,
        time_step_s=run.metadata["time_step_s"],
        warnings=list(dict.fromkeys((*model.warnings, *sweep.warnings, *run_warnings(run)))),
        seed=seed,
        wall_s=wall_s,
        report=str(report),
    )
    text = (
        f"strain gap {answer.strain_gap_pct:.3f} %, R {model.resistance_min_ohm:.3f} to {model.resistance_max_ohm:.3f} "
        f"ohm\n{run.metrics}\n{wall_s:.1f} s; open {report}"
    )
    return Result(answer, text)


def characterize(
    rig: RigName,
    output: Annotated[Path, own_help("--output", "Recording to write (.h5).")],
    sine: SlowSineOptions,
    timing: TimingOptions,
    figure: FigureOptions,
    seed: Annotated[int | None, SEED] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
    until_level: Annotated[bool, UNTIL_LEVEL] = False,
    no_minor_loop: Annotated[bool, NO_MINOR_LOOP] = False,
) -> Result:
    """Heat and cool the wire slowly (the slow sine) and record it.

    A minor loop follows the cycles, a segment of its own: by it a fit knows what the wire does that turns around.
    """
    from musclewire.experiment import MINOR_LOOP_CYCLES, run_warnings
    from musclewire.experiment import characterize as run_characterize

    period_s = sine.period_s
    require_recording_file(output, overwrite)
    figure.check()
    if until_level and sine.amplitude is not None:
        raise CallerError("--until-level raises the rig's own amplitude: leave out --amplitude, or --until-level")
    with stops_between_samples(), timing.open_rig(rig, seed) as opened:
        amplitude_v = sine.amplitude_v
        refused = timing.apply(opened)
        cycles = sine.cycles + (0 if no_minor_loop else MINOR_LOOP_CYCLES)
        with progress_bar("Slow sine", cycles * period_s, opened) as on_sample:
            recording = run_characterize(
                opened,
                amplitude_v=amplitude_v,
                period_s=period_s,
                cycles=sine.cycles,
                until_level=until_level,
                minor_loop=not no_minor_loop,
                path=output,
                overwrite=overwrite,
                on_sample=on_sample,
            )
    figure.draw(recording.plot)
    answer = loop_answer(
        recording,
        recording=str(output),
        samples=len(recording),
        **{name: recording.metadata.get(name) for name in ("amplitude_v", "amplitude_raised", "shows_c")},
        warnings=[*refused, *warn(run_warnings(recording))],
    )
    said = answer.problem or answer.note or loop_text(answer)
    lines = [f"{len(recording)} samples in {output}", said, *hot_end_lines(answer)]
    return Result(answer, "\n".join(lines), holds=answer.problem is None)


def hot_end_lines(answer: CharacterizeAnswer) -> list[str]:
    """Return in words how far the amplitude was raised and whether the hot end is C; none if nothing is to be said."""
    raised, amplitude_v = answer.amplitude_raised, answer.amplitude_v
    lines = [] if raised is None else [f"amplitude raised to {amplitude_v:.2f} V: {raised}"]
    if answer.shows_c is False:
        lines.append(
            f"C is only the turning point of the drive: the resistance still falls at {amplitude_v:.2f} V, and strain "
            "beyond is unknown"
        )
    return lines


def loop_answer(measured: Recording, **facts: Any) -> CharacterizeAnswer:
    """Return what the last loop of a recording shows, or under ``problem`` why it shows none.

    Without an instrument for the movement there is nothing to show, which is no problem: ``note`` says how to go on.
    """
    from musclewire.app._answers import CharacterizeAnswer
    from musclewire.identify import loop_gaps
    from musclewire.signals import reference_quantity

    if reference_quantity(measured, "strain") is None and "displacement_m" not in measured:
        return CharacterizeAnswer(**facts, note=NO_INSTRUMENT)
    try:
        gaps = loop_gaps(measured)
    except RecordingError as error:
        # The recording is sound and kept; it only shows no loop, which is worth knowing now.
        return CharacterizeAnswer(**facts, problem=str(error))
    return CharacterizeAnswer(
        **facts,
        strain_gap_pct=100 * gaps.strain_gap,
        displacement_gap_pct=None if gaps.displacement_gap is None else 100 * gaps.displacement_gap,
        force_gap_pct=None if gaps.force_gap is None else 100 * gaps.force_gap,
        stroke_pct=100 * gaps.segments.strain_max,
        no_force_gap=gaps.no_force_gap,
    )


def loop_text(answer: CharacterizeAnswer) -> str:
    """Return the gaps of a loop in words; of the displacement only where it is not the wire's own."""
    gaps = [("strain", answer.strain_gap_pct), ("displacement", answer.displacement_gap_pct)]
    if answer.displacement_gap_pct is not None and isclose(answer.displacement_gap_pct, answer.strain_gap_pct or 0.0):
        gaps.pop()
    gaps.append(("force", answer.force_gap_pct))
    said = (f"{name} gap {gap:.3f} %" for name, gap in gaps if gap is not None)
    why = [f"no force gap: {answer.no_force_gap}"] if answer.no_force_gap else []
    return "\n".join([", ".join([*said, f"stroke {answer.stroke_pct:.2f} %"]), *why])


def pretension(
    rig: RigName,
    sine: SlowSineOptions,
    figure: FigureOptions,
    at: Annotated[list[str] | None, AT] = None,
    quantity: Annotated[str, COMPARED_QUANTITY] = "strain",
    output: Annotated[Path | None, own_help("--output", "Folder for the recording of each setting.")] = None,
    seed: Annotated[int | None, SEED] = None,
) -> Result:
    """Sweep the pretension, compare the hysteresis gaps, name the best for the quantity.

    The output is a folder for the recording of each setting.
    """
    from musclewire.app._answers import PretensionAnswer
    from musclewire.experiment import pretension_sweep

    figure.check()
    period_s, amplitude_v = sine.period_s, sine.amplitude_v
    forces = [in_si("--at", text) for text in at or ()] or None

    def say_setting(force_n: float) -> None:
        stop_if_asked()
        tell(f"pretension {force_n:.2f} N")

    with (
        stops_between_samples(),
        opened_rig(rig, seed=seed) as opened,
        watched_runs("Pretension sweep", opened) as on_sample,
    ):
        sweep = pretension_sweep(
            opened,
            forces,
            quantity=quantity,
            amplitude_v=amplitude_v,
            period_s=period_s,
            cycles=sine.cycles,
            folder=output,
            on_setting=say_setting,
            on_sample=on_sample,
        )
    for failure in sweep.failures:
        say(f"not usable: {failure}")
    warn(sweep.warnings)
    figure.draw(sweep.plot)
    best_n = None if sweep.best is None else sweep.best.pretension_n
    answer = PretensionAnswer.read_from(sweep, best_pretension_n=best_n, largest_pretension_n=sweep.largest_n)
    return Result(answer, sweep_text(sweep, quantity), holds=best_n is not None)


@contextmanager
def watched_runs(task: str, rig: GuardedRig) -> Iterator[OnSample | None]:
    """Show a rig's numbers during runs of any length, and stop within one.

    Without a clock a run is short, and whole ones can be compiled: then nothing looks at its samples.
    """
    if rig.paced:
        with progress_bar(task, None, rig) as on_sample:
            yield on_sample
    else:
        yield None


def sweep_text(sweep: PretensionSweep, quantity: str) -> str:
    """Return a line for each pretension with its gaps, and the best one."""
    names = dict.fromkeys((quantity, "strain", "force"))
    shown = [name for name in names if any(row.gap_pct(name) is not None for row in sweep.rows)]
    rows = (
        [f"{row.pretension_n:.2f} N", *(percent(row.gap_pct(name)) for name in shown), pull(row)] for row in sweep.rows
    )
    lines = [table(["pretension", *(f"{name} gap" for name in shown), "largest pull"], rows, left=())]
    level = {f"{row.pretension_n:.2f}": row.no_force_gap for row in sweep.rows if row.no_force_gap}
    why = [f"no force gap at {', '.join(level)} N: {next(iter(level.values()))}"] if level else []
    found = "none" if sweep.best is None else f"{sweep.best.pretension_n:.2f} N"
    limit = (
        ""
        if sweep.largest_n is None
        else f"; at most {sweep.largest_n:.2f} N by the vendor's stress in motion (above it: !)"
    )
    return "\n".join([*lines, *why, f"best: {found}{limit}", *filter(None, [sweep.advice])])


def pull(row: PretensionRow) -> str:
    """Return the largest pull of a setting's loop, marked where it is above the vendor's; a dash for none."""
    if row.largest_force_n is None:
        return "-"
    return f"{row.largest_force_n:.2f} N{'' if row.within_limit else ' !'}"


def percent(gap_pct: float | None) -> str:
    """Return a percentage, a dash for none."""
    return "-" if gap_pct is None else f"{gap_pct:.3f} %"


def train(
    rig: RigName,
    figure: FigureOptions,
    amplitude: Annotated[str | None, AMPLITUDE] = None,
    period: Annotated[str, PERIOD] = "30 s",
    max_cycles: Annotated[int, MAX_CYCLES] = 60,
    output: Annotated[Path | None, own_help("--output", "Folder for the recording of each cycle.")] = None,
    seed: Annotated[int | None, SEED] = None,
) -> Result:
    """Cycle a new wire until its loop repeats.

    The output is a folder for the recording of each cycle.
    """
    from musclewire.app._answers import TrainAnswer
    from musclewire.experiment import TrainingCycle, training_figure
    from musclewire.experiment import train as run_train

    def say_cycle(cycle: TrainingCycle) -> None:
        stop_if_asked()
        change = "" if cycle.change is None else f", moved by {100 * cycle.change:.2f} % over five cycles"
        tell(f"cycle {cycle.number}: R {cycle.resistance_min_ohm:.3f} to {cycle.resistance_max_ohm:.3f} ohm, "
            f"stroke {100 * cycle.stroke:.3f} %{change}")  # fmt: skip

    figure.check()
    period_s, amplitude_v = in_si("--period", period), in_si("--amplitude", amplitude)
    with (
        stops_between_samples(),
        opened_rig(rig, seed=seed) as opened,
        watched_runs("Training", opened) as on_sample,
    ):
        training = run_train(
            opened,
            amplitude_v=amplitude_v,
            period_s=period_s,
            max_cycles=max_cycles,
            folder=output,
            on_cycle=say_cycle,
            on_sample=on_sample,
        )
    figure.draw(partial(training_figure, training))
    warn(training.warnings)
    text = "settled" if training.settled else f"not settled after {len(training.cycles)} cycles"
    return Result(TrainAnswer.read_from(training), text, holds=training.settled)
