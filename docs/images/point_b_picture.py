"""The picture of point B on the page on why resistance shows strain: where it is, and how far noise moves it."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from musclewire.arrays import FloatArray
from musclewire.experiment import characterize
from musclewire.identify import LoopGaps, loop_gaps, mark_points, required_quantity
from musclewire.judge import resistance_reading
from musclewire.pages import AVERAGE, COOLING, HEATING
from musclewire.rigs import open_rig
from musclewire.sensing import MAX_WINDOW_FRACTION, noise_level, smooth, smoothing_window
from musclewire.signals import Recording

SEEDS = range(1, 51)
# Samples to both sides of B in the right picture, and branches in a recording of two cycles.
AROUND, BRANCHES = 90, 4
SAMPLES_GREY = "0.65"


def point_b_figure() -> Figure:
    """Draw the loop with A, B and C, and next to it B of 50 recordings that differ in their noise alone."""
    recordings = [recorded(seed) for seed in SEEDS]
    gaps = [loop_gaps(recording) for recording in recordings]
    figure = Figure(figsize=(9.6, 4.1), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_loop(left, recordings[0], gaps[0])
    draw_tops(right, recordings, gaps)
    return figure


def recorded(seed: int) -> Recording:
    """Return a slow sine of the simulated rig."""
    with open_rig("simulated", seed=seed) as rig:
        return characterize(rig)


def draw_loop(axes: Axes, recording: Recording, gaps: LoopGaps) -> None:
    """Draw strain over resistance from A to C and back."""
    found = gaps.segments
    resistance, strain = resistance_reading(recording).resistance_ohm, 100.0 * required_quantity(recording)
    for part, colour, name in (
        (slice(found.heating_a, found.heating_c + 1), HEATING, "heating"),
        (slice(found.cooling_c, found.cooling_a + 1), COOLING, "cooling"),
    ):
        axes.plot(resistance[part], strain[part], color=colour, label=name)
    mark_points(axes, resistance, strain, gaps)
    axes.set(xlabel="resistance [ohm]", ylabel="strain [%]", title="A to B: warming; B to C: the segment that senses")
    axes.legend(loc="upper right")


def draw_tops(axes: Axes, recordings: list[Recording], gaps: list[LoopGaps]) -> None:
    """Draw one recording's samples around B, and the tops of all of them by their largest smoothed sample and by B."""
    before, now = [], []
    for recording, gap in zip(recordings, gaps, strict=True):
        found, strain = gap.segments, required_quantity(recording)
        resistance = smoothed(resistance_reading(recording).resistance_ohm)
        cold, warm = found.strain_cold, strain[found.heating_c]
        fraction = 100.0 * (strain - cold) / (warm - cold)
        largest = found.heating_a + int(np.argmax(resistance[found.heating_a : found.heating_c]))
        before.append((fraction[largest], resistance[largest]))
        now.append((100.0 * (1.0 - found.transformation_fraction), found.resistance_max_ohm))
        if recording is recordings[0]:
            rows = slice(found.heating_b - AROUND, found.heating_b + AROUND)
            axes.plot(fraction[rows], resistance_reading(recording).resistance_ohm[rows], ".", color=SAMPLES_GREY,
                markersize=3, label="samples of one recording")  # fmt: skip
    axes.plot(*np.transpose(before), "x", color=COOLING, markersize=5, label="largest smoothed sample of 50")
    axes.plot(*np.transpose(now), "o", color=AVERAGE, markersize=4, label="B of the same 50")
    axes.set(
        xlabel="strain from A [% of that at C]",
        ylabel="resistance [ohm]",
        title="A flat top: noise moves the largest sample",
    )
    axes.legend(loc="lower center")


def smoothed(resistance: FloatArray) -> FloatArray:
    """Return a recording's resistance as smoothed before its points are looked for."""
    window = int(MAX_WINDOW_FRACTION * resistance.size / BRANCHES)
    return smooth(resistance, smoothing_window(noise_level(resistance), float(np.ptp(resistance)), window))
