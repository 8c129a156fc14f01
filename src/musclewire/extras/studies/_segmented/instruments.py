"""Instruments of a wire in segments: converters, leads, contacts, clock, displacement sensor and load cell."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple, Self

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.rigs import MIN_SPREAD_STEPS, read_sample

STRONGEST = 3.0  # standard deviations of the jitter of a sample's time, at most
SHORTEST = 0.1  # of a sample period: no sample is shorter
STREAM = 7933


class InstrumentSettings(NamedTuple):
    """Numbers of the instruments; :meth:`of_bench` takes those of a bench.

    Parameters
    ----------
    voltage_noise_v
        Noise of a reading of a voltage, rms [V].
    bits
        Resolution of the converter.
    wire_range_v, shunt_range_v
        End of the range of each channel [V].
    bipolar
        Whether the converter's steps cover the range to both sides of 0, as a card's; those of most microcontrollers
        begin at 0.
    readings
        Readings averaged into one sample.
    wire_gain, shunt_gain
        Readings as a multiple of the true voltage.
    lead_resistance_ohm
        Resistance of leads within the measured voltage of the wire [ohm].
    contact_jump_ohm, contact_interval_s
        Resistance that a bad contact adds while it is bad [ohm], and the mean time until it changes [s]. It is in the
        measured voltage, too; none by default.
    clock_jitter
        Standard deviation of the time of a sample as a fraction of the period. The time stamps do not show it.
    displacement_noise_m, force_noise_n
        Noise of displacement sensor [m] and load cell [N], rms.
    """

    voltage_noise_v: float
    bits: int
    wire_range_v: float
    shunt_range_v: float
    bipolar: bool = True
    readings: int = 50
    wire_gain: float = 1.0
    shunt_gain: float = 1.0
    lead_resistance_ohm: float = 0.0
    contact_jump_ohm: float = 0.0
    contact_interval_s: float = 5.0
    clock_jitter: float = 0.0
    displacement_noise_m: float = 1e-6
    force_noise_n: float = 0.002

    @classmethod
    def of_bench(cls, bench: Mapping[str, float]) -> Self:
        """Return the instruments of a bench's numbers.

        Parameters
        ----------
        bench
            Numbers of a bench by name, in SI: ``Bench.values()``.

        Returns
        -------
        Instruments like those of the simulated rig.
        """
        return cls(
            voltage_noise_v=bench["acquisition_noise_v"],
            bits=int(bench["acquisition_bits"]),
            wire_range_v=bench["acquisition_range_v"],
            shunt_range_v=bench["acquisition_range_v"],
            readings=int(bench["acquisition_readings"]),
            displacement_noise_m=bench["displacement_noise_m"],
            force_noise_n=bench["force_noise_n"],
        )

    def checked(self) -> Self:
        """Return the settings themselves, checked.

        Returns
        -------
        The settings.

        Raises
        ------
        CallerError
            For numbers that no instrument has.
        """
        positive = (self.bits, self.wire_range_v, self.shunt_range_v, self.readings, self.wire_gain, self.shunt_gain)
        if not (min(*positive, self.contact_interval_s) > 0 and all(math.isfinite(number) for number in self)):
            raise CallerError(
                "instruments need bits, ranges, readings, gains and a contact interval above 0, all finite: "
                + ", ".join(f"{name} {value}" for name, value in self._asdict().items())
            )
        noises = (self.voltage_noise_v, self.displacement_noise_m, self.force_noise_n)
        if min(*noises, self.lead_resistance_ohm, self.contact_jump_ohm, self.clock_jitter) < 0.0:
            raise CallerError(
                f"noises {noises}, leads {self.lead_resistance_ohm:g} ohm, contact {self.contact_jump_ohm:g} ohm and "
                f"jitter {self.clock_jitter:g} of instruments must be 0 or more"
            )
        if self.clock_jitter > 0.2:
            raise CallerError(f"clock_jitter {self.clock_jitter:g} must be at most 0.2 of the period")
        return self

    @property
    def steps_v(self) -> tuple[float, float]:
        """Steps of the converter on the channels of wire and shunt [V]."""
        ends = 2.0 if self.bipolar else 1.0
        wire_v, shunt_v = (ends * end_v / 2.0**self.bits for end_v in (self.wire_range_v, self.shunt_range_v))
        return wire_v, shunt_v

    @property
    def readings_noisy(self) -> bool:
        """Whether noise changes every reading, so that a constant reading is a fault by itself."""
        spread_v = self.voltage_noise_v * math.sqrt(self.readings)
        return spread_v >= MIN_SPREAD_STEPS * max(self.steps_v)


class RunningInstruments:
    """Instruments through time, repeatable for one seed.

    Parameters
    ----------
    settings
        Their numbers.
    seed
        Seed of all noise.
    period_s
        Sample period [s].

    Raises
    ------
    CallerError
        For numbers that no instrument has.
    """

    def __init__(self, settings: InstrumentSettings, seed: int, period_s: float) -> None:
        """Draw the first noise; a contact is good at first."""
        self.settings = settings.checked()
        self._draw = np.random.default_rng(seed).standard_normal
        # A stream of its own: contact and clock leave the noise of the converters as it is.
        self._events = np.random.default_rng([seed, STREAM])
        self._period_s, self._early_s, self._bad_contact = period_s, 0.0, False
        self._noise: FloatArray = np.empty(4 * settings.readings + 2)
        wire_v, shunt_v = settings.steps_v
        references = (settings.displacement_noise_m, settings.force_noise_n)
        self._wire = (settings.voltage_noise_v, wire_v, settings.wire_range_v, *references)
        self._shunt = (settings.voltage_noise_v, shunt_v, settings.shunt_range_v, 0.0, 0.0)

    def duration_s(self) -> float:
        """Return how long the next sample really lasts [s]: the clock's jitter moves its end."""
        if self.settings.clock_jitter == 0.0:
            return self._period_s
        strength = min(max(self._events.standard_normal(), -STRONGEST), STRONGEST)
        early_s = self.settings.clock_jitter * self._period_s * strength
        before_s, self._early_s = self._early_s, early_s
        return max(self._period_s + before_s - early_s, SHORTEST * self._period_s)

    def lead_ohm(self) -> float:
        """Return the resistance within the measured voltage of the wire during the next sample [ohm]."""
        settings = self.settings
        if settings.contact_jump_ohm > 0.0:
            changes = self._events.random() < -math.expm1(-self._period_s / settings.contact_interval_s)
            self._bad_contact = self._bad_contact != changes
        return settings.lead_resistance_ohm + (settings.contact_jump_ohm if self._bad_contact else 0.0)

    def sample(self, true: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
        """Return the readings of both voltages [V], displacement [m] and force [N].

        Parameters
        ----------
        true
            Voltage of the wire [V], voltage of the shunt [V], displacement [m] and force [N] as they are.

        Returns
        -------
        The same as they are read.
        """
        self._draw(out=self._noise)
        wire_v, shunt_v, displacement_m, force_n = true
        settings, readings = self.settings, self.settings.readings
        seen = (settings.wire_gain * wire_v, 0.0, displacement_m, force_n)
        read_v, _, read_m, read_n = read_sample(self._noise[: 2 * readings + 2], readings, seen, self._wire)
        other = (settings.shunt_gain * shunt_v, 0.0, 0.0, 0.0)
        shunt_read_v, _, _, _ = read_sample(self._noise[2 * readings :], readings, other, self._shunt)
        return read_v, shunt_read_v, read_m, read_n
