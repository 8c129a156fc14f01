"""The numbers in docs/explanation/turns_and_minor_loops.md: those that studies/isobar_branches.py prints."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from parameter_page import paragraphs, table
from studies.isobar_branches import (
    CLASSES_APART_K,
    MINOR_LOOP_PA,
    MOVED,
    ONE_CLASS,
    TWO_CLASSES,
    DrivenLoop,
    IsobarReading,
    Rest,
    distances_k,
    driven_loops,
    isobar_readings,
    isobar_with,
    rests_after_turns,
)
from studies.measured_isobars import LEFT

# Parts of the stroke left that the table shows: both tails and the middle.
SHOWN_LEFT = (0.97, 0.50, 0.03)
# Stresses at which one barrier and one linear strain make the measured distance even to within half a kelvin.
EVEN_FROM_MPA = 150.0
# Stress at which the vendor states where its wires' austenite starts.
VENDOR_MPA = 172


def blocks() -> dict[str, str]:
    """Return the text between the page's markers, by their names."""
    readings, rests = isobar_readings(), rests_after_turns()
    return {
        "one_barrier": paragraphs(one_barrier(readings)),
        "ends": paragraphs(ends_text(readings)),
        "classes": paragraphs(what_classes_show(rests)),
        "rests": paragraphs(rests_text(rests)),
        "fig3a": fig3a_table(driven_loops()),
    }


def tables() -> dict[str, str]:
    """Return the tables behind that text, by their names."""
    readings = isobar_readings()
    return {
        "branches": branches_table(readings),
        "ends": ends_table(readings),
        "rests": rests_table(rests_after_turns()),
    }


def branches_table(readings: Sequence[IsobarReading]) -> str:
    """Return the distances of the branches as recorded, and what is left without a linear strain."""
    places = [LEFT.index(part) for part in SHOWN_LEFT]
    rows = [
        [
            f"{each.stress_mpa:.0f} MPa, {each.source}",
            f"{100.0 * each.stroke:.2f}",
            *(f"{each.distances_k[place]:.1f}" for place in places),
            f"{1e6 * each.levelled.per_k:.1f}",
            f"{100.0 * each.levelled.stroke:.2f}",
            f"{each.levelled.barrier_k:.1f} ± {each.levelled.spread_k:.1f}",
        ]
        for each in readings
    ]
    left = [f"{100.0 * part:.0f} % left, K" for part in SHOWN_LEFT]
    header = [
        "isobar",
        "stroke, %",
        *left,
        "linear strain, 1e-6/K",
        "stroke without it, %",
        "half the distance without it, K",
    ]
    return table(header, rows)


def of_source(readings: Sequence[IsobarReading], source: str, from_mpa: float = 0.0) -> list[IsobarReading]:
    """Return the readings of one source from a stress on."""
    return [each for each in readings if each.source == source and each.stress_mpa >= from_mpa]


def extent(values: Sequence[float], digits: int = 1) -> str:
    """Return the smallest and the largest of some values."""
    return f"{min(values):.{digits}f} to {max(values):.{digits}f}"


def one_barrier(readings: Sequence[IsobarReading]) -> str:
    """Return what the distances say of the measured wire and of the simulated one."""
    high, low = of_source(readings, "measured", EVEN_FROM_MPA), of_source(readings, "measured")[:2]
    ours = of_source(readings, "simulated")
    strains = [extent([1e6 * each.levelled.per_k for each in group], 0) for group in (high, low)]
    spreads = [extent([each.levelled.spread_k for each in group]) for group in (high, low)]
    widest, narrowest = max(each.distances_k.max() for each in high), min(each.distances_k.min() for each in high)
    barriers = extent([each.levelled.barrier_k for each in high])
    simulated = extent([each.levelled.barrier_k for each in ours])
    return (
        f"From {EVEN_FROM_MPA:.0f} MPa on a linear strain of {strains[0]}e-6 per kelvin makes the measured half "
        f"distance even: {barriers} K with a deviation of {spreads[0]} K from 97 to 3 % left, where as recorded the "
        f"whole distance falls from {widest:.0f} to {narrowest:.0f} K. At 50 and 100 MPa the strain found is half as "
        f"large ({strains[1]}e-6 per kelvin) and the evenness worse ({spreads[1]} K). The simulated sample's half "
        f"distance is {simulated} K over the five stresses."
    )


