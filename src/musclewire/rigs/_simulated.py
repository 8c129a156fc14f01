"""A simulated bench as a device: wires, their load, circuit, acquisition, instruments and air."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import ClassVar, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner
from musclewire.controllers import Event, ProtectionLimits
from musclewire.errors import CallerError, RigError
from musclewire.parameters import Alloy, Bench, Numbers, Wire, validity_of
from musclewire.physics import convection_range_note
from musclewire.rigs._air import AirModel, Surroundings
from musclewire.rigs._device import SWITCHED_OFF, Answer, DeviceFacts, Metadata, Missing
from musclewire.rigs._load_part import LoadPart, second_wire_of
from musclewire.rigs._mechanism import SimulatedLoad, load_metadata, mechanism_of
from musclewire.rigs._simulation_clock import SimulationClock
from musclewire.rigs._wire_limits import WireCircuit, limits_of
from musclewire.signals import Command, RawSample, drive_voltage_of
from musclewire.wire import (
    ConnectorLoad,
    HeatBalance,
    OneWire,
    SimulatedWires,
    StepControl,
    WireConstants,
    WireMeans,
    WireState,
    constants_from,
    spring_load,
    steps_within,
)

# Noise in steps of the converter times the root of the readings in a mean: from this value on, two means in a row are
# equal in less than a tenth of all cases, and eight in a row once in a hundred million.
MIN_SPREAD_STEPS = 3.0


@compiled_inner
def converted(noise: FloatArray, voltage_v: float, noise_v: float, step_v: float, range_v: float) -> float:
    """Return the mean of a converter's readings with noise, steps and a range."""
    total_v = 0.0
    for place in range(noise.size):
        reading_v = np.rint((voltage_v + noise_v * noise[place]) / step_v) * step_v
        total_v += min(max(reading_v, -range_v), range_v)
    return total_v / noise.size


@compiled
def read_sample(
    noise: FloatArray,
    readings: int,
    true: tuple[float, float, float, float],
    scales: tuple[float, float, float, float, float],
) -> tuple[float, float, float, float]:
    """Return what a converter, a displacement sensor and a load cell read in one sample.

    ``true`` holds the voltages of wire and shunt, displacement and force; ``noise`` independent standard normal
    numbers, ``readings`` for each voltage and one for each of the others; ``scales`` the converter's noise, step and
    range, then the noise of displacement and force.
    """
    wire_v, shunt_v, displacement_m, force_n = true
    noise_v, step_v, range_v, displacement_noise_m, force_noise_n = scales
    return (
        converted(noise[:readings], wire_v, noise_v, step_v, range_v),
        converted(noise[readings : 2 * readings], shunt_v, noise_v, step_v, range_v),
        displacement_m + displacement_noise_m * noise[2 * readings],
        force_n + force_noise_n * noise[2 * readings + 1],
    )


class BenchInstruments:
    """Converter, displacement sensor, load cells and laser of a bench, repeatable for one seed."""

    def __init__(self, bench: Numbers, seed: int, at_endpoint: bool = False) -> None:
        """Take noise, steps and ranges from the bench's numbers; ``at_endpoint`` with instruments at an endpoint."""
        self._generator = np.random.default_rng(seed)
        self._draw = self._generator.standard_normal
        self.readings = int(bench["acquisition_readings"])
        self._noise: FloatArray = np.empty(2 * self.readings + (4 if at_endpoint else 2))
        voltage_range_v = bench["acquisition_range_v"]
        self.scales = (
            bench["acquisition_noise_v"],
            2.0 * voltage_range_v / 2.0 ** bench["acquisition_bits"],
            voltage_range_v,
            bench["displacement_noise_m"],
            bench["force_noise_n"],
        )
        self.endpoint_noise = (bench["endpoint_noise_m"], bench["endpoint_force_noise_n"])

    def sample(
        self, wire_voltage_v: float, shunt_voltage_v: float, displacement_m: float, force_n: float
    ) -> tuple[float, float, float, float]:
        """Return the readings of both voltages, and of displacement and force at the connector."""
        # All numbers that one sample takes are drawn at once.
        self._draw(out=self._noise)
        true = (wire_voltage_v, shunt_voltage_v, displacement_m, force_n)
        readings: tuple[float, float, float, float] = read_sample(self._noise, self.readings, true, self.scales)
        return readings

    def endpoint(self, displacement_m: float, force_n: float) -> tuple[float, float]:
        """Return readings of displacement and force at a finger's endpoint, of the sample that was read last."""
        displacement_noise_m, force_noise_n = self.endpoint_noise
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


