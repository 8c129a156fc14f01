"""Driving a wire by a waveform, and the slow sine that characterizes it.

Its amplitude may be found beforehand: one sweep shows where the resistance has stopped falling.
"""

from __future__ import annotations

import math
from functools import lru_cache, partial
from math import inf
from typing import NamedTuple, TypedDict, Unpack

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers import Event
from musclewire.errors import CallerError, argument
from musclewire.experiment._home_sweep import HomeSweep, SweepPlan
from musclewire.experiment._known_drive import KnownDrive
from musclewire.experiment._minor_loop import minor_loop_after
from musclewire.experiment._run import (
    Decision,
    Following,
    OnSample,
    RunOptions,
    Waveform,
    refuse_unusable,
    run_on_rig,
)
from musclewire.identify import shows_c
from musclewire.parameters import ValidityLimits
from musclewire.rigs import ProtectionTripError, Rig, refuse_no_rig
from musclewire.signals import (
    MINOR_LOOP_FROM,
    Command,
    Drive,
    MetadataValue,
    RawSample,
    Recording,
    describe_recording,
)

# A transformation takes a tenth of a wire's resistance and more; a smaller fall is not judged.
MIN_FALL_FRACTION = 0.06
# [K] below the highest temperature at which the alloy was measured; both are estimated from the power.
BELOW_COVERED_K = 2.0
# The amplitude that is proposed after a trip stays within the lowest of these:
WITHIN_K = 413.15  # [K], 140 C: up to it wires are driven by default
BELOW_LIMIT_K = 10.0  # [K] below the protection's limit
LESS = 0.9  # of the amplitude that tripped
STEPS_PER_VOLT = 20.0  # it is rounded down to steps of 50 mV, which read well
ZERO_CELSIUS_K = 273.15


class LevellingAmplitude(NamedTuple):
    """An amplitude, and why it is no larger."""

    amplitude_v: float  # at least the rig's own
    levelled: bool  # whether the fall of the resistance has levelled off there
    stopped_by: str  # the limit that was met before, in words; empty if it has levelled off


def levelling_amplitude(rig: Rig, on_sample: OnSample | None = None) -> LevellingAmplitude:
    """Raise the power of a wire until the fall of its resistance levels off, within the limits of rig and alloy.

    The wire is driven for about half a minute, and more for a thick one.
    """
    limits = rig.protection_limits
    nominal_ohm = 0.5 * (limits.resistance_low_ohm + limits.resistance_high_ohm)
    own_w = nominal_ohm * (rig.drive_amplitude_v / (nominal_ohm + limits.shunt_resistance_ohm)) ** 2
    covered_k = ValidityLimits.stated_in(rig.metadata()).covered_temperature_high_k
    highest_k = inf if covered_k is None else covered_k - BELOW_COVERED_K
    plan = SweepPlan.for_rig(rig, own_w, MIN_FALL_FRACTION * nominal_ohm, highest_k=highest_k)
    sweep = HomeSweep(rig, plan)
    recording = run_on_rig(
        rig, sweep, plan.duration_s, metadata={"experiment": "levelling amplitude"}, on_sample=on_sample
    )
    highest_v = max(float(recording["drive_voltage_v"].max()), rig.drive_amplitude_v)
    return LevellingAmplitude(min(highest_v, rig.maximum_voltage_v), not sweep.stopped_by, sweep.stopped_by)


PAPER_PERIOD_S = 90.0


class SlowSine(TypedDict, total=False):
    """Keywords of the slow sine, as :func:`characterize` takes them; recipes built on it pass them on."""

    amplitude_v: float | None
    period_s: float
    cycles: int


def slow_sine(amplitude_v: float, sense_voltage_v: float, period_s: float = PAPER_PERIOD_S) -> Waveform:
    """Return drive voltage over time: a raised cosine from the sense voltage to the amplitude and back.

    The paper drives "a sine wave voltage input with 1/90 Hz and amplitude 3.2 V" and does not say whether it is offset.
    A sine about zero would heat twice a period; ours goes once from cold to hot and back, and never below the sense
    voltage, where Eq. 1 has no current to divide by.

    References
    ----------
    Lan and Fan 2010, section 2.1.
    """
    if not (0.0 <= sense_voltage_v < amplitude_v and period_s > 0.0):
        raise CallerError(
            f"a slow sine needs an amplitude above the sense voltage and a period above 0 s; got amplitude "
            f"{amplitude_v} V, sense voltage {sense_voltage_v} V, period {period_s} s"
        )

    return raised_cosine(amplitude_v, sense_voltage_v, period_s)


