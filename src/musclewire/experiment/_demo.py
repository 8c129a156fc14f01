"""The main job from end to end: heat slowly, find the loop, fit, and move the wire without a sensor."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from musclewire.controllers import Staircase, staircase
from musclewire.experiment._closed_loop import control
from musclewire.experiment._metrics import ControlRun
from musclewire.experiment._open_loop import PAPER_PERIOD_S, characterize
from musclewire.experiment._pretension import PretensionSweep, pretension_sweep
from musclewire.experiment._run import OnSample, file_in
from musclewire.identify import LoopGaps, fit, loop_gaps
from musclewire.rigs import Rig, open_rig
from musclewire.sensing import SensingModel
from musclewire.signals import Recording

# Fig. 3: the major loop first, then two inside it.
AMPLITUDES_V = (3.2, 2.9, 2.75)
CYCLES = 2

Progress = Callable[[str, float], AbstractContextManager[OnSample]]


@dataclass(frozen=True)
class DemoResult:
    """Results of the demo; ``loops`` by amplitude [V], ``files`` by content."""

    loops: Mapping[float, Recording]
    gaps: LoopGaps
    model: SensingModel
    staircase: Staircase
    run: ControlRun
    sweep: PretensionSweep
    files: Mapping[str, Path]


def no_progress(_task: str, _total_s: float) -> AbstractContextManager[OnSample]:
    """Show nothing."""
    return nullcontext(lambda _: None)


def run_demo(folder: Path, *, seed: int = 1, progress: Progress = no_progress) -> DemoResult:
    """Do what the paper did on the simulated rig and keep every recording in ``folder``, even if interrupted.

    Slow sines of 3.2, 2.9 and 2.75 V; the pretension sweep; the fit of the 3.2 V loop at F_p = 1.9 N; the staircase of
    Fig. 11, from cold, by the loop that ``control`` runs by default. Existing files of an earlier demo are replaced.
    """
    files = {f"loop_{volts:g}V": file_in(folder, f"loop-{volts:g}V.h5") for volts in AMPLITUDES_V}
    files |= {"model": folder / "model.json", "staircase": folder / "staircase.h5"}
    steps = staircase()
    with open_rig("simulated", seed=seed) as rig:
        loops = {volts: slow_sine_loop(rig, volts, files[f"loop_{volts:g}V"], progress) for volts in AMPLITUDES_V}
        major = loops[AMPLITUDES_V[0]]
        model = fit(major)
        model.save(files["model"])
        with progress("Staircase, sensed by resistance", steps.duration_s) as on_sample:
            run = control(rig, model, steps, path=files["staircase"], overwrite=True, on_sample=on_sample)
    with (
        open_rig("simulated", seed=seed) as rig,
        progress("Pretension sweep", 8 * PAPER_PERIOD_S) as on_sample,
    ):
        sweep = pretension_sweep(rig, cycles=1, folder=folder / "pretension", on_sample=on_sample)
    return DemoResult(loops, loop_gaps(major), model, steps, run, sweep, files)


def slow_sine_loop(rig: Rig, amplitude_v: float, path: Path, progress: Progress) -> Recording:
    """Record the slow sine of one amplitude [V]."""
    with progress(f"Slow sine, {amplitude_v:g} V", CYCLES * PAPER_PERIOD_S) as on_sample:
        return characterize(
            rig,
            amplitude_v=amplitude_v,
            cycles=CYCLES,
            minor_loop=False,  # the paper made none; here loops of two amplitudes are shown instead
            path=path,
            overwrite=True,
            on_sample=on_sample,
        )