class SimulatedSpool(NamedTuple):
    """A wire, its alloy, its bench, and whether it starts before its first cycles (shakedown)."""

    wire: Wire
    alloy: Alloy
    bench: Bench
    new_wire: bool = False

    @property
    def leg_length_m(self) -> float:
        """Length of one leg of the wire [m]."""
        return self.bench["wire_length_m"] / self.bench["legs"]

    def facts(self) -> Metadata:
        """Return the metadata of a recording that describe wire and circuit."""
        return {
            "wire": self.wire.name,
            "wire_diameter_m": self.wire.diameter_m.value,
            "wire_length_m": self.bench["wire_length_m"],
            "leg_length_m": self.leg_length_m,
            "shunt_resistance_ohm": self.bench["shunt_resistance_ohm"],
            "maximum_force_n": self.wire.maximum_force_n.value,
            **validity_of(self.alloy).facts(),
            "sample_period_s": self.bench["sample_period_s"],
        }

    def pulling(self, load: ConnectorLoad | None, pretension_n: float) -> WireConstants:
        """Return the constants of this wire at a cold force; without a load it acts on another wire's connector only.

        Raises CallerError for a pull that the wire does not allow.
        """
        require_allowed_pull(pretension_n, self.wire.maximum_force_n.value, self.wire.name)
        changed = {"pretension_n": pretension_n}
        if load is None:  # the guide's friction belongs to the first wire
            changed["guide_friction_n"] = 0.0
        known = {name: getattr(self.bench, name).model_copy(update={"value": value}) for name, value in changed.items()}
        around = self.bench.model_copy(update=known)
        return constants_from(self.alloy, self.wire, around, load=load or spring_load(0.0), new_wire=self.new_wire)


