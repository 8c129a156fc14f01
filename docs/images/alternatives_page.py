"""What fits predict that did not see all, and what published values cost: in text for a page, in tables for the site.

The fits are those of studies/alternative_fits.py; their numbers follow from the vectors in studies/vectors.
"""

from __future__ import annotations

import sys
from pathlib import Path

from parameter_page import paragraphs, table

sys.path.insert(0, str(Path(__file__).parents[2] / "studies"))

from alternative_fits import FITS, FloatArray, cost, predictions, read, shipped_vector, targets

NOT_SEARCHED = "not searched yet"
# Tolerances by which some search misses a target that the page names; studies/alternative_fits.py prints them all.
SHOWN_FROM = 2.0


def block() -> str:
    """Return how many predictions hold and what holding parameters inside costs, as text."""
    judged = [
        (name, row)
        for name, fit in FITS.items()
        if fit.held_out is not None and (vector := read(name)) is not None
        for row in predictions(vector, fit.held_out)
        if row.verdict
    ]
    failing = [
        f"{row.what} ({name}: {row.ours:.2f} for {row.measured:.2f})"
        for name, row in judged
        if row.verdict.lower() != "holds"
    ]
    vectors = {name: read(name) for name, fit in FITS.items() if fit.held_out is None}
    inside = ", ".join(f"{met(targets(vector))} with {name}" for name, vector in vectors.items() if vector is not None)
    return paragraphs(
        f"Of {len(judged)} predictions {len(judged) - len(failing)} hold; those that fail are {'; '.join(failing)}. "
        f"Targets met: {met(targets(shipped_vector()))} as shipped, {inside}."
    )


def held_out_table() -> str:
    """Return what each fit predicts of what it did not see and is judged by, next to what was measured."""
    rows = []
    for name, fit in FITS.items():
        if fit.held_out is None:
            continue
        vector = read(name)
        if vector is None:
            rows.append([name, NOT_SEARCHED, "", "", ""])
            continue
        for row in predictions(vector, fit.held_out):
            if row.verdict:
                numbers = [f"{row.ours:.2f}", f"{row.measured:.2f}", f"{row.tolerance:g}"]
                rows.append([name, row.what, *numbers, row.verdict.lower()])
    rows = [[*row, *[""] * (6 - len(row))] for row in rows]
    return table(["search", "predicted, not seen", "predicted", "measured", "may differ by", "verdict"], rows)


def held_inside_table() -> str:
    """Return the targets that the shipped set or a fit held inside misses by much, in tolerances; a dash if met."""
    vectors: dict[str, FloatArray | None] = {"shipped": shipped_vector()}
    vectors |= {name: read(name) for name, fit in FITS.items() if fit.held_out is None}
    off = {name: targets(vector) for name, vector in vectors.items() if vector is not None}
    missed = [key for key in off["shipped"] if any(abs(each[key]) >= SHOWN_FROM for each in off.values())]
    rows = [["cost", *(price(vector) for vector in vectors.values())]]
    rows.append(["targets met", *(met(off.get(name)) for name in vectors)])
    rows += [[f"`{key}`", *(tolerances(off.get(name), key) for name in vectors)] for key in missed]
    return table(["missed by how many tolerances", *vectors], rows)


def price(vector: FloatArray | None) -> str:
    """Return what the search makes small, of a vector."""
    return NOT_SEARCHED if vector is None else f"{cost(vector):.0f}"


def met(off: dict[str, float] | None) -> str:
    """Return how many targets are met."""
    return "" if off is None else f"{sum(abs(value) <= 1.0 for value in off.values())} of {len(off)}"


def tolerances(off: dict[str, float] | None, key: str) -> str:
    """Return by how many tolerances a target is missed; a dash where it is met."""
    if off is None:
        return ""
    return f"{off[key]:+.1f}" if abs(off[key]) > 1.0 else "–"
