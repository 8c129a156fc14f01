"""What changes around a wire while a run lasts: a condition of the table as a function of the rig's time."""

from __future__ import annotations

import numpy as np

from musclewire.extras.studies._robustness.population import PopulationWire
from musclewire.extras.studies._robustness.settings import Condition, RunSettings
from musclewire.extras.studies._segmented.conditions import Conditions, LocalDraughts, steady

AS_CHARACTERISED = Condition(name="as characterised", bar="none")


class Disturbance:
    """A condition over time: it is there as far as a ramp says, which begins when ``change_at`` has said so.

    Parameters
    ----------
    wire
        The wire; its pretension is what fractions of a load refer to.
    condition
        What changes.
    run
        Times of a run.
    """

    def __init__(self, wire: PopulationWire, condition: Condition, run: RunSettings) -> None:
        """Begin with nothing changed, but for what has drifted before a home move."""
        self._condition, self._run = condition, run
        self._ambient_k = wire.bench.ambient_temperature_k.value
        self._pretension_n = wire.bench.pretension_n.value
        self._change_at_s: float | None = None
        self._draughts: LocalDraughts | None = None
        if condition.draughts:
            number = wire.structure.n_segments
            self._draughts = LocalDraughts(steady(), number, strength=condition.draughts, seed=wire.seed)

    def change_at(self, time_s: float) -> None:
        """Let the change begin at a time on the rig's clock [s]."""
        self._change_at_s = time_s

    def level(self, time_s: float) -> float:
        """Return how much of a change during the run is there at a time [s], from 0 to 1."""
        if self._change_at_s is None:
            return 0.0
        duration_s = self._run.drift_s if self._condition.drift else self._run.ramp_s
        return min(max((time_s - self._change_at_s) / duration_s, 0.0), 1.0)

    def drift_level(self, time_s: float) -> float:
        """Return how much of what can drift is there: all of it from the beginning in rows with a home move."""
        return 1.0 if self._condition.home else self.level(time_s)

    def lead_ohm(self, time_s: float) -> float:
        """Return the resistance of the leads at a time [s]."""
        return self._condition.lead_ohm * self.drift_level(time_s)

    def ambient_k(self, time_s: float) -> float:
        """Return the temperature of the air at a time [K]."""
        return self._ambient_k + self.drift_level(time_s) * self._condition.ambient_k

    def __call__(self, time_s: float) -> Conditions:
        """Return what is around the wire at a time on the rig's clock [s]."""
        condition, level, drifted = self._condition, self.level(time_s), self.drift_level(time_s)
        convection = condition.convection_factor**drifted
        along = np.asarray(convection)
        if self._draughts is not None:
            along = convection * (1.0 + level * (np.asarray(self._draughts(time_s).convection_factor) - 1.0))
        return Conditions(
            ambient_k=self.ambient_k(time_s),
            convection_factor=along,
            load_force_n=level * condition.load_fraction * self._pretension_n,
            stiffness_factor=condition.stiffness_factor**level,
            pretension_force_n=level * condition.pretension_fraction * self._pretension_n,
            resistance_factor=1.0 + drifted * (condition.resistance_factor - 1.0),
            transformation_shift_k=drifted * condition.transformation_shift_k,
        )
