"""What a particle filter takes for possible: what may change, how far, how often, and how well its wire fits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError

# What may differ from the wire file, in the order of every array of unknowns. Convection, stiffness and resistance are
# logarithms of a factor, ambient and transformation temperature differences [K], load a force over the pretension.
UNKNOWNS = ("convection", "ambient", "load", "stiffness", "resistance", "transformation")
# What may have changed in each explanation: a filter of its own follows each, so that none is lost to a better one.
EXPLANATIONS: Mapping[str, tuple[str, ...]] = {
    "air": ("convection", "ambient"),
    "load": ("load", "stiffness"),
    "both": ("convection", "ambient", "load", "stiffness"),
}


@dataclass(frozen=True)
class ParticleSettings:
    """Numbers of a particle filter; one set holds for every wire (tuned on seeds 1 to 8 of ``musclewire robustness``).

    Each hypothesis says which unknowns have changed. One that has not changed keeps within ``spread_at_rest``, what a
    calibration leaves open; one that has is drawn from ``spread_changed``, and explains the resistance only if nothing
    simpler does: most hypotheses change one unknown at a time. Raises CallerError for numbers that leave nothing to
    weigh.
    """

    hypotheses: int = 150  # of each explanation; fewer lose a change more often, more cost time
    # Standard deviation of each unknown that has changed, in the order of ``UNKNOWNS``; 0 if it never does.
    spread_changed: tuple[float, ...] = (0.7, 10.0, 0.35, 0.5, 0.0, 0.0)
    spread_at_rest: tuple[float, ...] = (0.05, 1.5, 0.03, 0.05, 0.0, 0.0)  # the same of each that has not
    # How often a new hypothesis is of each unknown, adding up to 1; an explanation takes those of its unknowns.
    chance: tuple[float, ...] = (0.25, 0.25, 0.3, 0.2, 0.0, 0.0)
    resistance_error: float = 0.0012  # how well the calibrated wire reproduces its resistance, as a fraction
    error_time_s: float = 0.3  # time for which that error stays alike: samples within it count as one
    renewed: float = 0.1  # fraction of the hypotheses that are drawn again at each resampling
    renewed_when_lost: float = 0.3  # the same while no hypothesis explains the resistance
    # Misfit of the resistance, over what wire and noise explain, from which hypotheses are lost.
    lost_misfit: float = 1.0
    wandering: float = 0.05  # deviation of what a changed unknown wanders by at a resampling, over ``spread_changed``
    # Hypotheses per sample that start from an older snapshot and are run through what was measured since.
    restarts: int = 4
    restart_time_s: float = 5.0  # age at which a snapshot begins to be used; it is used until twice that age
    snapshot: int = 50  # number of wires in it
    # Deviation of the calibrated wire's strain at its own resistance, over the model's range.
    structural_strain: float = 0.003
    evidence_time_s: float = 15.0  # time over which the evidence for each explanation is gathered
    load_cost: float = 8.0  # by how much an explanation with a changed load must be better, in logarithm of likelihood
    worst_surprise: float = 0.5  # a sample counts no worse against an explanation than this, in logarithm of likelihood
    # The standard deviation sees explanations that are worse by so much as possible; so does no value.
    softness: float = 4.0
    largest_std: float = 0.022  # over the model's range, from which a value is not valid
    seed: int = 1

    def __post_init__(self) -> None:
        """Check the numbers."""
        rows = (self.spread_changed, self.spread_at_rest, self.chance)
        if any(len(row) != len(UNKNOWNS) or min(row) < 0.0 for row in rows):
            raise CallerError(f"a particle filter needs {len(UNKNOWNS)} numbers of 0 or more for {', '.join(UNKNOWNS)}")
        if abs(sum(self.chance) - 1.0) > 1e-9:
            raise CallerError(f"the chances of the unknowns add up to {sum(self.chance):g}: they must add up to 1")
        positive = (
            self.hypotheses - 9,
            self.snapshot,
            self.restart_time_s,
            self.resistance_error,
            self.error_time_s,
            self.structural_strain,
            self.evidence_time_s,
            self.softness,
            self.largest_std,
        )
        if not min(positive) > 0.0:
            raise CallerError(f"a particle filter needs 10 hypotheses or more, and errors and times above 0: {self}")

    def tables(self, explanation: str) -> FloatArray:
        """Return the three rows of the unknowns for an explanation as one table, (3, n_unknowns)."""
        possible = np.array([name in EXPLANATIONS[explanation] for name in UNKNOWNS])
        chance = possible * np.array(self.chance)
        return np.array([self.spread_changed, self.spread_at_rest, chance / chance.sum()])
