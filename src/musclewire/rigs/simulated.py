"""A simulated bench as a device: wires, their load, circuit, acquisition, instruments and air."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.controllers.protection import Event
from musclewire.errors import CallerError, RigError
from musclewire.parameters.parameter_groups import Bench
from musclewire.parameters.validity import validity_of
from musclewire.physics.resistance import series_resistance_ohm
from musclewire.rigs.air import AirModel, Surroundings
from musclewire.rigs.device import SWITCHED_OFF, Answer, DeviceFacts, DeviceFault, Missing
from musclewire.rigs.load_part import LoadPart, Pull
from musclewire.rigs.mechanism import Mechanism, mechanism_of
from musclewire.rigs.protocol import Metadata
from musclewire.rigs.simulated_building import (
    Spool,
    convection_metadata,
    force_limit_n,
    load_metadata,
    simulated_limits,
    stepping_of,
    wires_of,
)
from musclewire.rigs.simulated_faults import SimulatedFault, SimulatedFaults
from musclewire.rigs.simulation_clock import SimulationClock
from musclewire.signals.exchange import Command, RawSample, drive_voltage_of
from musclewire.wire.loads import spring_load
from musclewire.wire.state import WireState
from musclewire.wire.stepping import Stepping
from musclewire.wire.wires import SampleMeans, SimulatedWires

__all__ = ["Instruments", "SimulatedDevice", "SimulatedInside", "read_sample"]


class SimulatedInside(NamedTuple):
    """What a simulated device is made of, for loops in compiled code. What may change is the device's own."""

    wires: SimulatedWires
    bench: Mapping[str, float]
    stepping: Stepping
    instruments: Instruments
    air: AirModel | None
    mechanism: Mechanism
    reference_columns: tuple[str, ...]
    faulty: bool
    paced: bool
    pulsed: bool = False


# NumPy sums up to this many numbers in eight rows, and more of them in two halves.
PAIRWISE_NUMBERS = 128


@compiled
def summed(readings_v: FloatArray) -> float:
    """Return the sum of readings, added in the order of ``numpy.sum``; the first eight are overwritten."""
    count = readings_v.size
    if count > PAIRWISE_NUMBERS:
        half = count // 2 - count // 2 % 8
        return summed(readings_v[:half]) + summed(readings_v[half:])
    total, rows = 0.0, count - count % 8
    if rows:
        sums = readings_v[:8]
        for start in range(8, rows, 8):
            for place in range(8):
                sums[place] += readings_v[start + place]
        total = ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]))
    for place in range(rows, count):
        total += readings_v[place]
    return total


@compiled
def converted(noise: FloatArray, voltage_v: float, noise_v: float, step_v: float, range_v: float) -> float:
    """Return the mean of a converter's readings with noise, steps and a range; they overwrite the noise."""
    for place in range(noise.size):
        reading_v = np.rint((voltage_v + noise_v * noise[place]) / step_v) * step_v
        noise[place] = min(max(reading_v, -range_v), range_v)
    return summed(noise) / noise.size


@compiled
def read_sample(
    noise: FloatArray,
    readings: int,
    true: tuple[float, float, float, float],
    scales: tuple[float, float, float, float, float],
) -> tuple[float, float, float, float]:
    """Return what a converter, a displacement sensor and a load cell read in one sample.

    ``true`` holds the voltages of wire and shunt, displacement and force; ``noise`` independent standard normal
    numbers, ``readings`` for each voltage and one for each of the others, and is overwritten; ``scales`` the
    converter's noise, step and range, then the noise of displacement and force.
    """
    wire_v, shunt_v, displacement_m, force_n = true
    noise_v, step_v, range_v, displacement_noise_m, force_noise_n = scales
    return (
        converted(noise[:readings], wire_v, noise_v, step_v, range_v),
        converted(noise[readings : 2 * readings], shunt_v, noise_v, step_v, range_v),
        displacement_m + displacement_noise_m * noise[2 * readings],
        force_n + force_noise_n * noise[2 * readings + 1],
    )


