"""What was tried: sets of the numbers a spool and a bench already had, one number more at a time, and the fit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from finger_spool.bars import PAPER_N, PAPER_PCT, distance, smallest_gap_place_n, sweep
from finger_spool.loops import LoopRow, Trial, read_gap_pct, slow_path

AMPLITUDE_V = 1.8
BARRIER_SHIFTS_K, BARRIER_STEP_K = (2.0, 10.0), 0.1
TriedSet = tuple[float, str, list[LoopRow]]

# Amplitudes that leave a seventh of the wire in martensite to none; shifts within those of 70 and 90 C wire; friction
# of a guide that the finger's bench does not have, in addition to that of the tendon.
AMPLITUDES_V = (1.65, 1.8, 1.95)
TEMPERATURE_SHIFTS_K = (-10.0, 0.0, 10.0, 20.0)
FRICTIONS_N = (0.0, 0.06, 0.2, 0.4)
PLACES_N = (0.47, 0.55, 0.63, 0.67, 0.71, 0.75, 0.79, 0.87, 0.95)
R_PHASE_SHIFTS_K = tuple(float(shift) for shift in np.arange(-12.0, 6.1, 1.5))
# One number more of a spool's alloy: low and high as published (parameters/data/published/ranges.toml), or where
# nothing is, the bounds of studies/paper_wires/unknowns.py.
ONE_MORE = {
    "martensite_barrier_k": (7.44411, 17.5),
    "martensite_spread_k": (6.0, 16.0),
    "r_phase_spread_k": (5.0, 25.0),
    "r_phase_resistivity_ohm_m": (0.95e-6, 1.15e-6),
    "r_phase_resistivity_per_k": (-1.0e-3, 5e-4),
    "r_phase_entropy_ratio": (0.1, 0.4),
    "r_phase_stress_rate_pa_per_k": (15e6, 30e6),
    "r_to_m_barrier_k": (2.0, 23.0),
    "r_phase_strain": (0.002, 0.005),
    "martensite_resistivity_ohm_m": (0.87e-6, 1.06e-6),
    "martensite_resistivity_per_k": (3e-4, 7e-4),
    "austenite_resistivity_per_k": (5e-5, 2e-4),
}


def sets_of_old_numbers(*, thin: bool) -> Iterator[tuple[str, Trial]]:
    """Yield every combination of R-phase shift, temperature shift, guide friction and amplitude, with a label."""
    step = 2 if thin else 1
    for shift, warmer, friction, amplitude in product(
        R_PHASE_SHIFTS_K[::step], TEMPERATURE_SHIFTS_K[1::step], FRICTIONS_N[::step], AMPLITUDES_V[: 3 - step + 1]
    ):
        wire = {"r_phase_shift_k": shift, "temperature_shift_k": warmer}
        label = f"R-phase {shift:+.1f} K, all {warmer:+.0f} K, friction {friction:.2f} N, {amplitude:.2f} V"
        yield label, Trial(amplitude, wire=wire, bench={"guide_friction_n": friction})


def with_one_more(name: str, value: float, *, thin: bool) -> TriedSet:
    """Return the best that a value of one number more can do, whatever the R-phase shift, with full stroke."""

    def found(shift: float) -> TriedSet:
        rows = sweep(Trial(AMPLITUDE_V, wire={"r_phase_shift_k": shift}, alloy={name: value}))
        return distance(rows), f"{name} {value:.4g}, R-phase {shift:+.2f} K", rows

    coarse = {shift: found(shift) for shift in R_PHASE_SHIFTS_K[:: 3 if thin else 2]}
    centre = min(coarse, key=lambda shift: coarse[shift][0])
    best = coarse[centre]
    for step in (1.5, 0.75) if thin else (1.5, 0.75, 0.4, 0.2):
        for shift in (centre - step, centre + step):
            tried = found(shift)
            if tried[0] < best[0]:
                best, centre = tried, shift
    return best


def judged(sets: Iterable[tuple[str, Trial]]) -> list[TriedSet]:
    """Return how far each set is from the bars, its label and its rows, the nearest first."""
    found = []
    for label, trial in sets:
        rows = sweep(trial)
        found.append((distance(rows), label, rows))
    return sorted(found, key=lambda item: item[0])


def with_smallest_gap_at_paper(start: Trial, barrier_shift_k: float) -> Trial:
    """Return the spool of a barrier shift with the R-phase shift that puts its smallest gap at 0.71 N, to 0.02 K."""

    def trial_at(shift: float) -> Trial:
        shifts = {"r_phase_shift_k": shift, "martensite_barrier_shift_k": barrier_shift_k}
        return replace(start, wire={**start.wire, **shifts})

    # The lower the R-phase's temperature, the lower the pretension that closes its window: the place falls with it.
    low, high = -barrier_shift_k - 4.0, -barrier_shift_k + 3.0
    while high - low > 0.02:
        middle = 0.5 * (low + high)
        if smallest_gap_place_n(sweep(trial_at(middle), PLACES_N)) < PAPER_N:
            low = middle
        else:
            high = middle
    return trial_at(round(0.5 * (low + high), 2))


def fitted(start: Trial, *, seeds: int) -> Trial:
    """Return the spool whose least gap is at 0.71 N and, as read by the instruments, the paper's.

    Two numbers for two, one inside the other: the R-phase shift puts the least gap at its place for each barrier shift,
    and the wider the hysteresis, the larger the gap there. The seeds are always the same, so that noise does not make
    the search restless.
    """
    low, high = BARRIER_SHIFTS_K
    while high - low > BARRIER_STEP_K:
        middle = 0.5 * (low + high)
        path = slow_path(with_smallest_gap_at_paper(start, middle), PAPER_N, time_step_s=0.005)
        read = np.mean([read_gap_pct(path, seed) for seed in range(1, seeds + 1)])
        low, high = (middle, high) if read < PAPER_PCT else (low, middle)
    return with_smallest_gap_at_paper(start, round(0.5 * (low + high), 2))