def ends_table(readings: Sequence[IsobarReading]) -> str:
    """Return what strain does after the turns at both ends, and how much barriers may spread."""
    rows = [
        [
            f"{each.stress_mpa:.0f} MPa, {each.source}",
            f"{1e6 * each.rate_after_cold_turn_per_k:.0f}",
            f"{1e6 * each.rate_after_hot_turn_per_k:.0f}",
            f"{each.most_spread_of_barriers_k:.1f}",
            f"{each.austenite_start_degc:.0f}",
        ]
        for each in readings
    ]
    header = [
        "isobar",
        "strain after the cold turn, 1e-6/K",
        "after the hot turn, 1e-6/K",
        "spread of barriers at most, K",
        "start of austenite by tangents, °C",
    ]
    return table(header, rows)


def ends_text(readings: Sequence[IsobarReading]) -> str:
    """Return what strain does after the turns at the ends, how much barriers may spread, and where austenite starts."""
    measured, ours = of_source(readings, "measured"), of_source(readings, "simulated")
    cold, hot = (
        [f"{extent([1e6 * rate(each) for each in group], 0)}e-6" for group in (measured, ours)]
        for rate in (lambda each: each.rate_after_cold_turn_per_k, lambda each: each.rate_after_hot_turn_per_k)
    )
    spread = max(each.most_spread_of_barriers_k for each in measured)
    starts = {each.source: each.austenite_start_degc for each in readings if round(each.stress_mpa) == VENDOR_MPA}
    return (
        f"Per kelvin {cold[0]} after the cold turn and {hot[0]} after the hot one (simulated {cold[1]} and {hot[1]}). "
        f"Barriers spread by {spread:.1f} K at most, and at {VENDOR_MPA} MPa austenite starts, by tangents, at "
        f"{starts['measured']:.0f} °C (simulated {starts['simulated']:.0f} °C)."
    )


def rests_text(rests: Sequence[Rest]) -> str:
    """Return over how many kelvin strain rests after turns inside the loop, with one class of barrier and with two."""
    one, two = (
        [[each.kelvin[place] for each in rests if each.classes == classes] for place in range(len(MOVED))]
        for classes in ("one", "two")
    )
    parts = [
        f"by {100.0 * part:.0f} % after {extent(one[place])} K with one class and {extent(two[place])} K with two"
        for place, part in enumerate(MOVED)
    ]
    return f"After turns with 75, 50 and 25 % of the stroke left, both ways, strain has moved {', '.join(parts)}."


def what_classes_show(rests: Sequence[Rest]) -> str:
    """Return what two classes of barrier change in an isobar, and after a turn inside it."""
    one, two = (distances_k(isobar_with(classes)) for classes in (ONE_CLASS, TWO_CLASSES))
    middle = {each.classes: each.kelvin[0] for each in rests if each.branch == "heating" and each.left == 0.5}
    return (
        f"Half of the simulated sample's grains given a barrier {CLASSES_APART_K:g} K lower, the other half one "
        f"{CLASSES_APART_K:g} K higher, the distance of the branches at {1e-6 * MINOR_LOOP_PA:.0f} MPa moves by "
        f"at most {np.abs(two - one).max():.1f} K at any part of the stroke. After a turn half way up, though, "
        f"strain is at rest over {middle['two']:.1f} K in place of {middle['one']:.1f} K."
    )


def rests_table(rests: Sequence[Rest]) -> str:
    """Return over how many kelvin strain rests after turns inside the loop, with one class and with two."""
    turns = list(dict.fromkeys((each.branch, each.left) for each in rests))
    found = {(each.classes, each.branch, each.left): each.kelvin for each in rests}
    rows = [
        [
            f"on {branch}, {100.0 * left:.0f} % of the stroke left",
            *(
                f"{found[classes, branch, left][place]:.1f}"
                for classes in ("one", "two")
                for place in range(len(MOVED))
            ),
        ]
        for branch, left in turns
    ]
    header = [f"{words}: moved by {100.0 * part:.0f} %, K" for words in ("one class", "two classes") for part in MOVED]
    return table(["turn", *header], rows)


def fig3a_table(loops: Sequence[DrivenLoop]) -> str:
    """Return what the loops of Fig. 3(a) do at their three amplitudes."""
    rows = [
        [
            f"{loop.amplitude_v:.2f} V",
            f"{100.0 * loop.stroke:.2f} %",
            f"{100.0 * loop.outside:.3f} %",
            f"{loop.rest_k:.1f} K of {loop.whole_k:.0f} K",
        ]
        for loop in loops
    ]
    return table(["amplitude", "stroke", "strain outside the major loop, at most", "rest after the hot turn"], rows)
