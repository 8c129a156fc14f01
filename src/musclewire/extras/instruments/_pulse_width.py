"""The pulses that heat a simulated wire, and when a microcontroller reads both voltages within them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, Field

from musclewire.errors import CallerError
from musclewire.rigs import RigKey
from musclewire.signals import measured_in

if TYPE_CHECKING:
    from musclewire.rigs import RigConfiguration

Seconds = Annotated[float, measured_in("s"), Field(ge=0.0, allow_inf_nan=False)]

# A converter's sample-and-hold follows its input for about this long before it holds.
APERTURE_S = 2e-6
# An unsettled reading is named from this error of resistance on: that of a strain of half a percent of stroke.
NAMED_ERROR = 1e-3
# A first-order filter counts as settled after this many time constants: 0.07 % are left.
SETTLED = 7.0
# From this error on the protection takes a sound wire for another one: such a rig is not opened.
USELESS_ERROR = 0.1
# A swing of the temperature within a pulse is named from here on.
NAMED_RIPPLE_K = 1.0


class PulseWidth(BaseModel):
    """The table ``[pwm]`` of a simulated rig's file: heating by pulse width, and when the voltages are read.

    Parameters
    ----------
    frequency
        Frequency of the pulses [Hz]; a sample holds the nearest whole number of them.
    supply
        Voltage that is switched across wire and shunt [V].
    window
        "on": read while the supply is on; "off": between the pulses, where the sense voltage is across wire and shunt.
    sample_delay
        Time from the edge that opens the window to the reading of the wire's voltage [s].
    conversion_time
        Time of one conversion [s]; the shunt's voltage is read that much later, by the same converter.
    readings
        Pulses in which both voltages are read, the last ones of a sample; their mean is the sample.
    wire_settling
        Time constant of the filter before the wire's channel [s].
    shunt_settling
        Time constant of the amplifier behind the shunt [s].
    shunt_gain
        Gain of the amplifier behind the shunt, which the converter sees; 10 as on the firmware's STM32 board.
    timer_bits
        Resolution of the duty.
    trigger
        "edge": the timer starts the conversions; "free": they run by themselves, at any phase of the pulses.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    frequency: Annotated[float, measured_in("Hz"), Field(gt=0.0, allow_inf_nan=False)]
    supply: Annotated[float, measured_in("V"), Field(gt=0.0, allow_inf_nan=False)]
    window: Literal["on", "off"] = "on"
    sample_delay: Seconds = 50e-6
    conversion_time: Seconds = 5e-6
    readings: int = Field(default=4, ge=1, le=1000)
    wire_settling: Seconds = 1e-6
    shunt_settling: Seconds = 5e-6
    shunt_gain: float = Field(default=10.0, gt=0.0, allow_inf_nan=False)
    timer_bits: int = Field(default=12, ge=4, le=16)
    trigger: Literal["edge", "free"] = "edge"

    @property
    def reading_ends_s(self) -> float:
        """Time from the edge to the end of both readings [s]."""
        return self.sample_delay + self.conversion_time + APERTURE_S

    def pulses_in(self, sample_period_s: float) -> int:
        """Return how many pulses a sample has. Raises CallerError for pulses that a sample or a reading cannot hold."""
        pulses = round(self.frequency * sample_period_s)
        if pulses < self.readings:
            raise CallerError(
                f"[pwm] {self.frequency:g} Hz gives {self.frequency * sample_period_s:.2g} pulses in a sample of "
                f"{sample_period_s:g} s, and readings = {self.readings}: a higher frequency or fewer readings"
            )
        period_s = sample_period_s / pulses
        if self.reading_ends_s >= period_s:
            raise CallerError(
                f"[pwm] a reading ends {1e6 * self.reading_ends_s:.0f} us after its edge, and a period is only "
                f"{1e6 * period_s:.0f} us long: a lower frequency, a shorter sample_delay or a faster converter"
            )
        return pulses


def heats_one_wire(_pwm: PulseWidth, configuration: RigConfiguration) -> str | None:
    """Return why pulses do not fit a rig; None if it has one wire."""
    two = any(part.second_wire is not None for part in configuration.load)
    return "[pwm] heats one wire: leave out the second one, or [pwm]" if two else None


PULSES = RigKey(
    PulseWidth | None,
    Field(default=None, description="Heating by pulse width, and when the voltages are read within the pulses."),
    written="[pwm]",
    what="heating by pulse width",
    device="musclewire.extras.instruments._pulsed_device:pulsed_device",
    misfit=heats_one_wire,
)


def pulse_width_problems(pwm: PulseWidth, sense_voltage_v: float, ripple_k: float = 0.0) -> tuple[str, ...]:
    """Return what makes the readings wrong: sampling before the filters settle, free of the pulses, or a hot ripple."""
    severe = sampling_problem(pwm, sense_voltage_v)
    found = [] if severe is None else [severe.text]
    if ripple_k > NAMED_RIPPLE_K:
        found.append(
            f"the wire's temperature swings by up to {ripple_k:.1f} K within a pulse, and resistance is that of one "
            "moment of it: a higher frequency"
        )
    return tuple(found)


class SamplingProblem(NamedTuple):
    """What is wrong with the times of the readings, and whether they are of no use at all."""

    text: str
    useless: bool


def sampling_problem(pwm: PulseWidth, sense_voltage_v: float) -> SamplingProblem | None:
    """Return what is wrong with the times of the readings; None if nothing is."""
    if pwm.trigger == "free":
        return SamplingProblem(
            "aliasing: the conversions run free of the pulses (trigger = 'free'), so that readings of wire and shunt "
            "fall into different phases of them: let the timer start them (trigger = 'edge')",
            True,
        )
    error = unsettled_error(pwm, sense_voltage_v)
    if abs(error) <= NAMED_ERROR:
        return None
    slowest_us = 1e6 * max(pwm.wire_settling, pwm.shunt_settling)
    return SamplingProblem(
        f"sampled too early: {1e6 * pwm.sample_delay:g} us after the edge the resistance reads {100 * error:+.2g} % "
        f"wrong, because filters settle in {slowest_us:g} us: sample {SETTLED * slowest_us:.0f} us after the edge",
        abs(error) > USELESS_ERROR,
    )


def unsettled_error(pwm: PulseWidth, sense_voltage_v: float) -> float:
    """Return the relative error of resistance that both filters leave at the times of their readings."""
    wire = left_over(pwm.sample_delay + APERTURE_S, pwm.wire_settling)
    shunt = left_over(pwm.sample_delay + pwm.conversion_time + APERTURE_S, pwm.shunt_settling)
    # A pulse rises from 0 V; between pulses the voltages fall from the supply's to that of sensing.
    jump = -1.0 if pwm.window == "on" else (pwm.supply - sense_voltage_v) / sense_voltage_v
    return (1.0 + jump * wire) / (1.0 + jump * shunt) - 1.0 if 1.0 + jump * shunt > 0.0 else math.inf


def left_over(time_s: float, settling_s: float) -> float:
    """Return the part of a jump that a first-order filter has not followed yet."""
    return math.exp(-time_s / settling_s) if settling_s > 0.0 else 0.0


def duty_of(drive_voltage_v: float, off_v: float, pwm: PulseWidth) -> float:
    """Return the duty with which pulses heat as a steady drive voltage does, in steps of the timer."""
    wanted = (drive_voltage_v**2 - off_v**2) / (pwm.supply**2 - off_v**2)
    steps = float(2**pwm.timer_bits)
    return round(min(max(wanted, 0.0), 1.0) * steps) / steps
