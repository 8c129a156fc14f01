"""The population of the benchmark: a seed makes a wire, its pretension and what it is mounted on.

Nobody who estimates or controls sees these numbers: a user of such a wire knows what its spool is called, what the
bench states, and what the instruments show.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import NamedTuple, TypeVar

import numpy as np

from musclewire import CallerError, FloatArray, load_alloy, load_bench, load_wire
from musclewire.extras.studies import (
    NormalMixture,
    WireAgeing,
    WireStructure,
    mixture_distribution,
)
from musclewire.parameters import Alloy, Bench, Wire, require_seed
from musclewire.wire import BarrierClass
from musclewire_robustness.settings import BaseWire, StructureSpread, settings

# A normal distribution is cut off at this many standard deviations.
CUT_OFF = 2.0
# Keeps the numbers of a wire apart from the noise of its instruments, which has the same seed.
STREAM = 14
Group = TypeVar("Group", Alloy, Wire, Bench)


class PopulationWire(NamedTuple):
    """A wire of the population.

    Parameters
    ----------
    seed
        The seed that made it.
    base
        Name of the wire that its user believes to have.
    structure
        Its segments, grains, classes of barrier and ageing, none of which a model of its user has.
    alloy
        Its true alloy.
    wire
        Its true numbers.
    bench
        The true numbers of its bench.
    """

    seed: int
    base: str
    structure: WireStructure
    alloy: Alloy
    wire: Wire
    bench: Bench

    @property
    def segments(self) -> int:
        """Number of its axial segments: 1, or 10 and more."""
        return self.structure.n_segments

    @property
    def name(self) -> str:
        """Name in tables: the seed, what it is called, and its segments if it has several."""
        return f"{self.seed} {self.base}" + (f" x{self.segments}" if self.segments > 1 else "")


def held_out_seeds() -> tuple[int, ...]:
    """Return the seeds that the benchmark reports, which nobody tunes on."""
    return tuple(settings().population.held_out_seeds)


def tuning_seeds() -> tuple[int, ...]:
    """Return the seeds that are for tuning."""
    return tuple(settings().population.tuning_seeds)


@cache
def drawn_wire(seed: int) -> PopulationWire:
    """Return the wire that a seed makes; the same seed makes the same wire.

    Diameters and numbers of segments follow each other, so that six seeds in a row hold each diameter with and without
    segments; everything else is drawn.

    Parameters
    ----------
    seed
        Whole number of 0 or more.

    Returns
    -------
    The wire.

    Raises
    ------
    CallerError
        For another seed.
    """
    known = settings().population
    base = known.base[require_seed(seed) % len(known.base)]
    generator = np.random.default_rng([STREAM, seed])
    wire = changed(load_wire(base.wire), drawn(generator, known.wire_std, load_wire(base.wire).values(), base))
    alloy = load_alloy(wire.alloy)
    alloy = changed(alloy, drawn(generator, known.alloy_std, alloy.values(), base))
    bench = load_bench("paper")
    mounted = drawn(generator, known.bench_std, bench.values(), base)
    mounted["pretension_n"] = base.pretension_n * known.pretension_ratios[seed % len(known.pretension_ratios)]
    structure = drawn_structure(generator, known.structure, known.segments if seed % 2 else 1)
    return PopulationWire(seed, base.wire, structure, alloy, wire, changed(bench, mounted))


def drawn_structure(generator: np.random.Generator, spread: StructureSpread, segments: int) -> WireStructure:
    """Return drawn grains, classes of barrier and ageing, and what differs along the wire."""

    def normal(number: int) -> FloatArray:
        return np.clip(generator.standard_normal(number), -CUT_OFF, CUT_OFF)

    grains = np.array(spread.grains) + np.array(spread.grains_std) * normal(3 * len(spread.grains)).reshape(-1, 3)
    weights = grains[:, 0] / grains[:, 0].sum()
    barriers_k = np.array(spread.barriers_k) * (1.0 + spread.barriers_std * normal(len(spread.barriers_k)))
    shifts_k, factors = spread.segment_temperature_k * normal(segments), spread.segment_convection * normal(segments)
    return WireStructure(
        n_segments=segments,
        clamped=segments > 1,
        temperature_shifts_k=tuple(shifts_k.tolist()) if segments > 1 else (),
        convection_factors=tuple((1.0 + factors).tolist()) if segments > 1 else (),
        classes=tuple(BarrierClass(w, b) for w, b in zip(spread.barrier_weights, barriers_k.tolist(), strict=True)),
        grains=mixture_distribution(
            [NormalMixture(float(w), float(m), float(d)) for w, (_, m, d) in zip(weights, grains, strict=True)]
        ),
        ageing=WireAgeing(**spread.ageing),
    )


def drawn(
    generator: np.random.Generator, spreads: Mapping[str, str], nominal: Mapping[str, float], base: BaseWire
) -> dict[str, float]:
    """Return drawn numbers by name; a spread is relative, as "3 %", or absolute, as "5"."""
    found: dict[str, float] = {}
    for name, spread in spreads.items():
        if name not in nominal:
            raise CallerError(
                f"robustness: the population of {base.wire} spreads '{name}', which no wire has: leave it out"
            )
        normal = float(np.clip(generator.standard_normal(), -CUT_OFF, CUT_OFF))
        relative = spread.endswith("%")
        size = float(spread.rstrip("% ")) * (0.01 * abs(nominal[name]) if relative else 1.0)
        found[name] = nominal[name] + normal * size
    return found


def changed(group: Group, numbers: Mapping[str, float]) -> Group:
    """Return an alloy, wire or bench with some other numbers."""
    update = {
        name: getattr(group, name).model_copy(update={"value": number, "kind": "assumed", "note": "drawn"})
        for name, number in numbers.items()
    }
    return group.model_copy(update=update)
