"""What the user of a wire of the population does before any run: record, fit, calibrate. Nothing true gets here."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from musclewire import (
    Recording,
    RecordingError,
    SensingModel,
    calibrate,
    characterize,
    fit,
    load_model,
    loop_gaps,
    read_recording,
    save_wire,
)
from musclewire.experiment import Waveform, WaveformPolicy, run_on_rig
from musclewire.extras.calibration import SearchSettings
from musclewire.rigs import ProtectionTripError
from musclewire_robustness.plant import open_plant
from musclewire_robustness.population import PopulationWire
from musclewire_robustness.settings import settings

# Steps of the drive, held for this long [s]: from less than the wire's own time constant to a few of them.
HOLDS_S = (0.5, 3.0)
STREAM = 16
# The amplitude is raised step by step until a further step adds less than this to the stroke.
AMPLITUDE_RATIOS = (1.0, 1.08, 1.16, 1.24)
MIN_GROWTH = 0.03
MODEL, WIRE, LOOP, STEPS = "model.json", "wire.toml", "loop.h5", "steps.h5"


class UsersKnowledge(NamedTuple):
    """What the user of a wire knows of it.

    Parameters
    ----------
    model
        The model fitted to his slow loop.
    wire_file
        Path of his calibrated wire file.
    stroke
        Largest strain of his slow loop: 100 % of all figures.
    gap_pct
        Gap of his slow loop (Eq. 2) [%].
    amplitude_v
        Amplitude of his slow loop [V].
    loop
        The recording of his slow loop.
    """

    model: SensingModel
    wire_file: Path | None
    stroke: float
    gap_pct: float
    amplitude_v: float
    loop: Recording


def characterized(wire: PopulationWire, folder: Path) -> UsersKnowledge:
    """Return what the user of a wire knows; recorded and computed once, then read from the folder.

    Parameters
    ----------
    wire
        The wire; only its rig is used, and what it is called.
    folder
        Folder of this wire.

    Returns
    -------
    Model, wire file and the loop's numbers.
    """
    if not (folder / LOOP).exists():  # it is written last
        folder.mkdir(parents=True, exist_ok=True)
        characterize_wire(wire, folder)
    loop = read_recording(folder / LOOP)
    gaps = loop_gaps(loop)
    amplitude_v = loop.facts.number_or_none("amplitude_v")
    assert amplitude_v is not None
    return UsersKnowledge(
        load_model(folder / MODEL),
        folder / WIRE,
        gaps.segments.strain_max,
        100.0 * gaps.strain_gap,
        amplitude_v,
        loop,
    )


def characterize_wire(wire: PopulationWire, folder: Path) -> None:
    """Record a slow loop and a minute of random steps, fit a model and calibrate a wire file."""
    known = settings().characterization
    loop = slow_loop(wire)
    amplitude_v = loop.facts.number_or_none("amplitude_v")
    assert amplitude_v is not None
    with open_plant(wire, run=2).rig as rig:
        drive = random_drive(rig.sense_voltage_v, amplitude_v, known.random_steps_s, wire.seed)
        policy = WaveformPolicy(drive, known.random_steps_s)
        steps = run_on_rig(rig, policy, known.random_steps_s, metadata={"experiment": "random steps"})
    effort = SearchSettings(
        seed=wire.seed,
        starts=known.starts,
        jumps=known.jumps,
        evaluations_each=known.evaluations_each,
        evaluations_last=known.evaluations_last,
        threads=1,  # the benchmark has a process on each core
    )
    found = calibrate({"slow loop": loop, "random steps": steps}, wire=wire.base, settings=effort)
    fit(loop).save(folder / MODEL)
    save_wire(found, folder / WIRE, name=wire.base)
    steps.save(folder / STEPS)
    loop.save(folder / LOOP)


def slow_loop(wire: PopulationWire) -> Recording:
    """Return the slow loop at an amplitude beyond which the stroke hardly grows, as its user would find it.

    Parameters
    ----------
    wire
        A wire of the population, on its rig.

    Returns
    -------
    The recording of the slow loop.

    Raises
    ------
    RecordingError
        If no amplitude that the rig allows gives a loop that can be fitted.
    """
    best: Recording | None = None
    best_stroke, problem = 0.0, ""
    for ratio in AMPLITUDE_RATIOS:
        try:
            with open_plant(wire, run=1).rig as rig:
                loop = characterize(
                    rig, amplitude_v=min(ratio * rig.drive_amplitude_v, rig.maximum_voltage_v), minor_loop=False
                )
        except ProtectionTripError as error:  # it would be too hot: a user gives no more
            problem = str(error)
            break
        try:
            fit(loop)
            stroke = loop_gaps(loop).segments.strain_max
        except RecordingError as error:
            problem = str(error)
            continue
        if best is not None and stroke < (1.0 + MIN_GROWTH) * best_stroke:
            break
        best, best_stroke = loop, stroke
    if best is None:
        raise RecordingError(f"wire {wire.name} of the population gives no slow loop: {problem}")
    return best


def random_drive(sense_v: float, amplitude_v: float, duration_s: float, seed: int) -> Waveform:
    """Return random steps of the drive between sense voltage and amplitude, evenly spread in power, which heats."""
    random = np.random.default_rng([STREAM, seed])
    starts_s = np.concatenate([[0.0], np.cumsum(random.uniform(*HOLDS_S, int(duration_s / HOLDS_S[0]) + 1))])
    levels_v = np.sqrt(random.uniform(sense_v**2, amplitude_v**2, starts_s.size))

    def drive_voltage_v(time_s: float) -> float:
        return float(levels_v[int(np.searchsorted(starts_s, time_s + 1e-9, side="right")) - 1])

    return drive_voltage_v
