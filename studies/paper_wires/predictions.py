"""What a fit predicts of data that it did not see, beside what was measured."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.extras.paper import lowest_place
from musclewire.identify import simulated_isobar, summarize_isobar
from paper_wires.slow_loops import finger_loop, slow_loop
from paper_wires.targets import CHOSEN_FINGER, ISOBARS, PAPER, PRETENSIONS_FINGER_N
from paper_wires.unknowns import FloatArray, PaperWires, paper_wires


class Prediction(NamedTuple):
    """One number: ours, the measured one, and how far apart they may be; 0 for a number that is not judged."""

    what: str
    ours: float
    measured: float
    tolerance: float

    @property
    def verdict(self) -> str:
        """Say whether it holds."""
        if self.tolerance == 0.0:
            return ""
        return "holds" if abs(self.ours - self.measured) <= self.tolerance else "FAILS"


def predictions(vector: FloatArray, held_out: str) -> list[Prediction]:
    """Return the predictions of what was held out: "finger", "125um" or an isobar as "100 MPa"."""
    wires = paper_wires(vector)
    if held_out == "finger":
        return of_finger(wires)
    if held_out == "125um":
        return of_125um(wires)
    return of_isobar(wires, float(held_out.removesuffix(" MPa")))


def of_isobar(wires: PaperWires, mpa: float) -> list[Prediction]:
    """Return stroke and temperatures of an isobar; halves within 4 K, the stroke within 0.3 %."""
    index = ISOBARS["stress_mpa"].index(mpa)
    ours = summarize_isobar(simulated_isobar(wires.alloy, wires.isobar_sample, wires.bench, 1e6 * mpa))
    found = [Prediction(f"stroke at {mpa:g} MPa, %", 100.0 * ours.stroke, ISOBARS["stroke_pct"][index], 0.3)]
    for branch in ("heating", "cooling"):
        degc = np.array(getattr(ours, f"{branch}_k")) - 273.15
        measured = ISOBARS[f"{branch}_degc"][index]
        found += [
            Prediction(f"{share} %, {branch}, C", degc[place], measured[place], tolerance)
            for place, (share, tolerance) in enumerate(((10, 0.0), (50, 4.0), (90, 0.0)))
        ]
    return found


def of_125um(wires: PaperWires) -> list[Prediction]:
    """Return the gap of the 125 um wire at both printed ends; within 1.5 points."""
    printed = PAPER["strain_gap_125um"]
    return [
        Prediction(f"gap at {force:.2f} N, %", slow_loop(wires, "125um", force).strain_gap_pct, gap, 1.5)
        for force, gap in zip(printed["pretension_n"], printed["strain_gap_pct"], strict=True)
    ]


def of_finger(wires: PaperWires) -> list[Prediction]:
    """Return place and size of the finger's least gap, as the rows of Fig. 17 judge them."""
    gaps = [finger_loop(wires, force).strain_gap_pct for force in PRETENSIONS_FINGER_N]
    printed = PAPER["displacement_gap"]
    return [
        Prediction("gap at 0.71 N, %", gaps[CHOSEN_FINGER], printed["displacement_gap_pct"], 0.7),
        Prediction(
            "place of the least gap, N", lowest_place(PRETENSIONS_FINGER_N, gaps), printed["pretension_n"], 0.15
        ),
    ]