class Instruments:
    """Converter, displacement sensor, load cells and laser of a bench, repeatable for one seed."""

    def __init__(self, bench: Mapping[str, float], seed: int, at_endpoint: bool = False) -> None:
        """Take noise, steps and ranges from the bench's numbers; ``at_endpoint`` with instruments at an endpoint."""
        self._generator = np.random.default_rng(seed)
        self._draw = self._generator.standard_normal
        self._readings = int(bench["acquisition_readings"])
        self._noise: FloatArray = np.empty(2 * self._readings + (4 if at_endpoint else 2))
        voltage_range_v = bench["acquisition_range_v"]
        self._scales = (
            bench["acquisition_noise_v"],
            2.0 * voltage_range_v / 2.0 ** bench["acquisition_bits"],
            voltage_range_v,
            bench["displacement_noise_m"],
            bench["force_noise_n"],
        )
        self._endpoint_noise = (bench["endpoint_noise_m"], bench["endpoint_force_noise_n"])
        # Compiled here: a rig that keeps the pace of a clock would be late if the first sample waited for it.
        read_sample(np.zeros_like(self._noise), self._readings, (0.0, 0.0, 0.0, 0.0), self._scales)

    def sample(
        self, wire_voltage_v: float, shunt_voltage_v: float, displacement_m: float, force_n: float
    ) -> tuple[float, float, float, float]:
        """Return the readings of both voltages, and of displacement and force at the connector."""
        # All numbers that one sample takes are drawn at once.
        self._draw(out=self._noise)
        true = (wire_voltage_v, shunt_voltage_v, displacement_m, force_n)
        readings: tuple[float, float, float, float] = read_sample(self._noise, self._readings, true, self._scales)
        return readings

    def endpoint(self, displacement_m: float, force_n: float) -> tuple[float, float]:
        """Return readings of displacement and force at a finger's endpoint, of the sample that was read last."""
        displacement_noise_m, force_noise_n = self._endpoint_noise
        return (
            displacement_m + displacement_noise_m * self._noise.item(-2),
            force_n + force_noise_n * self._noise.item(-1),
        )

    def noise_ahead(self, samples: int) -> tuple[FloatArray, np.random.Generator]:
        """Return the noise that the next samples will draw, a row each, and the generator after it; none is drawn."""
        ahead = deepcopy(self._generator)
        return ahead.standard_normal((samples, self._noise.size)), ahead

    def take_generator(self, generator: np.random.Generator) -> None:
        """Draw all further noise from this generator, as after samples that were taken in compiled code."""
        self._generator, self._draw = generator, generator.standard_normal

    @property
    def readings(self) -> int:
        """How many readings of a voltage are averaged."""
        return self._readings

    @property
    def scales(self) -> tuple[float, float, float, float, float]:
        """What ``read_sample`` takes."""
        return self._scales

    @property
    def endpoint_noise(self) -> tuple[float, float]:
        """Noise of displacement [m] and force [N] at a finger's endpoint."""
        return self._endpoint_noise


