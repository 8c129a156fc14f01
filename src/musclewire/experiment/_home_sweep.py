"""The drive of a home move: heat by a ramp of power until the transformation is done, and cool again.

Power and not voltage rises evenly, because the wire's warming follows power; and the end follows from the resistance,
so that a wire in still or moving, warm or cold air is heated just beyond its transformation and no further.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from musclewire.errors import RigError
from musclewire.experiment._run import Decision
from musclewire.identify import has_levelled
from musclewire.physics import wire_resistance
from musclewire.rigs import Rig
from musclewire.sensing import dropout_failure
from musclewire.signals import Command, Drive, RawSample

# Durations in thermal time constants of the wire: together about 20 s for a thin wire, whose time constant is 0.8 s.
REST_LAGS = 6.0  # cold, before the ramp
UP_LAGS = 12.0  # of the ramp up at most
DOWN_LAGS = 8.0  # of the ramp down
MIN_LAG_S = 0.8
# The ramp goes on to this multiple of the loop's highest power if the wire has not transformed before.
OVERDRIVE = 1.6
BELOW_LIMIT_K = 10.0  # [K] below the protection's limit, up to which the sweep heats by the protection's own estimate
ZERO_CELSIUS_K = 273.15
# The fall must level off, at least this fraction of the loop's fall down: only C itself is a mark.
MIN_DEPTH = 0.85
# Stricter than for a slow loop: in a ramp the temperature lags behind the power.
LEVEL_FRACTION = 0.06
# The course is judged in pieces of this many seconds, whose noise is small.
PIECE_S = 0.2
MAX_DROPOUTS = 10


class SweepPlan(NamedTuple):
    """Powers and times of a sweep."""

    rest_s: float  # at the sense voltage before the sweep, in which a warm wire cools
    up_s: float  # in which the power rises to the loop's highest one
    down_s: float
    loop_power_w: float
    highest_power_w: float  # never exceeded, by the loop's own and by the protection's limit of temperature
    fall_ohm: float  # from B to C in the loop
    limited_by: str  # which limit the highest power is, in words

    @classmethod
    def for_rig(cls, rig: Rig, loop_power_w: float, fall_ohm: float, highest_k: float = inf) -> SweepPlan:
        """Return the plan for a wire on a rig, which by its power stays below a temperature [K], too."""
        limits = rig.protection_limits
        highest_w, because = OVERDRIVE * loop_power_w, f"the power was at {OVERDRIVE:g} times the usual one"
        lag_s = max(MIN_LAG_S, limits.heat.lag_s)
        protected_k = limits.maximum_temperature_k - BELOW_LIMIT_K
        allowed_k = min(protected_k, highest_k)
        thermal_w = limits.heat.power_w(allowed_k)
        if thermal_w < highest_w:
            why = "near the protection's limit" if allowed_k == protected_k else "up to which the alloy was measured"
            highest_w, because = (
                thermal_w,
                f"by its power the wire was at {allowed_k - ZERO_CELSIUS_K:.0f} C, {why}",
            )
        times_s = (REST_LAGS * lag_s, UP_LAGS * lag_s, DOWN_LAGS * lag_s)
        return cls(*times_s, loop_power_w, highest_w, fall_ohm, because)

    @property
    def duration_s(self) -> float:
        """Longest time that the sweep may take [s]."""
        return self.rest_s + OVERDRIVE * self.up_s + self.down_s


class HomeSweep:
    """Heats by rising power until the resistance falls no further, and cools by falling power."""

    columns: tuple[str, ...] = ()

    def __init__(self, rig: Rig, plan: SweepPlan) -> None:
        """Begin at the sense voltage."""
        self._sense_v, self._maximum_v = rig.sense_voltage_v, rig.maximum_voltage_v
        self._shunt_ohm, self._plan = rig.shunt_resistance_ohm, plan
        self._drive_v = rig.sense_voltage_v
        self._piece: list[tuple[float, float]] = []
        self._means: list[tuple[float, float]] = []
        self._piece_ends_s = PIECE_S
        self._turned: tuple[float, float] | None = None
        self._dropouts = 0
        self.stopped_by = ""

    def first_command(self) -> Command:
        """Return the sense voltage."""
        return Drive(self._sense_v)

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:
        """Return the voltage that gives the power wanted next."""
        reading = wire_resistance(sample.wire_voltage_v, sample.shunt_voltage_v, self._shunt_ohm)
        if not reading.valid:
            self._dropouts += 1
            if failure := dropout_failure(self._dropouts, sample, MAX_DROPOUTS):
                raise RigError(failure)
            return Decision(Drive(self._drive_v))
        self._dropouts = 0
        power_w = sample.wire_voltage_v**2 / reading.resistance_ohm
        self._note(elapsed_s, power_w, reading.resistance_ohm)
        if self._turned is None and elapsed_s > self._plan.rest_s and self._hot_enough(elapsed_s):
            self._turned = (elapsed_s, power_w)
        circuit_ohm = sample.drive_voltage_v * self._shunt_ohm / sample.shunt_voltage_v
        wanted_v = sqrt(self._power_at_w(elapsed_s) / reading.resistance_ohm) * circuit_ohm
        self._drive_v = float(min(max(wanted_v, self._sense_v), self._maximum_v))
        return Decision(Drive(self._drive_v))

    def _power_at_w(self, elapsed_s: float) -> float:
        """Return the power wanted at a time [W]."""
        plan = self._plan
        if self._turned is not None:
            turned_s, power_w = self._turned
            return power_w * max(1.0 - (elapsed_s - turned_s) / plan.down_s, 0.0)
        rising_w = plan.loop_power_w * max(elapsed_s - plan.rest_s, 0.0) / plan.up_s
        return min(rising_w, plan.highest_power_w)

    def _note(self, elapsed_s: float, power_w: float, resistance_ohm: float) -> None:
        """Keep the mean of each piece of the way up."""
        if self._turned is not None or elapsed_s <= self._plan.rest_s:
            return
        self._piece.append((power_w, resistance_ohm))
        if elapsed_s >= self._plan.rest_s + self._piece_ends_s:
            self._means.append(tuple(np.mean(self._piece, axis=0).tolist()))
            self._piece.clear()
            self._piece_ends_s += PIECE_S

    def _hot_enough(self, elapsed_s: float) -> bool:
        """Return whether it is time to cool: far enough, or as far as limits and time allow."""
        if elapsed_s > self._plan.rest_s + OVERDRIVE * self._plan.up_s - PIECE_S:
            at_voltage = self._drive_v >= self._maximum_v - 1e-9
            self.stopped_by = (
                f"the drive was at its limit of {self._maximum_v:g} V" if at_voltage else self._plan.limited_by
            )
            return True
        if self._piece or len(self._means) < 2:
            return False
        power_w, resistance_ohm = np.array(self._means).T
        fallen = float(resistance_ohm.max() - resistance_ohm[-1]) / self._plan.fall_ohm
        return fallen >= MIN_DEPTH and has_levelled(power_w, resistance_ohm, LEVEL_FRACTION)
