"""Whether a wire's stress and temperature lie within what its alloy's data cover and its vendor allows.

One function decides, :func:`beyond_validity`; every command that heats or recommends prints what it returns, from
the range of stress and the highest temperature of a run, or of one that is planned.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from musclewire.parameters._parameter_groups import Alloy

# Stress counts as beyond a limit from this fraction on: diameters are known to one or two percent.
STRESS_SLACK = 0.02
ZERO_DEGC_K = 273.15


class ValidityLimits(NamedTuple):
    """Limits of an alloy's validity in SI, under the names that recordings state them by; None if unknown."""

    covered_stress_low_pa: float | None = None
    covered_stress_high_pa: float | None = None
    covered_temperature_high_k: float | None = None
    working_stress_pa: float | None = None
    annealing_temperature_k: float | None = None

    @classmethod
    def stated_in(cls, facts: Mapping[str, Any]) -> ValidityLimits:
        """Return the limits that the metadata of a recording state."""
        found = {name: facts.get(name) for name in cls._fields}
        return cls(**{name: float(value) for name, value in found.items() if isinstance(value, (int, float))})

    def facts(self) -> dict[str, float]:
        """Return the known limits for the metadata of a recording."""
        return {name: value for name, value in self._asdict().items() if value is not None}


class ReachedConditions(NamedTuple):
    """What a wire goes through in a run, in SI; None if unknown. ``section_m2`` is that of all legs that pull."""

    cold_stress_pa: float | None = None
    largest_stress_pa: float | None = None
    temperature_k: float | None = None
    section_m2: float | None = None


def validity_of(alloy: Alloy) -> ValidityLimits:
    """Return the limits that an alloy's file states; all are None for a file without the table ``validity``."""
    if alloy.validity is None:
        return ValidityLimits()
    stated = alloy.validity
    return ValidityLimits(
        covered_stress_low_pa=stated.stress.low,
        covered_stress_high_pa=stated.stress.high,
        covered_temperature_high_k=stated.temperature.high,
        working_stress_pa=stated.working_stress.value,
        annealing_temperature_k=stated.annealing_temperature.value,
    )


def section_m2(diameter_m: float, legs: float = 1.0) -> float:
    """Return the section of all legs of a wire."""
    return 0.25 * math.pi * diameter_m**2 * legs


def beyond_validity(limits: ValidityLimits, reached: ReachedConditions) -> tuple[str, ...]:
    """Return a warning for each limit that a wire exceeds, the most dangerous first; none within all of them."""
    found = (*hot_warnings(limits, reached.temperature_k), *stress_warnings(limits, reached))
    return tuple(text for text in found if text)


def hot_warnings(limits: ValidityLimits, temperature_k: float | None) -> tuple[str, ...]:
    """Return a warning of a temperature that anneals the wire, or is above those of the data."""
    if temperature_k is None:
        return ()
    hot = f"the wire reaches {temperature_k - ZERO_DEGC_K:.0f} C"
    annealing_k, covered_k = limits.annealing_temperature_k, limits.covered_temperature_high_k
    if annealing_k is not None and temperature_k > annealing_k:
        return (f"{hot}, above the {annealing_k - ZERO_DEGC_K:.0f} C from which on it may lose memory: drive it less",)
    if covered_k is not None and temperature_k > covered_k:
        return (
            f"{hot}, above the {covered_k - ZERO_DEGC_K:.0f} C up to which the alloy was measured: resistance and "
            "strain beyond it are extrapolated; drive it less to rely on them",
        )
    return ()


def stress_warnings(limits: ValidityLimits, reached: ReachedConditions) -> tuple[str, ...]:
    """Return warnings of stresses above the vendor's, above those of the alloy's data, and below them."""
    low, high, largest = limits.covered_stress_low_pa, limits.covered_stress_high_pa, reached.largest_stress_pa
    found = []
    if exceeds(largest, limits.working_stress_pa):
        found.append(
            f"the wire pulls with up to {in_words(largest, reached)}, above the vendor's "
            f"{in_words(limits.working_stress_pa, reached)} for many cycles: it loses stroke and breaks earlier; less "
            "pretension, a softer load or a thicker wire"
        )
    if exceeds(largest, high):
        found.append(
            f"the wire pulls with up to {in_words(largest, reached)}, above the {in_words(high, reached)} that the "
            "alloy's data cover: stroke, resistance and temperatures there are extrapolated; pull less to rely on them"
        )
    if exceeds(low, reached.cold_stress_pa):
        found.append(
            f"the cold wire is stretched by {in_words(reached.cold_stress_pa, reached)} only, below the "
            f"{in_words(low, reached)} that the alloy's data cover: its stroke there is extrapolated, and a wire that "
            "was never trained may hardly stretch again when it cools; more pretension"
        )
    return tuple(found)


def exceeds(value: float | None, limit: float | None) -> bool:
    """Return whether a stress is above a limit by more than the slack; unknown ones are not."""
    return value is not None and limit is not None and value > limit * (1.0 + STRESS_SLACK)


def in_words(stress_pa: float | None, reached: ReachedConditions) -> str:
    """Return a stress as people write it, with the force on all legs if their section is known."""
    stress_pa = stress_pa or 0.0
    force = "" if reached.section_m2 is None else f" ({stress_pa * reached.section_m2:.2f} N)"
    return f"{stress_pa / 1e6:.0f} MPa{force}"