class SimulatedDevice:
    """A simulated wire on a simulated bench, repeatable to the bit for one seed.

    It returns the readings that real instruments would: voltages in steps of the converter with its noise, a
    displacement and a force with theirs. Temperature, phases and parameters are not among them; ``wire_state`` is for
    judging a simulation, never for an estimator.

    Parameters
    ----------
    spool
        The wire, its alloy, its bench, and whether it is new.
    parts
        Load of the wire; without any, the bench's spring.
    surroundings
        How the air moves and changes its temperature; still air of the bench's temperature if None.
    seed
        Seed of the instruments' noise and of the air's movement.
    real_time
        Whether samples keep the pace of the machine's clock; as fast as possible otherwise.
    limits
        Limits of the protection that differ from those that follow from wire and bench, by their names in
        ``ProtectionLimits``; none if None.
    faults
        Faults of wire, circuit, channels and clock, with their times; none by default.

    Raises
    ------
    CallerError
        For numbers that cannot belong to a bench.
    """

    def __init__(
        self,
        spool: Spool,
        *,
        parts: Sequence[LoadPart] = (),
        surroundings: Surroundings | None = None,
        seed: int = 1,
        real_time: bool = False,
        limits: Mapping[str, float] | None = None,
        faults: Sequence[SimulatedFault] = (),
    ) -> None:
        """Cool the wire under its pretension and wait at 0 V."""
        wire, alloy, bench, new_wire = spool
        self._alloy, self._wire, self._around = alloy, wire, bench
        self._parts, self._new_wire = tuple(parts), new_wire
        self._bench = bench.values()
        self._wire_values = wire.values()
        self._seed = seed
        air = surroundings or Surroundings()
        self._air = None if air.still else AirModel(air, seed)
        self._check_pretension(self._bench["pretension_n"])
        self._tendon_slack_m: float | None = None
        self._leg_length_m = self._bench["wire_length_m"] / self._bench["legs"]
        self._mechanism = self._mechanism_at(self._bench["pretension_n"], None)
        self._instruments = Instruments(self._bench, seed, at_endpoint=self._mechanism.tendon is not None)
        self._wires = wires_of(alloy, wire, bench, self._parts, self._mechanism, new_wire=new_wire)
        self._off, self._drive_voltage_v = False, 0.0
        # By how much friction has kept the connector ahead of a slack wire at most, at this setting of the stages.
        self._held_m = 0.0
        self._facts = DeviceFacts(
            sample_period_s=self._bench["sample_period_s"],
            paced=real_time,
            leg_length_m=self._leg_length_m,
            drive_amplitude_v=self._wire_values["drive_amplitude_v"],
            limits=simulated_limits(alloy, wire, self._bench, self._parts, limits).checked(),
            reference_columns=self._instruments_there(),
        )
        self._faults = SimulatedFaults(faults) if faults else None
        self._wire_ohm = self._wire_values["resistance_per_metre_ohm_per_m"] * self._bench["wire_length_m"]
        self._clock = SimulationClock(self._bench["sample_period_s"]) if real_time else None
        self._stepping = self._stepping_of_the_bench()

    def _mechanism_at(self, pretension_n: float, tendon_slack_m: float | None) -> Mechanism:
        """Return the wire's load at a setting of the stages."""
        if not self._parts:
            return Mechanism(spring_load(self._bench["spring_stiffness_n_per_m"]), 0.0, True, None)
        return mechanism_of(
            self._parts,
            pretension_n=pretension_n,
            leg_length_m=self._leg_length_m,
            object_between=any(part.second_wire and part.second_wire.pull is Pull.APART for part in self._parts),
            tendon_slack_m=tendon_slack_m,
        )

    def _stepping_of_the_bench(self) -> Stepping:
        """Return how samples are divided into steps. Raises CallerError for a fixed step that does not divide them."""
        return stepping_of(self._bench)

    @property
    def facts(self) -> DeviceFacts:
        """Facts of the bench and its wire."""
        return self._facts

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage at the output now [V]."""
        return self._drive_voltage_v

    @property
    def adjustable_clock(self) -> SimulationClock | None:
        """The clock that paces the samples; None without one."""
        return self._clock

    @property
    def has_stage(self) -> bool:
        """Whether a stage sets the pretension; if the only load is a weight, the weight is the pretension."""
        return self._mechanism.stage

    @property
    def wire_state(self) -> WireState:
        """The true state of the wire: temperature, phases, energy. For judging a simulation, not for estimating."""
        return self._wires.state

    @property
    def partner_state(self) -> WireState | None:
        """The true state of a second wire; None if there is only one wire."""
        return self._wires.partner_state

    def _instruments_there(self) -> tuple[str, ...]:
        """Return the names of the reference instruments this bench has."""
        if self._mechanism.tendon is None:
            return ("displacement_m", "force_n")
        touches = any(part.obstacle is not None for part in self._parts)
        endpoint = ("endpoint_displacement_m", "endpoint_force_n") if touches else ("endpoint_displacement_m",)
        return ("displacement_m", "force_n", *endpoint)

    def inside(self) -> SimulatedInside:
        """Return the parts of the device."""
        return SimulatedInside(
            wires=self._wires,
            bench=self._bench,
            stepping=self._stepping,
            instruments=self._instruments,
            air=self._air,
            mechanism=self._mechanism,
            reference_columns=self._facts.reference_columns,
            faulty=self._faults is not None,
            paced=self._facts.paced,
        )

    def take(self, drive_voltage_v: float, generator: np.random.Generator, air: AirModel | None, held_m: float) -> None:
        """Take over what samples in compiled code have left behind, except for the wires' own state.

        Parameters
        ----------
        drive_voltage_v
            Drive voltage at the output [V].
        generator
            Generator of the instruments' noise.
        air
            The air, None if it is still.
        held_m
            Length by which friction has held the connector ahead of a slack wire at most [m].
        """
        self._drive_voltage_v, self._air, self._held_m = drive_voltage_v, air, max(self._held_m, held_m)
        self._instruments.take_generator(generator)

    def __repr__(self) -> str:
        """Name the wire, its pretension and its drive."""
        return (
            f"SimulatedDevice(wire {self._wire.name}, pretension {self._pretension_n:g} N, "
            f"drive {self._drive_voltage_v:.3f} V, at {self._wires.time_s:.2f} s)"
        )

    def metadata(self) -> Metadata:
        """Return the metadata of a recording that describe this rig."""
        return {
            "rig": "simulated",
            "wire": self._wire.name,
            "wire_diameter_m": self._wire.diameter_m.value,
            **convection_metadata(self._wire.diameter_m.value, self._bench["ambient_temperature_k"]),
            "wire_length_m": self._bench["wire_length_m"],
            "leg_length_m": self._leg_length_m,
            "shunt_resistance_ohm": self._facts.limits.shunt_resistance_ohm,
            "maximum_force_n": self._wire.maximum_force_n.value,
            **validity_of(self._alloy).facts(),
            "force_limit_n": force_limit_n(self._wire, self._parts),
            "pretension_n": self._pretension_n,
            **load_metadata(self._parts, self._mechanism, self.partner_state is not None),
            "sample_period_s": self._facts.sample_period_s,
            "time_step_s": self._bench["time_step_s"],
            "new_wire": self._new_wire,
            "seed": self._seed,
            "friction_held_m": self._held_m,
            "step_error_k": self._wires.step_error_k,
            **(self._clock.metadata() if self._clock else {}),
        }

    @property
    def _pretension_n(self) -> float:
        """Force of the cold wire: that of the stage and of hanging weights."""
        return (self._bench["pretension_n"] if self._mechanism.stage else 0.0) + self._mechanism.added_n

    def set_pretension(self, pretension_n: float) -> None:
        """Let the wire cool, then move the stage; the instruments are zeroed there.

        The clock continues and the wire keeps its history of cycles. Raises CallerError for a force the wire does not
        allow or the load cannot carry, and if the only load is a hanging weight: it is the pretension.
        """
        self._check_pretension(pretension_n)
        if not self._mechanism.stage:
            raise CallerError("a hanging weight is the pretension: change the part 'weight' instead of the stage")
        changed = self._around.pretension_n.model_copy(update={"value": pretension_n})
        self._cool_at(self._around.model_copy(update={"pretension_n": changed}), self._tendon_slack_m)

    def set_tendon_slack(self, slack_m: float) -> None:
        """Let the wire cool, then move the finger's stage: the tendon has this slack, or is drawn taut below 0.

        Raises CallerError without a finger on a pretensioner, and for a tendon that would be drawn beyond the finger's
        curve.
        """
        tendon = self._mechanism.tendon
        if tendon is None or not self._mechanism.load.stiffness_n_per_m:
            raise CallerError("there is no tendon to set: this rig has no finger with a pretensioner")
        if not -slack_m <= tendon.curve.tendon_travel_m[-1]:
            raise CallerError(
                f"the tendon cannot be drawn {-1e3 * slack_m:g} mm: the finger's curve ends before, draw less"
            )
        self._cool_at(self._around, slack_m)

    def _cool_at(self, around: Bench, tendon_slack_m: float | None) -> None:
        """Let the wires cool at another setting of the stages."""
        self._drive_voltage_v = 0.0
        self._rest()
        # Everything that can fail comes first: after a refused setting the rig keeps its previous one.
        mechanism = self._mechanism_at(around.pretension_n.value, tendon_slack_m)
        wires = wires_of(self._alloy, self._wire, around, self._parts, mechanism, new_wire=self._new_wire)
        wires.age_like(self._wires)
        self._around, self._bench, self._tendon_slack_m = around, around.values(), tendon_slack_m
        self._mechanism, self._wires, self._held_m = mechanism, wires, 0.0

    def _check_pretension(self, pretension_n: float) -> None:
        allowed = self._wire_values["maximum_force_n"]
        if not 0.0 <= pretension_n <= allowed:
            raise CallerError(f"pretension {pretension_n} N is outside 0 to {allowed} N, what {self._wire.name} allows")

    def exchange(self, command: Command) -> Answer:
        """Hold a drive voltage for one sample period and return the averaged readings at its end."""
        # How late the command comes is reported once; the guard then says what may still be out.
        if self._clock is not None and (late_s := self._clock.report_late_s()) > 0.0:
            return Missing(Event.SAMPLE_LATE, late_s)
        resolution = self._bench["amplifier_resolution_v"]
        self._drive_voltage_v = resolution * round(drive_voltage_of(command) / resolution)
        if self._off:  # looked at after it was put out, so that 0 V is the last word whichever thread comes first
            self._drive_voltage_v = 0.0
            return SWITCHED_OFF
        time_s = self._wires.time_s
        if self._faults is not None and self._faults.device_lost(time_s):
            return DeviceFault(Event.DEVICE_LOST, f"at {time_s:.2f} s, by the rig file's [[fault]]")
        if self._air is not None:
            air = self._air.after(time_s, self._facts.sample_period_s)
            self._wires.surround(self._bench["ambient_temperature_k"] + air.warmer_k, air.convection_ratio)
        means = self._advance(self._drive_voltage_v) if self._faults is None else self._advance_faulty(self._faults)
        self._wires.require_resolved()
        self._held_m = max(self._held_m, self._wires.slack_m)
        if self._clock is not None:
            self._clock.wait()
        return SWITCHED_OFF if self._off else self._read(means)

    def _advance(self, drive_voltage_v: float) -> SampleMeans:
        return self._wires.advance(drive_voltage_v, self._bench["sample_period_s"], self._stepping)

    def _advance_faulty(self, faults: SimulatedFaults) -> SampleMeans:
        """Advance the wire with its current in the faulty circuit; return the voltages at the terminals."""
        time_s, shunt_ohm = self._wires.time_s, self._facts.limits.shunt_resistance_ohm
        output_v = faults.output_v(self._drive_voltage_v, time_s)
        current_a = faults.circuit(output_v, self._wire_ohm, shunt_ohm, time_s).wire_current_a
        means = self._advance(current_a * (self._wire_ohm + shunt_ohm))
        if means.shunt_voltage_v > 0.0:
            self._wire_ohm = series_resistance_ohm(means.wire_voltage_v, means.shunt_voltage_v, shunt_ohm)
        seen = faults.circuit(output_v, self._wire_ohm, shunt_ohm, time_s)
        return means._replace(wire_voltage_v=seen.wire_voltage_v, shunt_voltage_v=seen.shunt_voltage_v)

    def _read(self, means: SampleMeans) -> RawSample:
        """Return a sample of all instruments' readings."""
        wire_voltage, shunt_voltage, displacement_m, force_n = self._instruments.sample(
            means.wire_voltage_v, means.shunt_voltage_v, means.displacement_m, means.force_n
        )
        time_s = self._wires.time_s
        if self._faults is not None:
            began_s = time_s - self._facts.sample_period_s
            wire_voltage, shunt_voltage = self._faults.readings_v(wire_voltage, shunt_voltage, began_s)
            time_s = self._faults.clock_s(time_s)
        sample = RawSample(time_s, self._drive_voltage_v, wire_voltage, shunt_voltage, displacement_m, force_n)
        if self._mechanism.tendon is None:
            return sample
        endpoint_m, endpoint_force_n = self._instruments.endpoint(*self._endpoint(means))
        touches = any(part.obstacle is not None for part in self._parts)
        return sample._replace(
            endpoint_displacement_m=endpoint_m, endpoint_force_n=endpoint_force_n if touches else None
        )

    def _endpoint(self, means: SampleMeans) -> tuple[float, float]:
        """Return the true position of the finger's endpoint [m] and the force on it [N]."""
        tendon = self._mechanism.tendon
        assert tendon is not None
        end_m = tendon.curve.tendon_travel_m[-1]
        travel_m = means.displacement_m + tendon.start_m - tendon.slack_m
        if travel_m > end_m:
            raise RigError(
                f"the tendon has travelled {1e3 * travel_m:.3f} mm, {1e3 * (travel_m - end_m):.3f} mm more than the "
                f"finger's file covers ({1e3 * end_m:.3f} mm); the drive is off: drive less, or compute a longer curve"
            )
        force = means.grip_n if means.grip_n is not None else float(tendon.endpoint_force_n(means.displacement_m))
        return float(tendon.endpoint_m(means.displacement_m, force)), force

    def _rest(self) -> None:
        """Expect no sample until the next exchange."""
        if self._clock is not None:
            self._clock.rest()

    def sense(self) -> bool:
        """Go to the sense voltage at once."""
        self._drive_voltage_v = self._facts.limits.sense_voltage_v
        self._rest()
        return True

    def off(self) -> bool:
        """Switch the drive off; while the fault ``device_lost`` is present nothing is confirmed."""
        self._off, self._drive_voltage_v = True, 0.0
        if self._clock is not None:
            self._clock.end()
        return self._faults is None or not self._faults.device_lost(self._wires.time_s)
