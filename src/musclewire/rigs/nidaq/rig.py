"""A wire on an NI card: drive out, both voltages in, everything at the pace of the card's sample clock."""

from __future__ import annotations

import time
import weakref
from contextlib import suppress
from typing import NoReturn

from musclewire.controllers.protection import Event, protection_table
from musclewire.errors import RigError
from musclewire.rigs.guarded import GuardedRig
from musclewire.rigs.nidaq.channels import Span
from musclewire.rigs.nidaq.configuration import NiDaqConfiguration
from musclewire.rigs.nidaq.driver import Card, InputStream, OutputSettings
from musclewire.rigs.nidaq.faults import STALLED, DaqFaultError
from musclewire.rigs.nidaq.guardian import GuardianOrders
from musclewire.rigs.nidaq.output import GuardedOutput, GuardianLostError, HostStalledError
from musclewire.rigs.protocol import Metadata
from musclewire.signals.commands import Command, drive_voltage_of
from musclewire.signals.samples import RawSample

__all__ = ["NiDaqRig"]

# What the driver keeps of readings that nobody fetches: a first run may compile for so long at the sense voltage [s].
BUFFER_S = 30.0
# The guardian hears of the host at least so often while the host waits for readings [s].
BEAT_S = 0.02
# Readings fetched at once where many wait; more would not fit into one message of gRPC.
LARGEST_FETCH = 20_000
# Clocks of one card are divided from one oscillator: their ratio is exact, or it is another one.
RATIO_TOLERANCE = 1e-9

COLUMNS = {
    "wire_voltage": "wire_voltage_v",
    "shunt_voltage": "shunt_voltage_v",
    "displacement": "displacement_m",
    "force": "force_n",
    "endpoint_displacement": "endpoint_displacement_m",
    "endpoint_force": "endpoint_force_n",
}


