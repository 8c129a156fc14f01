"""A wire on an NI card: drive out, both voltages in, all paced by the card's sample clock."""

from __future__ import annotations

import time
import weakref
from contextlib import suppress
from dataclasses import replace
from threading import RLock
from typing import NamedTuple

from musclewire.controllers import Event, protection_table
from musclewire.errors import RigError
from musclewire.extras.board._nidaq.configuration import NiDaqConfiguration, ReadingSpan
from musclewire.extras.board._nidaq.driver import STALLED, AcquisitionCard, DaqFaultError, InputStream, OutputSettings
from musclewire.extras.board._nidaq.guardian import GuardianOrders
from musclewire.extras.board._nidaq.output import GuardedOutput, GuardianLostError, HostStalledError
from musclewire.rigs import SWITCHED_OFF, Answer, DeviceFacts, DeviceFault, DeviceKind, Metadata, Missing
from musclewire.signals import Command, RawSample, drive_voltage_of

# Length of the driver's buffer of readings [s]: a first run may compile for this long at the sense voltage.
BUFFER_S = 30.0
# While the host waits for readings, it sends the guardian a command at least this often [s].
BEAT_S = 0.02
# Largest number of readings fetched at once; more would not fit into one message of gRPC.
MAX_FETCH = 20_000
# Clocks of one card are divided from one oscillator: a ratio that is not exact is a different ratio.
RATIO_TOLERANCE = 1e-9

COLUMNS = {
    "wire_voltage": "wire_voltage_v",
    "shunt_voltage": "shunt_voltage_v",
    "displacement": "displacement_m",
    "force": "force_n",
    "endpoint_displacement": "endpoint_displacement_m",
    "endpoint_force": "endpoint_force_n",
}


class CardOffMeanwhileError(RigError):
    """Another thread has switched off."""


class SilenceTimes(NamedTuple):
    """Seconds of a silent host after which the guardian goes to the sense voltage, and after which it switches off."""

    sense_after_s: float
    off_after_s: float