@lru_cache(maxsize=64)
def raised_cosine(amplitude_v: float, sense_voltage_v: float, period_s: float) -> Waveform:
    """Return the slow sine as a function, the same one for the same numbers: what it plays is kept."""

    def drive_voltage_v(time_s: float) -> float:
        swing = 0.5 * (1.0 - math.cos(2.0 * math.pi * time_s / period_s))
        return sense_voltage_v + (amplitude_v - sense_voltage_v) * swing

    return drive_voltage_v


@lru_cache(maxsize=16)
def played_waveform(waveform: Waveform, period_s: float, elapsed_s: tuple[float, ...]) -> tuple[FloatArray, FloatArray]:
    """Return the drive of each sample [V], (n_samples,), and the numbers of the cycles, (n_samples, 1)."""
    drives_v = [waveform(0.0), *(waveform(time_s) for time_s in elapsed_s[:-1])]
    return np.array(drives_v), np.array([[cycle_at(time_s, period_s)] for time_s in elapsed_s])


def cycle_at(elapsed_s: float, period_s: float) -> float:
    """Return the number of the cycle of a sample; one that ends a cycle belongs to that cycle."""
    return float(max(math.ceil(elapsed_s / period_s - 1e-9), 1))


class WaveformPolicy:
    """Plays a waveform without feedback."""

    columns = ("cycle",)

    def __init__(self, waveform: Waveform, period_s: float) -> None:
        """Play ``waveform``; ``period_s`` only numbers the cycles."""
        self._waveform = waveform
        self._period_s = period_s

    def first_command(self) -> Command:
        """Return the waveform's start."""
        return Drive(self._waveform(0.0))

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:  # noqa: ARG002
        """Return the waveform's next value; a sample that ends a cycle belongs to that cycle."""
        return Decision(Drive(self._waveform(elapsed_s)), (cycle_at(elapsed_s, self._period_s),))

    def known_drive(self, elapsed_s: tuple[float, ...]) -> KnownDrive:
        """Return the waveform at the beginning of each sample, with the number of its cycle."""
        drives_v, cycles = played_waveform(self._waveform, self._period_s, elapsed_s)
        return KnownDrive(drives_v.copy(), cycles)


def allowed_amplitude_v(rig: Rig, amplitude_v: float | None) -> float:
    """Return the amplitude [V], the rig's own if None. Raises CallerError for one above the rig's maximum."""
    refuse_no_rig(rig)
    amplitude = rig.drive_amplitude_v if amplitude_v is None else amplitude_v
    if amplitude > rig.maximum_voltage_v:
        raise CallerError(
            f"amplitude {amplitude:g} V is {amplitude - rig.maximum_voltage_v:.3g} V above the rig's maximum of "
            f"{rig.maximum_voltage_v:g} V: drive less or, if the wire bears it, raise the rig file's "
            "maximum_voltage"
        )
    return amplitude


class SlowSineRun(NamedTuple):
    """What a slow sine runs: its policy, how long, and what its recording states."""

    policy: WaveformPolicy
    duration_s: float
    metadata: dict[str, MetadataValue]
    waveform: Waveform


def slow_sine_run(
    rig: Rig, amplitude_v: float | None = None, period_s: float = PAPER_PERIOD_S, cycles: int = 2
) -> SlowSineRun:
    """Return the run of a slow sine on a rig. Raises CallerError as :func:`characterize` does."""
    amplitude = allowed_amplitude_v(rig, amplitude_v)
    if cycles < 1:
        raise CallerError(f"cycles is {cycles}: give at least 1")
    waveform = slow_sine(amplitude, rig.sense_voltage_v, period_s)
    metadata: dict[str, MetadataValue] = {"experiment": "slow sine", "amplitude_v": amplitude, "period_s": period_s}
    return SlowSineRun(WaveformPolicy(waveform, period_s), cycles * period_s, metadata, waveform)


