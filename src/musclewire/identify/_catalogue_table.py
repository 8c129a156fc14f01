"""The simulated wires compared with the vendor's catalogue, size by size, with acceptance limits.

Limits apply to 70 C wire of 0.05 to 0.31 mm if the cell itself is corroborated: that of the current for contraction,
that of the cooling time for cooling. All other numbers are shown without a verdict.
"""

from __future__ import annotations

from typing import NamedTuple

from musclewire.identify._catalogue_check import CatalogueRun, run_catalogue_test
from musclewire.parameters import (
    CLASSES,
    CatalogueCell,
    CatalogueRow,
    load_alloy,
    load_bench,
    load_catalogue,
    load_wire,
)

JUDGED_CLASS = "lt"
JUDGED_SIZES_MM = (0.05, 0.31)
CONTRACTION_RANGE = (0.8, 1.0)
COOLING_TOLERANCE = 0.35
# A complete contraction must not fail by rounding.
ROUNDING = 1e-3
BARS = (
    f"contraction {100 * CONTRACTION_RANGE[0]:.0f} to {100 * CONTRACTION_RANGE[1]:.0f} % of stroke, cooling within "
    f"{100 * COOLING_TOLERANCE:.0f} %; judged: {CLASSES[JUDGED_CLASS]}, {JUDGED_SIZES_MM[0]} to {JUDGED_SIZES_MM[1]} "
    "mm, corroborated cells"
)


class JudgedValue(NamedTuple):
    """One simulated number next to the catalogue's; ``ok`` is None if no limit applies to it."""

    ours: float | None
    low: float
    high: float
    cell: CatalogueCell
    ok: bool | None


class CatalogueComparison(NamedTuple):
    """One wire of the catalogue: its simulated test and the verdicts."""

    wire: str
    row: CatalogueRow
    wire_class: str
    run: CatalogueRun
    contraction: JudgedValue
    cooling: JudgedValue

    @property
    def ok(self) -> bool:
        """Whether all numbers with limits are within them."""
        return self.contraction.ok is not False and self.cooling.ok is not False


def compare_catalogue() -> list[CatalogueComparison]:
    """Return the vendor's test of all wires of the catalogue, thinnest first, LT before HT; deterministic."""
    alloy, bench = load_alloy(load_catalogue().wire.alloy), load_bench("dead-weight")
    compared = []
    for row in load_catalogue().row:
        for wire_class in CLASSES:
            name = f"flexinol-{row.name}-{wire_class}"
            run = run_catalogue_test(alloy, load_wire(name), bench, row.current_a)
            compared.append(judged(name, row, wire_class, run))
    return compared


def judged(name: str, row: CatalogueRow, wire_class: str, run: CatalogueRun) -> CatalogueComparison:
    """Return a wire's test with its verdicts."""
    low, high = JUDGED_SIZES_MM
    counts = wire_class == JUDGED_CLASS and low <= row.diameter_mm <= high
    time = row.cooling_cell(wire_class)
    return CatalogueComparison(
        name,
        row,
        wire_class,
        run,
        judged_within(run.contraction_fraction, *CONTRACTION_RANGE, row.current_ma, counts, ROUNDING),
        judged_within(
            run.cooling_s,
            time.value * (1.0 - COOLING_TOLERANCE),
            time.value * (1.0 + COOLING_TOLERANCE),
            time,
            counts,
            0.0,
        ),
    )


def judged_within(
    ours: float | None, low: float, high: float, cell: CatalogueCell, counts: bool, rounding: float
) -> JudgedValue:
    """Return a number with its verdict: None if the cell is not corroborated or the wire has no limits."""
    if not (counts and cell.corroborated):
        return JudgedValue(ours, low, high, cell, None)
    return JudgedValue(ours, low, high, cell, ours is not None and low <= ours <= high + rounding)