class SimulatedDevice:
    """A simulated wire on a simulated bench, repeatable to the bit for one seed.

    It returns the readings that real instruments would: voltages in steps of the converter with its noise, a
    displacement and a force with theirs. Temperature, phases and parameters are not among them; ``wire_state`` is for
    judging a simulation, never for an estimator. Raises CallerError for numbers that cannot belong to a bench.
    """

    uncompiled: ClassVar[str] = ""  # what of the device has no compiled form, in words

    def __init__(
        self,
        spool: SimulatedSpool,
        *,
        parts: Sequence[LoadPart] = (),
        surroundings: Surroundings | None = None,
        seed: int = 1,
        real_time: bool = False,
        limits: Mapping[str, float] | None = None,
        stated: Metadata | None = None,
    ) -> None:
        """Cool the wire under its pretension and wait at 0 V."""
        self.spool, self._parts, self._stated = spool, tuple(parts), dict(stated or {})
        bench = spool.bench
        self._resolution_v = bench["amplifier_resolution_v"]
        self._seed = seed
        air = surroundings or Surroundings()
        self.air = None if air.still else AirModel(air, seed)
        self._check_pretension(bench["pretension_n"])
        self._tendon_slack_m: float | None = None
        self.mechanism = mechanism_on(spool, self._parts, bench["pretension_n"])
        self.instruments = BenchInstruments(bench, seed, at_endpoint=self.mechanism.tendon is not None)
        self.wires = wires_of(spool, self._parts, self.mechanism)
        self._off, self._drive_voltage_v = False, 0.0
        # By how much friction has kept the connector ahead of a slack wire at most, at this setting of the stages.
        self._held_m = 0.0
        own_limits = simulated_limits(spool, self._parts, limits).checked()
        self._facts = DeviceFacts(
            sample_period_s=bench["sample_period_s"],
            paced=real_time,
            leg_length_m=spool.leg_length_m,
            drive_amplitude_v=spool.wire["drive_amplitude_v"],
            limits=own_limits,
            reference_columns=self._instruments_there(),
            wire_temperature_k=own_limits.ambient_temperature_k,
        )
        self._clock = SimulationClock(bench["sample_period_s"]) if real_time else None
        self.stepping = stepping_of(bench)

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
        return self.mechanism.stage

    @property
    def wire_state(self) -> WireState:
        """The true state of the wire: temperature, phases, energy. For judging a simulation, not for estimating."""
        return self.wires.state

    @property
    def partner_state(self) -> WireState | None:
        """The true state of a second wire; None if there is only one wire."""
        return self.wires.partner_state

    def _instruments_there(self) -> tuple[str, ...]:
        """Return the names of the reference instruments this bench has."""
        if self.mechanism.tendon is None:
            return ("displacement_m", "force_n")
        touches = any(part.obstacle is not None for part in self._parts)
        endpoint = ("endpoint_displacement_m", "endpoint_force_n") if touches else ("endpoint_displacement_m",)
        return ("displacement_m", "force_n", *endpoint)

    def adopt(self, drive_voltage_v: float, rng: np.random.Generator, air: AirModel | None, held_m: float) -> None:
        """Go on from samples in compiled code; the wires' own state is theirs.

        ``held_m`` is the length by which friction has held the connector ahead of a slack wire at most.
        """
        self._drive_voltage_v, self.air, self._held_m = drive_voltage_v, air, max(self._held_m, held_m)
        self.instruments.take_generator(rng)

    def __repr__(self) -> str:
        """Name the wire, its pretension and its drive."""
        return (
            f"SimulatedDevice(wire {self.spool.wire.name}, pretension {self._pretension_n:g} N, "
            f"drive {self._drive_voltage_v:.3f} V, at {self.wires.time_s:.2f} s)"
        )

    def metadata(self) -> Metadata:
        """Return the metadata of a recording that describe this rig."""
        return {
            **self._stated,  # what is below knows better
            "rig": "simulated",
            **self.spool.facts(),
            **convection_metadata(self.spool.wire.diameter_m.value, self.spool.bench["ambient_temperature_k"]),
            "force_limit_n": self.spool.wire.maximum_force_n.value
            if (second := second_wire_of(self._parts)) is None
            else second.force_limit_n(self.spool.wire),
            "pretension_n": self._pretension_n,
            **load_metadata(self._parts, self.mechanism, self.partner_state is not None),
            "time_step_s": self.spool.bench["time_step_s"],
            "new_wire": self.spool.new_wire,
            "seed": self._seed,
            "friction_held_m": self._held_m,
            "step_error_k": self.wires.step_error_k,
            **(self._clock.metadata() if self._clock else {}),
        }

    @property
    def _pretension_n(self) -> float:
        """Force of the cold wire: that of the stage and of hanging weights."""
        return (self.spool.bench["pretension_n"] if self.mechanism.stage else 0.0) + self.mechanism.added_n

    def set_pretension(self, pretension_n: float) -> None:
        """Let the wire cool, then move the stage; the instruments are zeroed there.

        The clock continues and the wire keeps its history of cycles. Raises CallerError for a force the wire does not
        allow or the load cannot carry, and if the only load is a hanging weight: it is the pretension.
        """
        self._check_pretension(pretension_n)
        if not self.mechanism.stage:
            raise CallerError("a hanging weight is the pretension: change the part 'weight' instead of the stage")
        changed = self.spool.bench.pretension_n.model_copy(update={"value": pretension_n})
        self._cool_at(self.spool.bench.model_copy(update={"pretension_n": changed}), self._tendon_slack_m)

    def set_tendon_slack(self, slack_m: float) -> None:
        """Let the wire cool, then move the finger's stage: the tendon has this slack, or is drawn taut below 0.

        Raises CallerError without a finger on a pretensioner, and for a tendon that would be drawn beyond the finger's
        curve.
        """
        tendon = self.mechanism.tendon
        if tendon is None or not self.mechanism.load.stiffness_n_per_m:
            raise CallerError("there is no tendon to set: this rig has no finger with a pretensioner")
        if not -slack_m <= tendon.curve.tendon_travel_m[-1]:
            raise CallerError(
                f"the tendon cannot be drawn {-1e3 * slack_m:g} mm: the finger's curve ends before, draw less"
            )
        self._cool_at(self.spool.bench, slack_m)

    def _cool_at(self, around: Bench, tendon_slack_m: float | None) -> None:
        """Let the wires cool at another setting of the stages."""
        self._drive_voltage_v = 0.0
        self._rest()
        # Everything that can fail comes first: after a refused setting the rig keeps its previous one.
        spool = self.spool._replace(bench=around)
        mechanism = mechanism_on(spool, self._parts, around["pretension_n"], tendon_slack_m)
        wires = wires_of(spool, self._parts, mechanism)
        wires.age_like(self.wires)
        self.spool, self._tendon_slack_m = spool, tendon_slack_m
        self.mechanism, self.wires, self._held_m = mechanism, wires, 0.0

    def _check_pretension(self, pretension_n: float) -> None:
        allowed = self.spool.wire["maximum_force_n"]
        if not 0.0 <= pretension_n <= allowed:
            raise CallerError(
                f"pretension {pretension_n} N is outside 0 to {allowed} N, what {self.spool.wire.name} allows"
            )

    def compile_exchange(self) -> None:
        """Compile all that an exchange and the end of a run need, by a sample of copies at 0 V."""
        wires = deepcopy(self.wires)
        means = wires.advance(0.0, self._facts.sample_period_s, self.stepping)
        wires.require_resolved()
        instruments = BenchInstruments(self.spool.bench, self._seed, at_endpoint=self.mechanism.tendon is not None)
        instruments.sample(means.wire_voltage_v, means.shunt_voltage_v, means.displacement_m, means.force_n)
        # How warm a run was is asked at its end, when it may still be heated.
        HeatBalance(1.0, 1.0, 0.0).along_k(np.zeros(2), np.zeros(2), np.zeros(2), 0.0, 0.0)

    def exchange(self, command: Command) -> Answer:
        """Hold a drive voltage for one sample period and return the averaged readings at its end."""
        # How late the command comes is reported once; the guard then says what may still be out.
        if self._clock is not None and (late_s := self._clock.report_late_s()) > 0.0:
            return Missing(Event.SAMPLE_LATE, late_s)
        resolution_v = self._resolution_v
        self._drive_voltage_v = resolution_v * round(drive_voltage_of(command) / resolution_v)
        if self._off:  # looked at after it was applied, so that 0 V is the last word whichever thread comes first
            self._drive_voltage_v = 0.0
            return SWITCHED_OFF
        if self.air is not None:
            air = self.air.after(self.wires.time_s, self._facts.sample_period_s)
            self.wires.surround(self.spool.bench["ambient_temperature_k"] + air.warmer_k, air.convection_ratio)
        means = self._advance(self._drive_voltage_v)
        self.wires.require_resolved()
        self._held_m = max(self._held_m, self.wires.slack_m)
        if self._clock is not None:
            self._clock.wait()
        return SWITCHED_OFF if self._off else self._read(means)

    def _advance(self, drive_voltage_v: float) -> WireMeans:
        return self.wires.advance(drive_voltage_v, self._facts.sample_period_s, self.stepping)

    def _read(self, means: WireMeans) -> RawSample:
        """Return a sample of all instruments' readings."""
        wire_voltage, shunt_voltage, displacement_m, force_n = self.instruments.sample(
            means.wire_voltage_v, means.shunt_voltage_v, means.displacement_m, means.force_n
        )
        sample = RawSample(
            self.wires.time_s, self._drive_voltage_v, wire_voltage, shunt_voltage, displacement_m, force_n
        )
        if self.mechanism.tendon is None:
            return sample
        endpoint_m, endpoint_force_n = self.instruments.endpoint(*self._endpoint(means))
        touches = any(part.obstacle is not None for part in self._parts)
        return sample._replace(
            endpoint_displacement_m=endpoint_m, endpoint_force_n=endpoint_force_n if touches else None
        )

    def _endpoint(self, means: WireMeans) -> tuple[float, float]:
        """Return the true position of the finger's endpoint [m] and the force on it [N]."""
        tendon = self.mechanism.tendon
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
        """Switch the drive off."""
        self._off, self._drive_voltage_v = True, 0.0
        if self._clock is not None:
            self._clock.end()
        return True