def way_out(rig: Rig, amplitude_v: float) -> str:
    """Return in words how warm the protection took the wire to be in a slow sine, and which amplitude would be within.

    The amplitude follows from the protection's own balance: the power that holds the wire at 140 C, or below a lower
    limit, in the circuit with the least resistance that this wire may have.
    """
    limits, estimated_k = rig.protection_limits, rig.protection.temperature_k
    within_k = min(WITHIN_K, limits.maximum_temperature_k - BELOW_LIMIT_K)
    said = (
        f"at an amplitude of {amplitude_v:.3g} V the protection's estimate was {estimated_k - ZERO_CELSIUS_K:.0f} C, "
        f"its limit is {limits.maximum_temperature_k - ZERO_CELSIUS_K:.0f} C"
    )
    if within_k <= limits.ambient_temperature_k:
        return said
    ohm, shunt_ohm = limits.resistance_low_ohm, limits.shunt_resistance_ohm
    held_v = math.sqrt(limits.heat.power_w(within_k) / ohm) * (ohm + shunt_ohm)
    # Less than what tripped in any case, whatever a fault has done to the estimate.
    within_v = math.floor(STEPS_PER_VOLT * min(held_v, LESS * amplitude_v)) / STEPS_PER_VOLT
    if within_v <= rig.sense_voltage_v:
        return said
    return said + ": give less, as " + argument("amplitude_v", within_v) + ", which it takes to stay within"


def characterize(
    rig: Rig,
    *,
    amplitude_v: float | None = None,
    period_s: float = PAPER_PERIOD_S,
    cycles: int = 2,
    until_level: bool = False,
    minor_loop: bool = True,
    **run: Unpack[RunOptions],
) -> Recording:
    """Heat and cool the wire slowly and record both voltages and the reference instruments.

    This is the loop that a model is fitted to. After the first cycle the wire repeats its loop; the analysis uses the
    last. A minor loop follows, which takes about one cycle more: from cold up to two thirds of the way, back to one
    third, up again and down. It is a segment of its own, ``Recording.minor_loop``, which no analysis of the cycles
    sees; by it a fit finds the law of the wire's minor loops. A run that is cut off in it has a whole slow loop.

    Parameters
    ----------
    rig
        The rig, open; it is driven.
    amplitude_v
        Greatest drive voltage [V]; the rig's own if None (3.2 V for the paper's 0.1 mm wire).
    period_s
        Time of a cycle [s]; the paper's 90 s, which is long compared with the thermal time constant of a thin wire.
    cycles
        How many; 2, so that the second one repeats.
    until_level
        Whether an amplitude that is not given is raised above the rig's own, within its limits, until the fall of the
        resistance levels off; a sweep of half a minute before the slow sine finds it. The metadata say what stopped it.
    minor_loop
        Whether a minor loop follows the cycles. A wire whose resistance does not fall in them has none.
    **run
        ``path`` of the recording, ``overwrite`` one that exists, ``on_sample`` called with every recorded row; it
        may raise to stop the run, ``until`` asked after each whether the run is to end now.

    Returns
    -------
    The recording. Its metadata state with ``shows_c`` whether the resistance has levelled off where the wire was
    hottest; if not, C is only the turning point of the drive.

    Raises
    ------
    CallerError
        For an amplitude above what the rig allows, or fewer than one cycle.
    RigError
        If the rig failed or was tripped; it carries the partial recording as ``.recording``.

    References
    ----------
    Lan and Fan 2010, section 2.1: a sine of 1/90 Hz and 3.2 V.

    Examples
    --------
    >>> import musclewire as mw
    >>> with mw.open_rig("simulated") as rig:
    ...     loop = mw.characterize(rig, cycles=1)
    >>> loop.names
    ('time_s', 'drive_voltage_v', 'wire_voltage_v', 'shunt_voltage_v', 'displacement_m', 'force_n', 'cycle')
    """
    path = run.get("path")
    refuse_unusable(path, run.get("overwrite", False))
    raised: dict[str, MetadataValue] = {}
    if until_level and amplitude_v is None:
        found = levelling_amplitude(rig, run.get("on_sample"))
        amplitude_v = found.amplitude_v
        if amplitude_v > rig.drive_amplitude_v:
            raised = {"amplitude_raised": "until the fall levelled off" if found.levelled else found.stopped_by}
    sine = slow_sine_run(rig, amplitude_v, period_s, cycles)
    following: Following | None = None
    if minor_loop:
        turning = partial(minor_loop_after, waveform=sine.waveform, period_s=period_s, fall=MIN_FALL_FRACTION)
        following = Following(MINOR_LOOP_FROM, turning)
    metadata = {**sine.metadata, **raised}
    try:
        recording = run_on_rig(rig, sine.policy, sine.duration_s, metadata=metadata, following=following, **run)
    except ProtectionTripError as trip:
        if trip.event is Event.OVER_TEMPERATURE:
            trip.args = (f"{trip}; " + way_out(rig, float(str(sine.metadata["amplitude_v"]))),)
        raise
    seen = shows_c(recording)
    if seen is None:
        return recording
    if path is not None:
        describe_recording(path, {"shows_c": seen})
    return recording.with_metadata(shows_c=seen)