class NiDaqDevice:
    """A wire on a card of National Instruments, driven by its analogue output.

    Time is counted in readings of the card, so it does not drift against them. The output belongs to a process of its
    own, the guardian, which switches it off when this one is killed or stalls, by default after what the protection
    table says of a late sample. Raises MissingExtraError without nidaqmx. Raises RigError if the card cannot be used.
    """

    def __init__(self, configuration: NiDaqConfiguration, silence: SilenceTimes | None = None) -> None:
        """Open the card at 0 V."""
        self._of = configuration
        self._silence = silence or SilenceTimes(protection_table().sense_after_s, protection_table().trip_after_s)
        self._layout = configuration.layout()
        self._wired = configuration.inputs.wired()
        self._drive_voltage_v = 0.0
        self._periods = 0
        self._reading_since: float | None = None
        self._stopped_at: float | None = None
        self._late_samples = 0
        self._off = False
        # Another thread may call ``off``: the output is then closed at once, the inputs when the exchange has ended.
        self._writing, self._exchanging = RLock(), RLock()
        self._facts = self._known_facts()
        self._card = AcquisitionCard(configuration.device, configuration.grpc)
        try:
            self._product = self._card.product()
            # A card has several outputs, and each may heat a wire of its own.
            self._facts = replace(self._facts, identity=f"{self._card.identity()} {configuration.output.channel}")
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
        # A rig that its program does not close is switched off nevertheless, at the latest when Python ends.
        weakref.finalize(self, self._output.close)
        self._require_clocks_in_step()

    def _known_facts(self) -> DeviceFacts:
        """Return the facts of the rig, before the card is opened. Raises CallerError for impossible numbers."""
        wire, shunt = self._of.inputs.wire_voltage, self._of.inputs.shunt_voltage
        return DeviceFacts(
            sample_period_s=self._of.sample_period,
            paced=not self._of.lockstep,
            leg_length_m=self._of.leg_length_m,
            drive_amplitude_v=self._of.drive_amplitude,
            limits=self._of.protection_limits(
                wire_range_v=wire.rule.largest(wire.range), shunt_range_v=shunt.rule.largest(shunt.range)
            ),
            reference_columns=tuple(
                COLUMNS[name] for name in self._wired if name not in ("wire_voltage", "shunt_voltage")
            ),
        )

    def _orders(self) -> GuardianOrders:
        """Return the orders for the guardian."""
        clock_hz = 1.0 / self._of.sample_period if self._of.output_timing == "hardware" else None
        output = OutputSettings(
            self._of.device, self._of.grpc, self._of.output.channel, self._of.output.range, clock_hz
        )
        return GuardianOrders(
            output,
            self._of.output.gain,
            self._of.output.offset,
            self._of.sense_voltage,
            self._silence.sense_after_s,
            self._silence.off_after_s,
        )

    def _require_clocks_in_step(self) -> None:
        """Raise RigError if the card rounds rates so that readings and drive would drift apart."""
        rates = {"reading_rate": (self._inputs.rate_hz, self._of.reading_rate)}
        if self._output.clock_hz is not None:
            rates["sample_period"] = (self._output.clock_hz, 1.0 / self._of.sample_period)
        for key, (found_hz, wanted_hz) in rates.items():
            if abs(found_hz - wanted_hz) > RATIO_TOLERANCE * wanted_hz:
                self.off()
                raise RigError(
                    f"{self._of.device} makes {found_hz:.9g} Hz of {wanted_hz:.9g} Hz ({key}): take a rate that "
                    "divides its timebase, such as 1 kHz"
                )

    @property
    def facts(self) -> DeviceFacts:
        """Facts of the card and its wire."""
        return self._facts

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage at the output now [V], as far as the host knows."""
        return self._drive_voltage_v

    def __repr__(self) -> str:
        """Name the card, its wire and its drive."""
        return (
            f"NiDaqDevice({self._product} {self._of.device}, wire {self._of.wire}, drive {self._drive_voltage_v:.3f} V)"
        )

    def metadata(self) -> Metadata:
        """Return the metadata of a recording that describe this rig."""
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

    def exchange(self, command: Command) -> Answer:
        """Apply a drive voltage and return the mean of the readings taken under it."""
        drive_voltage_v = drive_voltage_of(command)
        driven = self._drive_voltage_v > self._of.sense_voltage
        with self._exchanging:
            try:
                span = self._put(drive_voltage_v)
                means_v = self._mean_readings_v(span)
            except CardOffMeanwhileError:
                return SWITCHED_OFF
            except HostStalledError as stall:
                return DeviceFault(Event.COMMAND_MISSING, f"{stall}: the guardian has switched off")
            except GuardianLostError as lost:
                return DeviceFault(Event.DEVICE_LOST, str(lost))
            except DaqFaultError as fault:
                return DeviceFault(Event.COMMAND_MISSING if fault.code == STALLED else Event.DEVICE_LOST, str(fault))
        self._periods += span.periods
        sample = self._sample(means_v)
        if span.periods == 1:
            return sample
        self._late_samples += 1
        late_s = (span.periods - 1) * self._of.sample_period
        return Missing(Event.SAMPLE_LATE, late_s, sample) if driven else sample

    def _put(self, drive_voltage_v: float) -> ReadingSpan:
        """Write the drive and return which readings are taken under it."""
        with self._writing:
            self._require_on()
            if self._reading_since is not None:
                self._output.put(drive_voltage_v)
            else:
                self._output.begin(drive_voltage_v)
            self._drive_voltage_v = drive_voltage_v
        if self._reading_since is not None:
            return self._layout.following(self._inputs.waiting())
        now = time.monotonic()
        if self._stopped_at is not None:
            # A pause between runs is counted by the host's clock, because the card's has stopped.
            pause_s = now - self._stopped_at
            self._periods += round(pause_s / self._of.sample_period)
        self._inputs.start()
        self._reading_since = now
        return self._layout.first()

    def _mean_readings_v(self, span: ReadingSpan) -> list[float]:
        """Return the mean voltage [V] of each input over a span's last readings, in the order of the rig file."""
        skipped = span.fetch - span.average
        sums = [0.0] * len(self._wired)
        done = 0
        while done < span.fetch:
            # In pieces, so that the guardian knows that the host waits for the card and has not stalled.
            piece = min(span.fetch - done, self._piece())
            values = self._inputs.fetch(piece)
            kept = values[:, max(0, skipped - done) :]
            sums = [total + float(row.sum()) for total, row in zip(sums, kept, strict=True)]
            done += piece
            # After the last piece too: readings without a drive are a supply's fault only if nobody has switched off.
            with self._writing:
                self._require_on()
                self._output.keep()
        return [total / span.average for total in sums]

    def _piece(self) -> int:
        """Return how many readings are fetched at once."""
        return min(MAX_FETCH, max(1, round(BEAT_S * self._of.reading_rate)))

    def _sample(self, means_v: list[float]) -> RawSample:
        """Return a sample from the means of all inputs."""
        found = {
            COLUMNS[name]: item.rule.quantity(mean_v)
            for (name, item), mean_v in zip(self._wired.items(), means_v, strict=True)
        }
        time_s = self._periods * self._of.sample_period  # counted, not summed: no rounding adds up
        return RawSample(time_s=time_s, drive_voltage_v=self._drive_voltage_v, **found)

    def _require_on(self) -> None:
        if self._off:
            raise CardOffMeanwhileError("the output is closed: open the rig again")

    def sense(self) -> bool:
        """Go to the sense voltage at once, and stop reading until the next sample is asked for."""
        try:
            with self._writing:
                self._output.put_now(self._of.sense_voltage)
                self._drive_voltage_v = self._of.sense_voltage
            if self._reading_since is not None:
                self._inputs.stop()
                self._reading_since, self._stopped_at = None, time.monotonic()
        except RigError:
            return False
        return True

    def off(self) -> bool:
        """End the guardian, which applies 0 V, and release the card."""
        self._off = True
        with self._writing:
            confirmed = self._output.close()
            self._drive_voltage_v = 0.0
        with self._exchanging:
            with suppress(RigError):
                self._inputs.close()
            self._card.close()
        return confirmed


NIDAQ = DeviceKind(NiDaqConfiguration, NiDaqDevice)
