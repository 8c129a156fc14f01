# ruff: noqa: E402 - a package that may be missing is asked for first
"""Wires of the population swept in 14 s to an hour: the filter errs alike at 20 Hz and at 71 samples a loop.

And where these were drawn out twentyfold by straight lines. Every valid sample counts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from tests.tools import require_package

require_package("musclewire_robustness", "pip install ./studies/robustness")

from musclewire_robustness.characterizing import slow_loop
from musclewire_robustness.plant import open_plant
from musclewire_robustness.population import drawn_wire

from musclewire.experiment import characterize
from musclewire.identify import estimate, fit
from musclewire.sensing import SensingModel
from musclewire.signals import Recording, reference_quantity

# Samples of a loop that is written down by hand, or by a logger that is slow; and how many are made of one.
SPARSE, DRAWN_OUT = 71, 20
# The errors of other loops over those of one of 90 s at 20 Hz, and the least share of 95 % intervals that hold.
MAX_RATIO, MIN_HELD = 1.3, 0.9


def seldom(recording: Recording) -> Recording:
    """Return two loops of which only so many samples were kept."""
    kept = np.unique(np.linspace(0, len(recording) - 1, 2 * SPARSE).round().astype(int))
    return Recording({name: values[kept] for name, values in recording.columns.items()}, recording.metadata)


def drawn_out(recording: Recording) -> Recording:
    """Return a recording with straight lines between its samples, as for a curve that is to have more points."""
    given_s = recording["time_s"]
    time_s = np.linspace(given_s[0], given_s[-1], DRAWN_OUT * len(recording))
    columns = {name: np.interp(time_s, given_s, values) for name, values in recording.columns.items()}
    return Recording(columns, recording.metadata)


def errors(model: SensingModel, recording: Recording) -> tuple[float, float]:
    """Return the mean square error of valid samples [% of the stroke, squared], and the share of held intervals."""
    strain = reference_quantity(recording, "strain")
    found = estimate(model, recording).recording
    assert strain is not None
    valid = found["valid"] > 0.0
    error = (found["estimated_strain"] - strain)[valid]
    held = np.abs(error) <= 1.96 * found["estimate_std"][valid]
    return float(np.mean((100.0 * error / model.stroke) ** 2)), float(held.mean())


def of_a_wire(seed: int, periods_s: Sequence[float]) -> Iterator[tuple[str, float, float]]:
    """Yield each loop's name, mean square error and held share."""
    wire = drawn_wire(seed)
    slow = slow_loop(wire)
    model, amplitude_v = fit(slow), slow.facts.number_or_none("amplitude_v")
    for period_s in periods_s:
        with open_plant(wire, run=3).rig as rig:
            recording = characterize(rig, amplitude_v=amplitude_v, period_s=period_s)
        yield (f"{period_s:g} s at 20 Hz", *errors(model, recording))
        sparse = seldom(recording)
        yield (f"{period_s:g} s at {SPARSE} samples", *errors(model, sparse))
        yield (f"{period_s:g} s at {SPARSE} samples, drawn out", *errors(model, drawn_out(sparse)))


def judge(seeds: range, periods_s: Sequence[float]) -> None:
    """Print each loop's error and held share over the wires, and hold them to the bars."""
    rows: dict[str, list[tuple[float, float]]] = {}
    for seed in seeds:
        for name, square, held in of_a_wire(seed, periods_s):
            rows.setdefault(name, []).append((square, held))
    rms = {name: float(np.sqrt(np.mean([square for square, _ in row]))) for name, row in rows.items()}
    held_in = {name: float(np.mean([held for _, held in row])) for name, row in rows.items()}
    for name in rows:
        ratio = rms[name] / rms["90 s at 20 Hz"]
        print(f"{name}: rms {rms[name]:.2f} % of the stroke, {ratio:.2f} of 90 s; {100 * held_in[name]:.0f} % held")
    assert max(rms.values()) <= MAX_RATIO * rms["90 s at 20 Hz"]
    assert min(held_in.values()) >= MIN_HELD


@pytest.mark.slow
def test_two_wires_are_sensed_at_any_speed() -> None:
    judge(range(107, 109), (30.0, 90.0, 1000.0))


@pytest.mark.full
def test_six_wires_are_sensed_from_14_s_to_an_hour() -> None:
    judge(range(107, 113), (14.0, 30.0, 90.0, 300.0, 1000.0, 3500.0))
