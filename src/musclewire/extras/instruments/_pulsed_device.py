"""Heating by pulse width on a simulated rig: a fixed supply is switched, and a microcontroller samples in the pulses.

A drive voltage is the root mean square of the pulses, so that it heats as a steady voltage does: its square over the
supply's is the duty. The wire runs through every pulse, with the ripple of its temperature. In the last pulses of a
sample both voltages are read at a stated time after the edge, one after the other by one converter, behind filters that
settle; between pulses the wire is off, or carries a small sense voltage. The readings are scaled to the drive voltage:
their ratio is the resistance (Eq. 1), their product the mean power.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

from musclewire.errors import CallerError
from musclewire.extras.instruments._pulse_width import (
    APERTURE_S,
    PulseWidth,
    duty_of,
    left_over,
    pulse_width_problems,
    sampling_problem,
)
from musclewire.rigs import Metadata, SimulatedDevice, SimulatedSpool
from musclewire.signals import RawSample
from musclewire.wire import WireMeans


class PulsePhase(NamedTuple):
    """A piece of a pulse: how long, at which voltage, and which voltages are read at its end."""

    duration_s: float
    voltage_v: float
    reads: tuple[str, ...] = ()


class PulsedDevice(SimulatedDevice):
    """A simulated device whose wire is heated by pulses of a fixed supply; all else is as in ``SimulatedDevice``."""

    uncompiled: ClassVar[str] = "the rig heats by pulse width"

    def __init__(self, pwm: PulseWidth, spool: SimulatedSpool, **how: Any) -> None:
        """Cool the wire and wait; raises CallerError for a supply or pulses that the bench's numbers do not allow."""
        readings = spool.bench.acquisition_readings.model_copy(update={"value": float(pwm.readings)})
        bench = spool.bench.model_copy(update={"acquisition_readings": readings})
        super().__init__(spool._replace(bench=bench), **how)
        highest_v = self.facts.limits.maximum_voltage_v
        if pwm.supply < highest_v:
            raise CallerError(
                f"[pwm] supply {pwm.supply:g} V is below maximum_voltage {highest_v:g} V, which pulses cannot reach: a "
                "higher supply, or a lower maximum_voltage"
            )
        if pwm.supply > bench.acquisition_range_v.value:
            raise CallerError(
                f"[pwm] supply {pwm.supply:g} V is above the converter's range, {bench.acquisition_range_v.value:g} V: "
                "set acquisition_range_v, as a divider does"
            )
        self._pwm, self._pulses = pwm, pwm.pulses_in(self.facts.sample_period_s)
        self._period_s = self.facts.sample_period_s / self._pulses
        self._seen = {"wire": 0.0, "shunt": 0.0}
        self._scale, self._ripple_k, self._free_s = 1.0, 0.0, 0.0

    def metadata(self) -> Metadata:
        """Return the metadata of a recording that describe this rig, with its pulses and what is wrong with them."""
        problems = pulse_width_problems(self._pwm, self.facts.limits.sense_voltage_v, self._ripple_k)
        return {
            **super().metadata(),
            "pwm_frequency_hz": 1.0 / self._period_s,
            "pwm_supply_v": self._pwm.supply,
            "pwm_window": self._pwm.window,
            "pwm_sample_delay_s": self._pwm.sample_delay,
            "pwm_ripple_k": self._ripple_k,
            **({"pwm_problem": "; ".join(problems)} if problems else {}),
        }

    def _advance(self, drive_voltage_v: float) -> WireMeans:
        """Run the pulses of one sample; the voltages are those read in its last ones, at the window's level."""
        pwm = self._pwm
        sensing = pwm.window == "off" and drive_voltage_v > 0.0
        off_v = self.facts.limits.sense_voltage_v if sensing else 0.0
        duty = duty_of(drive_voltage_v, off_v, pwm)
        read: dict[str, list[float]] = {"wire": [], "shunt": []}
        moved = force = squares = 0.0
        for pulse in range(self._pulses):
            reading = drive_voltage_v > 0.0 and pulse >= self._pulses - pwm.readings
            on_s = self._on_time_s(duty, reading)
            coldest_k = self.wires.state.temperature_k if reading else 0.0
            for phase in self._phases(on_s, off_v, reading):
                means = self._run(phase, read)
                moved += means.displacement_m * phase.duration_s
                force += means.force_n * phase.duration_s
                squares += phase.voltage_v**2 * phase.duration_s
                if reading and phase.voltage_v == pwm.supply:
                    self._ripple_k = max(self._ripple_k, self.wires.state.temperature_k - coldest_k)
        sample_s = self.facts.sample_period_s
        self._drive_voltage_v = math.sqrt(squares / sample_s)
        level_v = pwm.supply if pwm.window == "on" else off_v
        self._scale = self._drive_voltage_v / level_v if level_v > 0.0 else 0.0
        wire_v, shunt_v = (sum(values) / max(len(values), 1) for values in (read["wire"], read["shunt"]))
        return WireMeans(wire_v, pwm.shunt_gain * shunt_v, moved / sample_s, force / sample_s)

    def _on_time_s(self, duty: float, reading: bool) -> float:
        """Return how long a pulse is: as the duty says, but while reading no shorter than the window needs."""
        on_s, needed_s = duty * self._period_s, self._pwm.reading_ends_s
        if not reading or self._pwm.trigger == "free":
            return on_s
        return max(on_s, needed_s) if self._pwm.window == "on" else min(on_s, self._period_s - needed_s)

    def _phases(self, on_s: float, off_v: float, reading: bool) -> list[PulsePhase]:
        """Return a pulse piece by piece, cut at its edges and around both readings."""
        reads = self._reading_times(on_s) if reading else []
        cuts = {on_s, self._period_s, *(at_s for _, at_s in reads)}
        cuts |= {max(at_s - APERTURE_S, 0.0) for _, at_s in reads}
        phases, before_s = [], 0.0
        for until_s in sorted(cuts):
            if until_s > before_s:
                level_v = self._pwm.supply if 0.5 * (before_s + until_s) < on_s else off_v
                names = tuple(name for name, at_s in reads if at_s == until_s)
                phases.append(PulsePhase(until_s - before_s, level_v, names))
                before_s = until_s
        return phases

    def _reading_times(self, on_s: float) -> list[tuple[str, float]]:
        """Return when the voltages of wire and shunt are held, from the beginning of a pulse [s]."""
        pwm, period_s = self._pwm, self._period_s
        if pwm.trigger == "edge":
            held_s = pwm.sample_delay + APERTURE_S + (on_s if pwm.window == "off" else 0.0)
            return [("wire", held_s), ("shunt", held_s + pwm.conversion_time)]
        held_s = self._free_s
        # The next pair begins where the converter is after as many pairs as a period has begun, at any phase.
        pair_s = 2.0 * (pwm.conversion_time + APERTURE_S)
        self._free_s = (held_s + math.ceil(period_s / pair_s) * pair_s) % period_s
        return [
            ("wire", max(held_s, APERTURE_S)),
            ("shunt", max((held_s + pwm.conversion_time) % period_s, APERTURE_S)),
        ]

    def _run(self, phase: PulsePhase, read: Mapping[str, list[float]]) -> WireMeans:
        """Run a piece of a pulse: wire, then filters, then the reading at its end."""
        means = self.wires.advance(phase.voltage_v, phase.duration_s, self.stepping)
        true = {"wire": means.wire_voltage_v, "shunt": means.shunt_voltage_v}
        for name, settling_s in (("wire", self._pwm.wire_settling), ("shunt", self._pwm.shunt_settling)):
            self._seen[name] = true[name] + (self._seen[name] - true[name]) * left_over(phase.duration_s, settling_s)
        for name in phase.reads:
            read[name].append(self._seen[name])
        return means

    def _read(self, means: WireMeans) -> RawSample:
        """Return a sample of all instruments' readings, the voltages scaled to the drive voltage."""
        sample = super()._read(means)
        return sample._replace(
            wire_voltage_v=self._scale * sample.wire_voltage_v,
            shunt_voltage_v=self._scale / self._pwm.shunt_gain * sample.shunt_voltage_v,
        )


def pulsed_device(pwm: PulseWidth, spool: SimulatedSpool, **how: Any) -> PulsedDevice:
    """Return a device whose wire is heated by pulses. Raises CallerError for pulses whose readings are useless."""
    problem = sampling_problem(pwm, spool.bench.sense_voltage_v.value)
    if problem is not None and problem.useless:
        raise CallerError(f"[pwm] {problem.text}")
    return PulsedDevice(pwm, spool, **how)
