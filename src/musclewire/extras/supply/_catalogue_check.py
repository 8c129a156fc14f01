"""The test of the vendor's catalogue on a simulated wire: contraction after one second, then cooling in still air.

The test according to the catalogue's footnotes: a wire under 172 MPa is heated for one second by the catalogue's
current and cools in still air; the last 0.5 % of deformation is not counted. Here a deformation of 0.5 % is a strain of
0.005, and the wire counts as cold within that strain of its cold length under the same load. The wire starts cold, at
rest, at the bench's ambient temperature.

Limits of acceptance apply to 70 C wire of 0.05 to 0.31 mm if the catalogue's cell itself is corroborated: that of the
current for contraction, that of the cooling time for cooling. All other numbers are shown without a verdict.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import NumericsError
from musclewire.extras.supply._one_second import heat
from musclewire.parameters import (
    CLASSES,
    Alloy,
    Bench,
    CatalogueCell,
    CatalogueRow,
    Wire,
    load_alloy,
    load_bench,
    load_catalogue,
    load_wire,
)
from musclewire.wire import WireConstants, WireState, constants_from, drive_path, isobaric_path

PULL_STRESS_PA = 172e6
HEATING_S = 1.0
UNCOUNTED_STRAIN = 0.005
HOTTEST_K = 493.15  # [K] at which no wire under this load has martensite left
STROKE_POINTS = 100  # temperatures up to it, of whose contractions the largest is the stroke
# Thin wires cool fast: a step is this fraction of the thermal time constant without transformation.
STEP_FRACTION = 0.02
MIN_STEP_S = 5e-4  # [s], bounds of that step
MAX_STEP_S = 5e-3
COOLING_CHUNKS = 200  # steps of the cooling that are simulated before its end is looked for
MAX_COOLING_S = 120.0  # [s] of cooling at most


class CatalogueRun(NamedTuple):
    """Result of the catalogue's test of one wire; contractions are fractions of the cold length under the load."""

    stroke: float
    contraction: float
    contraction_fraction: float
    # None if the wire never contracted beyond the part that is not counted, or is not cold after 120 s.
    cooling_s: float | None
    temperature_k: float
    energy_j: float


def dead_weight_bench(bench: Bench, diameter_m: float, stress_pa: float = PULL_STRESS_PA) -> Bench:
    """Return a bench with a weight that loads a wire by a stress: one leg, no spring and no friction."""
    weight_n = float(stress_pa * 0.25 * np.pi * diameter_m**2)
    return bench.with_values(legs=1.0, spring_stiffness_n_per_m=0.0, guide_friction_n=0.0, pretension_n=weight_n)


def run_catalogue_test(alloy: Alloy, wire: Wire, bench: Bench, current_a: float) -> CatalogueRun:
    """Heat a wire under a dead weight by a constant current for a second, let it cool; measure both."""
    constants = constants_from(alloy, wire, dead_weight_bench(bench, wire.diameter_m.value))
    loss = constants.convection_factor * constants.surface_m2 * float(constants.convection_table_w_per_m2_k[80])
    step_s = float(np.clip(STEP_FRACTION * constants.heat_capacity_j_per_k / loss, MIN_STEP_S, MAX_STEP_S))
    heated, state = heat(constants, current_a, HEATING_S, step_s)
    contraction = state.contraction
    if not np.isfinite(contraction):
        raise NumericsError(f"the simulation of {wire.name} diverges at {current_a:g} A: use a smaller current")
    stroke = full_stroke(constants, PULL_STRESS_PA)
    curve = cooling_curve(constants, state, step_s)
    return CatalogueRun(
        stroke=stroke,
        contraction=contraction,
        contraction_fraction=contraction / stroke,
        cooling_s=time_below(curve, step_s, contraction, UNCOUNTED_STRAIN),
        temperature_k=float(heated.temperature_k.max()),
        energy_j=state.heat_in_j,
    )


def full_stroke(constants: WireConstants, stress_pa: float) -> float:
    """Return the largest contraction of the wire under this stress over a complete transformation."""
    kelvin = np.linspace(constants.ambient_temperature_k, HOTTEST_K, STROKE_POINTS)
    path = isobaric_path(constants, stress_pa, kelvin)
    return float((constants.cold_strain - path.strain.min()) / (1.0 + constants.cold_strain))


def cooling_curve(constants: WireConstants, state: WireState, step_s: float) -> FloatArray:
    """Return the contraction after switching off, (n,), to a hundredth of what is not counted or for 120 s."""
    pieces: list[FloatArray] = []
    off = np.zeros(COOLING_CHUNKS)
    for _ in range(int(MAX_COOLING_S / (COOLING_CHUNKS * step_s)) + 1):
        path, state = drive_path(constants, off, sample_s=step_s, state=state)
        pieces.append(path.displacement_m / constants.leg_length_m)
        if state.contraction < 0.01 * UNCOUNTED_STRAIN:
            break
    return np.concatenate(pieces)


def time_below(curve: FloatArray, step_s: float, start: float, level: float) -> float | None:
    """Return when a falling curve, given at the ends of steps, passes a level; None if it does not."""
    if start <= level:
        return None
    below = np.flatnonzero(curve <= level)
    if below.size == 0:
        return None
    after = int(below[0])
    before = start if after == 0 else float(curve[after - 1])
    return step_s * (after + (before - level) / (before - float(curve[after])))


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
            compared.append(compared_with_row(name, row, wire_class, run))
    return compared


def compared_with_row(name: str, row: CatalogueRow, wire_class: str, run: CatalogueRun) -> CatalogueComparison:
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