class NiDaqRig(GuardedRig):
    """A wire on a card of National Instruments, driven by its analogue output.

    Time is counted in readings of the card, so it does not drift against them. The output belongs to a process of its
    own, the guardian, which switches it off when this one is killed or stalls.
    """

    def __init__(self, configuration: NiDaqConfiguration) -> None:
        """Open the card at 0 V. Raises MissingExtraError without nidaqmx, RigError where the card cannot be used."""
        self._of = configuration
        self._layout = configuration.layout()
        self._wired = configuration.inputs.wired()
        self._drive_voltage_v = 0.0
        self._periods = 0
        self._reading_since: float | None = None
        self._stopped_at: float | None = None
        self._late_samples = 0
        inputs = configuration.inputs
        limits = configuration.protection_limits(
            wire_range_v=inputs.wire_voltage.rule.largest(inputs.wire_voltage.range),
            shunt_range_v=inputs.shunt_voltage.rule.largest(inputs.shunt_voltage.range),
        )
        self._card = Card(configuration.device, configuration.grpc)
        try:
            self._product = self._card.product()
            buffer = int(BUFFER_S * configuration.reading_rate)
            self._inputs = InputStream(self._card, self._wired, configuration.reading_rate, buffer)
        except BaseException:
            self._card.close()
            raise
        try:
            self._output = GuardedOutput(self._orders())
        except BaseException:
            self._inputs.close()
            self._card.close()
            raise
        # A rig that its program forgets to close is switched off all the same, at the latest when Python ends.
        weakref.finalize(self, self._output.close)
        self.protect_with(limits)
        self._require_clocks_in_step()

    def _orders(self) -> GuardianOrders:
        """Return what the guardian must know."""
        table = protection_table()
        clock_hz = 1.0 / self._of.sample_period if self._of.output_timing == "hardware" else None
        output = OutputSettings(
            self._of.device, self._of.grpc, self._of.output.channel, self._of.output.range, clock_hz
        )
        return GuardianOrders(
            output,
            self._of.output.gain,
            self._of.output.offset,
            self._of.sense_voltage,
            table.sense_after_s,
            table.trip_after_s,
        )

    def _require_clocks_in_step(self) -> None:
        """Raise RigError where the card rounds rates so that readings and drive would drift apart."""
        rates = {"reading_rate": (self._inputs.rate_hz, self._of.reading_rate)}
        if self._output.clock_hz is not None:
            rates["sample_period"] = (self._output.clock_hz, 1.0 / self._of.sample_period)
        for key, (found_hz, wanted_hz) in rates.items():
            if abs(found_hz - wanted_hz) > RATIO_TOLERANCE * wanted_hz:
                self.close()
                raise RigError(
                    f"{self._of.device} makes {found_hz:.9g} Hz of {wanted_hz:.9g} Hz ({key}): take a rate that "
                    "divides its timebase, such as 1 kHz"
                )

    @property
    def sample_period_s(self) -> float:
        """Time between samples."""
        return self._of.sample_period

    @property
    def paced(self) -> bool:
        """Whether samples come at the pace of a real clock: always."""
        return True

    @property
    def drive_amplitude_v(self) -> float:
        """Amplitude of the slow sine for this wire."""
        return self._of.drive_amplitude

    @property
    def leg_length_m(self) -> float:
        """Length of one leg of the V."""
        return self._of.leg_length_m

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage that is out now, as far as the host knows."""
        return self._drive_voltage_v

    @property
    def late_samples(self) -> int:
        """Samples whose drive was written too late, so that a period of the card passed unused."""
        return self._late_samples

    def __repr__(self) -> str:
        """Say which card, which wire, and what is out."""
        return f"NiDaqRig({self._product} {self._of.device}, wire {self._of.wire}, drive {self._drive_voltage_v:.3f} V)"

    @property
    def reference_columns(self) -> tuple[str, ...]:
        """Names of the reference instruments that are wired."""
        return tuple(COLUMNS[name] for name in self._wired if name not in ("wire_voltage", "shunt_voltage"))

    def metadata(self) -> Metadata:
        """Return what a recording should say about this rig."""
        return {
            "rig": "nidaq",
            "device": self._of.device,
            "product": self._product,
            **self._of.facts(),
            "output_timing": self._of.output_timing,
            "reading_rate_hz": self._of.reading_rate,
            "readings": self._of.readings,
            "late_samples": self._late_samples,
        }

    def _exchange(self, command: Command) -> RawSample:
        """Put out a drive voltage and return the mean of the readings taken under it."""
        drive_voltage_v = drive_voltage_of(command)
        driven = self._drive_voltage_v > self.sense_voltage_v
        try:
            span = self._put(drive_voltage_v)
            self._drive_voltage_v = drive_voltage_v
            means_v = self._mean_readings_v(span)
        except HostStalledError as stall:
            self._end(Event.COMMAND_MISSING, f"{stall}: the guardian has switched off")
        except GuardianLostError as lost:
            self._end(Event.DEVICE_LOST, str(lost))
        except DaqFaultError as fault:
            self._end(Event.COMMAND_MISSING if fault.code == STALLED else Event.DEVICE_LOST, str(fault))
        self._periods += span.periods
        if span.periods > 1:
            self._late_samples += 1
            if driven:
                self.miss(Event.SAMPLE_LATE, (span.periods - 1) * self.sample_period_s)
        return self._sample(means_v)

    def _end(self, event: Event, details: str) -> NoReturn:
        self.trip(event, details)
        raise AssertionError("a trip raises")

    def _put(self, drive_voltage_v: float) -> Span:
        """Write the drive and return which readings are taken under it."""
        if self._reading_since is not None:
            self._output.put(drive_voltage_v)
            return self._layout.following(self._inputs.waiting())
        self._output.begin(drive_voltage_v)
        now = time.monotonic()
        if self._stopped_at is not None:
            # A pause between runs is counted by the host's clock: the card's stood still.
            pause_s = now - self._stopped_at
            self._periods += round(pause_s / self.sample_period_s)
        self._inputs.start()
        self._reading_since = now
        return self._layout.first()

    def _mean_readings_v(self, span: Span) -> list[float]:
        """Return the mean voltage [V] of each input over a span's last readings, in the order of the rig file."""
        skipped = span.fetch - span.average
        sums = [0.0] * len(self._wired)
        done = 0
        while done < span.fetch:
            # In pieces: the guardian must hear that the host waits for the card and has not stalled.
            piece = min(span.fetch - done, self._piece())
            values = self._inputs.fetch(piece)
            kept = values[:, max(0, skipped - done) :]
            sums = [total + float(row.sum()) for total, row in zip(sums, kept, strict=True)]
            done += piece
            if done < span.fetch:
                self._output.keep()
        return [total / span.average for total in sums]

    def _piece(self) -> int:
        """Return how many readings are fetched at once."""
        return min(LARGEST_FETCH, max(1, round(BEAT_S * self._of.reading_rate)))

    def _sample(self, means_v: list[float]) -> RawSample:
        """Return a sample from the means of all inputs."""
        found = {
            COLUMNS[name]: item.rule.quantity(mean_v)
            for (name, item), mean_v in zip(self._wired.items(), means_v, strict=True)
        }
        time_s = self._periods * self.sample_period_s  # counted, not summed: no rounding adds up
        return RawSample(time_s=time_s, drive_voltage_v=self._drive_voltage_v, **found)

    def _put_safe(self) -> None:
        """Go to the sense voltage at once, and stop reading until the next sample is asked for."""
        try:
            self._output.put_now(self.sense_voltage_v)
            self._drive_voltage_v = self.sense_voltage_v
            if self._reading_since is not None:
                self._inputs.stop()
                self._reading_since, self._stopped_at = None, time.monotonic()
        except RigError:
            self.close()  # what cannot be put to the sense voltage goes off

    def _switch_off(self) -> None:
        """End the guardian, which puts out 0 V, and let go of the card."""
        self._off_confirmed = self._output.close()
        self._drive_voltage_v = 0.0
        with suppress(RigError):
            self._inputs.close()
        self._card.close()
