"""What several explanations say together: their evidence, and value and standard deviation that follow from it.

Multiple models, one filter each: Magill 1965, doi 10.1109/TAC.1965.1098191.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.extras.calibration._particles._settings import ParticleSettings


class ExplanationEstimate(NamedTuple):
    """Value and standard deviation of the quantity by one explanation."""

    value: float
    std: float


def after_sample(
    evidence: Sequence[float], gained: Sequence[float], duration_s: float, settings: ParticleSettings
) -> tuple[float, ...]:
    """Return the evidence for each explanation after a sample: a sum of logarithms that forgets what is long ago."""
    kept = 1.0 - min(duration_s / settings.evidence_time_s, 1.0)
    return tuple(
        kept * before + max(new, -settings.worst_surprise) for before, new in zip(evidence, gained, strict=True)
    )


def weights_of(evidence: Sequence[float], cost: float, softness: float) -> FloatArray:
    """Return the weights of explanations, (n_explanations,); all but the first have to be better by ``cost``."""
    score = (np.array(evidence) - np.array([0.0, *[cost] * (len(evidence) - 1)])) / softness
    weight = np.exp(score - score.max())
    return np.asarray(weight / weight.sum())


def combined_estimate(
    opinions: Sequence[ExplanationEstimate], evidence: Sequence[float], settings: ParticleSettings
) -> ExplanationEstimate:
    """Return the value by the explanations' weights, and a deviation that doubts these: few samples are independent."""
    weight = weights_of(evidence, settings.load_cost, 1.0)
    value = sum(part * opinion.value for part, opinion in zip(weight, opinions, strict=True))
    doubted = weights_of(evidence, 0.5 * settings.load_cost, settings.softness)
    variance = sum(
        part * (opinion.std**2 + (opinion.value - value) ** 2) for part, opinion in zip(doubted, opinions, strict=True)
    )
    return ExplanationEstimate(float(value), math.sqrt(variance))