def mechanism_on(
    spool: SimulatedSpool, parts: Sequence[LoadPart], pretension_n: float, tendon_slack_m: float | None = None
) -> SimulatedLoad:
    """Return the load of a wire at a setting of the stages; the bench's spring without parts."""
    if not parts:
        return SimulatedLoad(spring_load(spool.bench["spring_stiffness_n_per_m"]), 0.0, True, None)
    return mechanism_of(
        parts,
        pretension_n=pretension_n,
        leg_length_m=spool.leg_length_m,
        object_between=(second := second_wire_of(parts)) is not None and second.holds_the_object,
        tendon_slack_m=tendon_slack_m,
    )


def wires_of(first: SimulatedSpool, parts: Sequence[LoadPart], mechanism: SimulatedLoad) -> SimulatedWires:
    """Return the wires of a rig, cold and at rest under the stage's pretension and the weights on the connector.

    Raises CallerError for numbers that cannot belong to a wire, and for what a second wire refuses.
    """
    stage_n = first.bench["pretension_n"] if mechanism.stage else 0.0
    second = second_wire_of(parts)
    if second is None:
        return OneWire(first.pulling(mechanism.load, stage_n + mechanism.added_n))
    return second.coupled(first, parts, mechanism, stage_n)


def simulated_limits(
    spool: SimulatedSpool, parts: Sequence[LoadPart], changed: Mapping[str, float] | None
) -> ProtectionLimits:
    """Return the limits of a simulated rig's protection. Raises CallerError for numbers that cannot belong together."""
    bench, maximum_v = spool.bench, spool.wire.maximum_voltage_v.value
    second = second_wire_of(parts)
    in_series, in_parallel = (1, 1) if second is None else second.on_the_drive
    if bench["sense_voltage_v"] >= maximum_v:
        raise CallerError(f"sense_voltage_v {bench['sense_voltage_v']} V must be below maximum_voltage_v {maximum_v} V")
    step_v = 2.0 * bench["acquisition_range_v"] / 2.0 ** bench["acquisition_bits"]
    circuit = WireCircuit(
        sense_voltage_v=bench["sense_voltage_v"],
        maximum_voltage_v=maximum_v,
        shunt_resistance_ohm=bench["shunt_resistance_ohm"],
        wire_length_m=bench["wire_length_m"],
        ambient_temperature_k=bench["ambient_temperature_k"],
        sample_period_s=bench["sample_period_s"],
        wire_range_v=bench["acquisition_range_v"],
        shunt_range_v=bench["acquisition_range_v"],
        readings_noisy=bench["acquisition_noise_v"] / step_v * bench["acquisition_readings"] ** 0.5 >= MIN_SPREAD_STEPS,
        in_series=in_series,
        in_parallel=in_parallel,
    )
    return limits_of(spool.wire, spool.alloy, circuit, changed)


def stepping_of(bench: Numbers) -> StepControl:
    """Return how a bench's samples are divided into steps. Raises CallerError for a step that does not divide them."""
    stepping = StepControl(
        bench["time_step_s"],
        bench["temperature_tolerance_k"],
        bench["resistance_tolerance"],
        bench["strain_tolerance"],
    )
    steps_within(stepping, bench["sample_period_s"])
    return stepping


def require_allowed_pull(pretension_n: float, allowed_n: float, name: str) -> None:
    """Raise CallerError if stage and weights pull a cold wire harder than it allows."""
    if pretension_n > allowed_n:
        raise CallerError(
            f"stage and weight pull the cold wire {name} with {pretension_n:g} N, "
            f"{pretension_n - allowed_n:.3g} N more than the {allowed_n:g} N it allows: a lighter weight, less "
            "pretension or a thicker wire"
        )


def convection_metadata(diameter_m: float, ambient_temperature_k: float) -> Metadata:
    """Return a note for wires so thin that the convection correlation leaves its published range near the air."""
    note = convection_range_note(diameter_m, ambient_temperature_k)
    return {"convection_note": note} if note else {}
