"""The cooling after a closed loop: the wire at the sense voltage until it is cold, in rows without a target.

By how high its resistance turns a change of load or resistance is seen that came in mid-run, when the wire was hot.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import NamedTuple

from musclewire.experiment._run import Decision, Following, FollowingPart
from musclewire.judge import height_of_b
from musclewire.physics import wire_resistance
from musclewire.rigs import HasAnEnd, Rig, ability
from musclewire.sensing import SensingModel
from musclewire.signals import COOLING_FROM, OF_THE_ESTIMATE, Command, Drive, RawSample

# After five of its time constants every wire is cold: 1.2 K are left of 180 K. In as many again it shows whether its
# resistance still rises: 8 s in all for a thin one.
COOLING_LAGS = 10.0


class CoolingPolicy(NamedTuple):
    """Holds the sense voltage [V]; of what the loop before it recorded only the resistance has values."""

    sense_voltage_v: float
    shunt_resistance_ohm: float
    columns: Sequence[str]

    def first_command(self) -> Command:
        """Return the sense voltage."""
        return Drive(self.sense_voltage_v)

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:  # noqa: ARG002
        """Return the sense voltage, and the resistance of a sample."""
        reading = wire_resistance(sample.wire_voltage_v, sample.shunt_voltage_v, self.shunt_resistance_ohm)
        seen = {OF_THE_ESTIMATE: reading.resistance_ohm}
        return Decision(self.first_command(), tuple(seen.get(name, nan) for name in self.columns))


def cooling_time_s(rig: Rig, model: SensingModel, duration_s: float) -> float:
    """Return for how long a wire is watched cooling after a loop [s]; 0 without anything to compare with."""
    cooling_s = COOLING_LAGS * rig.protection_limits.heat.lag_s
    samples = sum(round(one / rig.sample_period_s) for one in (duration_s, cooling_s))
    ends = ability(rig, HasAnEnd)
    enough = ends is None or ends.samples_left >= samples
    return cooling_s if enough and "model_cooling_ohm" in height_of_b(model) else 0.0


def cooling_after(rig: Rig, columns: Sequence[str], duration_s: float) -> Following | None:
    """Return the cooling that follows a loop of these columns for a time [s]; None for no time."""
    part = FollowingPart(CoolingPolicy(rig.sense_voltage_v, rig.shunt_resistance_ohm, columns), duration_s)
    return Following(COOLING_FROM, lambda _: part) if duration_s else None
