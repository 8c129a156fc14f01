"""The amplitude of a slow sine at which the resistance has stopped falling, found by one sweep of rising power."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

from musclewire.experiment._home_sweep import HomeSweep, SweepPlan
from musclewire.experiment._run import OnSample, run_on_rig
from musclewire.parameters import ValidityLimits
from musclewire.rigs import Rig

# A transformation takes a tenth of a wire's resistance and more; a smaller fall is not judged.
MIN_FALL_FRACTION = 0.06
# Below the highest temperature at which the alloy was measured by so much [K], in both estimated from the power.
BELOW_COVERED_K = 2.0


class LevellingAmplitude(NamedTuple):
    """An amplitude, and why it is no larger.

    Parameters
    ----------
    amplitude_v
        Greatest drive voltage [V], at least the rig's own.
    levelled
        Whether the fall of the resistance has levelled off there.
    stopped_by
        The limit that was met before, in words; empty if it has levelled off.
    """

    amplitude_v: float
    levelled: bool
    stopped_by: str


def levelling_amplitude(rig: Rig, on_sample: OnSample | None = None) -> LevellingAmplitude:
    """Raise the power of a wire until the fall of its resistance levels off, within the limits of rig and alloy.

    Parameters
    ----------
    rig
        The rig, open; it is driven for about half a minute, and more for a thick wire.
    on_sample
        Called with every row, numbers by column name; it may raise to stop the run.

    Returns
    -------
    The amplitude for a slow sine, and the limit that was met if one was.

    Raises
    ------
    RigError
        If the rig failed or was tripped.
    """
    limits = rig.protection_limits
    nominal_ohm = 0.5 * (limits.resistance_low_ohm + limits.resistance_high_ohm)
    own_w = nominal_ohm * (rig.drive_amplitude_v / (nominal_ohm + limits.shunt_resistance_ohm)) ** 2
    covered_k = ValidityLimits.stated_in(rig.metadata()).covered_temperature_high_k
    highest_k = inf if covered_k is None else covered_k - BELOW_COVERED_K
    plan = SweepPlan.for_rig(rig, own_w, MIN_FALL_FRACTION * nominal_ohm, until_level=True, highest_k=highest_k)
    sweep = HomeSweep(rig, plan)
    recording = run_on_rig(
        rig, sweep, plan.duration_s, metadata={"experiment": "levelling amplitude"}, on_sample=on_sample
    )
    highest_v = max(float(recording["drive_voltage_v"].max()), rig.drive_amplitude_v)
    return LevellingAmplitude(min(highest_v, rig.maximum_voltage_v), not sweep.stopped_by, sweep.stopped_by)
