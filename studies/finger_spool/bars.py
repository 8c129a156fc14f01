"""What the paper says of the finger's displacement gap, as bars that a sweep over pretensions meets or not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from finger_spool.loops import LoopRow, Trial, row_of, slow_path

# Figs. 16 and 17 show pretensions from a slack wire to a little beyond 0.71 N; the rest asks what happens further on.
PRETENSIONS_N = (0.15, 0.25, 0.40, 0.55, 0.63, 0.71, 0.79, 0.87, 1.00, 1.30, 1.60, 1.90)
PAPER_N, PAPER_PCT = 0.71, 2.271
PLACE_TOLERANCE_N, GAP_TOLERANCE_PCT = 0.15, 0.7
MIN_STROKE_PCT, MIN_ENDPOINT_M = 3.1, 6e-3
# A minimum that stands out less than this at either end of the sweep is a flat curve under the noise of a recording.
MIN_RISE_PCT = 0.25
# Branches without an intersection have a signed gap as large as the gap, but for where resistance turns.
NO_CROSSING_FRACTION = 0.95


@dataclass(frozen=True)
class Bars:
    """Which bars a sweep meets.

    The gap falls with pretension (``falls``) to a least value near the paper's pretension (``place``), near the paper's
    (``gap``); it grows beyond, where the branches that met before meet no more (``parts``); the finger gets there
    (``stroke``).
    """

    falls: bool
    place: bool
    gap: bool
    parts: bool
    stroke: bool

    @property
    def met(self) -> int:
        """How many are met."""
        return sum(bool(getattr(self, item.name)) for item in fields(self))

    def __str__(self) -> str:
        """Name every bar with yes or no."""
        return ", ".join(f"{item.name} {'yes' if getattr(self, item.name) else 'NO'}" for item in fields(self))


def sweep(trial: Trial, pretensions_n: Sequence[float] = PRETENSIONS_N, *, time_step_s: float = 0.025) -> list[LoopRow]:
    """Return the rows of a spool over pretensions, noise-free; the coarse steps err by about 0.01 points of gap."""
    return [row_of(slow_path(trial, force, time_step_s=time_step_s), force) for force in pretensions_n]


def bars(rows: Sequence[LoopRow]) -> Bars:
    """Judge a sweep that has a row at 0.71 N."""
    gaps = np.array([row.gap_pct for row in rows])
    least = int(np.argmin(gaps))
    paper = at_paper(rows)
    return Bars(
        falls=bool(np.all(np.diff(gaps[: least + 1]) < 0.0)) and gaps[0] - gaps[least] > MIN_RISE_PCT,
        place=abs(rows[least].pretension_n - PAPER_N) <= PLACE_TOLERANCE_N + 1e-9,
        gap=abs(paper.gap_pct - PAPER_PCT) <= GAP_TOLERANCE_PCT,
        parts=gaps[-1] - gaps[least] > MIN_RISE_PCT and not crosses(rows[-1]) and crosses(paper),
        stroke=paper.stroke_pct >= MIN_STROKE_PCT and paper.endpoint_m >= MIN_ENDPOINT_M,
    )


def crosses(row: LoopRow) -> bool:
    """Return whether heating and cooling branch intersect: parts of the gap of either sign cancel."""
    return abs(row.signed_gap_pct) < NO_CROSSING_FRACTION * row.gap_pct


def stands_out_pct(rows: Sequence[LoopRow]) -> float:
    """Return by how much the lower end of a sweep lies above its least gap: what noise must not hide."""
    gaps = [row.gap_pct for row in rows]
    return min(gaps[0], gaps[-1]) - min(gaps)


def at_paper(rows: Sequence[LoopRow]) -> LoopRow:
    """Return the row at the paper's pretension."""
    return min(rows, key=lambda row: abs(row.pretension_n - PAPER_N))


def smallest_gap_place_n(rows: Sequence[LoopRow]) -> float:
    """Return the pretension of the smallest gap [N], by the parabola through its row and the neighbours."""
    gaps = np.array([row.gap_pct for row in rows])
    middle = int(np.clip(np.argmin(gaps), 1, len(rows) - 2))
    around = slice(middle - 1, middle + 2)
    forces = np.array([row.pretension_n for row in rows])[around]
    square, linear, _ = np.polyfit(forces, gaps[around], 2)
    return float(np.clip(-linear / (2.0 * square), forces[0], forces[-1])) if square > 0.0 else forces[1]


def distance(rows: Sequence[LoopRow]) -> float:
    """Return how far a sweep is from the bars, for ranking: 1 for every bar missed and a little for how far."""
    gaps = np.array([row.gap_pct for row in rows])
    least = int(np.argmin(gaps))
    off = abs(at_paper(rows).gap_pct - PAPER_PCT) + abs(rows[least].pretension_n - PAPER_N)
    return 5.0 - bars(rows).met + 0.2 * off
