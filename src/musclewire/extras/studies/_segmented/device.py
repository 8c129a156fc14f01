"""A wire in segments as a device: driven sample by sample, under conditions that change, with any instruments."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from typing import NamedTuple

from musclewire.errors import CallerError
from musclewire.extras.studies._segmented.conditions import ConditionsInTime, steady
from musclewire.extras.studies._segmented.instruments import InstrumentSettings, RunningInstruments
from musclewire.extras.studies._segmented.structure import WireStructure
from musclewire.extras.studies._segmented.wire import DEFAULT_STEP_S, SegmentedState, SegmentedWire
from musclewire.parameters import Alloy, Bench, Wire, require_seed, validity_of
from musclewire.rigs import SWITCHED_OFF, Answer, DeviceFacts, Metadata, WireCircuit, convection_metadata, limits_of
from musclewire.signals import Command, RawSample, drive_voltage_of


class SegmentedSpool(NamedTuple):
    """A wire in segments and its bench, as numbers.

    Parameters
    ----------
    wire, alloy, bench
        Numbers of wire, alloy and bench; the bench's spring is the load.
    structure
        How the wire is divided, and what its segments are made of.
    step_s
        Longest step of the simulation [s]; the default changes strain by 0.02 % of stroke.
    """

    wire: Wire
    alloy: Alloy
    bench: Bench
    structure: WireStructure = WireStructure()
    step_s: float = DEFAULT_STEP_S

    def wire_at(self, pretension_n: float) -> SegmentedWire:
        """Return the wire, cold and at rest.

        Parameters
        ----------
        pretension_n
            Force of the cold wire [N], both legs together.

        Returns
        -------
        A wire of its own at each call.

        Raises
        ------
        CallerError
            For a force that the wire does not allow.
        """
        allowed = self.wire.maximum_force_n.value
        if not 0.0 <= pretension_n <= allowed:
            raise CallerError(f"pretension {pretension_n} N is outside 0 to {allowed} N, what {self.wire.name} allows")
        changed = self.bench.pretension_n.model_copy(update={"value": pretension_n})
        around = self.bench.model_copy(update={"pretension_n": changed})
        return SegmentedWire(self.alloy, self.wire, around, self.structure, self.step_s)


class SegmentedDevice:
    """A simulated wire of segments on a bias spring, repeatable to the bit for one seed.

    Its structure differs from that of the model that estimators and calibrations use: several temperatures, cold ends,
    draughts along the wire, several classes of barrier, another distribution of grains, ageing by use. Hold it by a
    :class:`~musclewire.rigs._guarded.GuardedRig`.

    Parameters
    ----------
    spool
        The wire, its alloy, its bench and its structure.
    conditions
        Asked before each sample with the time [s]; those of the bench if None. May be replaced at any time.
    instruments
        Converters, leads, contacts, clock and reference instruments; those of the bench if None.
    seed
        Seed of the instruments' noise.
    limits
        Limits of the protection that differ from those that follow from wire and bench; none if None.

    Attributes
    ----------
    conditions
        What is asked before each sample.

    Raises
    ------
    CallerError
        For numbers that cannot belong to a wire, a bench or instruments.

    Examples
    --------
    >>> from musclewire.parameters._library import load_alloy, load_bench, load_wire
    >>> from musclewire.rigs._guarded import GuardedRig
    >>> from musclewire.extras.studies._segmented.conditions import Conditions
    >>> from musclewire.extras.studies._segmented.device import SegmentedDevice, SegmentedSpool
    >>> spool = SegmentedSpool(load_wire("paper-100um"), load_alloy("flexinol"), load_bench("paper"))
    >>> def a_draught_from_one_second_on(time_s):
    ...     return Conditions(convection_factor=2.0 if time_s > 1.0 else 1.0)
    >>> with GuardedRig(SegmentedDevice(spool, conditions=a_draught_from_one_second_on)) as rig:
    ...     sample = rig.exchange(1.0)
    >>> sample.time_s
    0.05
    """

    partner_state: None = None

    def __init__(
        self,
        spool: SegmentedSpool,
        *,
        conditions: ConditionsInTime | None = None,
        instruments: InstrumentSettings | None = None,
        seed: int = 1,
        limits: Mapping[str, float] | None = None,
    ) -> None:
        """Cool the wire under its pretension and wait at 0 V."""
        self.conditions = conditions or steady()
        self._spool, self._bench = spool, spool.bench.values()
        self._seed = require_seed(seed)
        self._pretension_n = self._bench["pretension_n"]
        self._wire = spool.wire_at(self._pretension_n)
        settings = instruments or InstrumentSettings.of_bench(self._bench)
        period_s = self._bench["sample_period_s"]
        self._instruments = RunningInstruments(settings, self._seed, period_s)
        self._samples, self._zero_m = 0, 0.0
        self._drive_voltage_v, self._off = 0.0, False
        circuit = WireCircuit(
            sense_voltage_v=self._bench["sense_voltage_v"],
            maximum_voltage_v=spool.wire.maximum_voltage_v.value,
            shunt_resistance_ohm=self._bench["shunt_resistance_ohm"],
            wire_length_m=self._bench["wire_length_m"],
            ambient_temperature_k=self._bench["ambient_temperature_k"],
            sample_period_s=period_s,
            wire_range_v=settings.wire_range_v,
            shunt_range_v=settings.shunt_range_v,
            readings_noisy=settings.readings_noisy,
        )
        own_limits = limits_of(spool.wire, spool.alloy, circuit, limits)
        self._facts = DeviceFacts(
            sample_period_s=period_s,
            paced=False,
            leg_length_m=self._wire.leg_length_m,
            drive_amplitude_v=spool.wire.drive_amplitude_v.value,
            limits=own_limits,
            reference_columns=("displacement_m", "force_n"),
            wire_temperature_k=own_limits.ambient_temperature_k,
        )

    @property
    def facts(self) -> DeviceFacts:
        """Facts of the bench and its wire."""
        return self._facts

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage at the output now [V]."""
        return self._drive_voltage_v

    @property
    def wire_state(self) -> SegmentedState:
        """The true state of the wire, for judging a simulation and never for an estimator."""
        return self._wire.state

    @property
    def wire(self) -> SegmentedWire:
        """The simulated wire itself, with its energies; for checks."""
        return self._wire

    @property
    def instruments(self) -> InstrumentSettings:
        """Numbers of the instruments."""
        return self._instruments.settings

    def __repr__(self) -> str:
        """Name the wire, its segments and its drive."""
        return (
            f"SegmentedDevice(wire {self._spool.wire.name}, {self._spool.structure.n_segments} segments, drive "
            f"{self._drive_voltage_v:.3f} V, at {self._time_s:.2f} s)"
        )

    @property
    def _time_s(self) -> float:
        """Time [s] that the clock of the device shows."""
        return self._samples * self._facts.sample_period_s

    def metadata(self) -> Metadata:
        """Return the metadata of a recording that describe this device."""
        wire = self._spool.wire
        return {
            "rig": "segmented",
            "wire": wire.name,
            "wire_diameter_m": wire.diameter_m.value,
            **convection_metadata(wire.diameter_m.value, self._bench["ambient_temperature_k"]),
            **validity_of(self._spool.alloy).facts(),
            "wire_length_m": self._bench["wire_length_m"],
            "leg_length_m": self._facts.leg_length_m,
            "shunt_resistance_ohm": self._facts.limits.shunt_resistance_ohm,
            "maximum_force_n": wire.maximum_force_n.value,
            "force_limit_n": wire.maximum_force_n.value,
            "pretension_n": self._pretension_n,
            "spring_stiffness_n_per_m": self._bench["spring_stiffness_n_per_m"],
            "sample_period_s": self._facts.sample_period_s,
            "time_step_s": self._spool.step_s,
            "segments": self._spool.structure.n_segments,
            "seed": self._seed,
            "step_error_k": self._wire.sums["step_error_k"],
        }

    def set_pretension(self, pretension_n: float) -> None:
        """Let the wire cool, then move the stage; the instruments are zeroed there.

        Clock and cycles continue; the wire cools in the air of the bench, and the next sample meets the conditions of
        its time again.

        Parameters
        ----------
        pretension_n
            Force of the cold wire [N], both legs together.

        Raises
        ------
        CallerError
            For a force that the wire does not allow.
        """
        self._drive_voltage_v = 0.0
        wire = self._spool.wire_at(pretension_n)
        wire.age_like(self._wire)
        self._wire, self._pretension_n, self._zero_m = wire, pretension_n, 0.0

    def zero_displacement(self) -> None:
        """Zero the displacement sensor again, where the connector is now; the true strain keeps its own."""
        self._zero_m = self._wire.state.strain * self._facts.leg_length_m

    def exchange_instruments(self, instruments: InstrumentSettings, seed: int | None = None) -> None:
        """Measure with other instruments from now on.

        Parameters
        ----------
        instruments
            Their numbers.
        seed
            Seed of their noise; None for that of the device.

        Raises
        ------
        CallerError
            For numbers that no instrument has, and for instruments with other ranges or without the noise that the
            protection's limits were made for: those belong to the device from the beginning.
        """
        limits = self._facts.limits
        same = (instruments.wire_range_v, instruments.shunt_range_v) == (limits.wire_range_v, limits.shunt_range_v)
        if not same or (limits.readings_noisy and not instruments.readings_noisy):
            raise CallerError(
                "instruments with other ranges, or so coarse that readings repeat, change what the protection takes "
                "for a fault: make the device with them"
            )
        drawn_from = self._seed if seed is None else require_seed(seed)
        self._instruments = RunningInstruments(instruments, drawn_from, self._facts.sample_period_s)

    def compile_exchange(self) -> None:
        """Compile all that an exchange runs, by a sample of a copy of the wire at 0 V."""
        deepcopy(self._wire).advance(0.0, self._facts.sample_period_s, 0.0)

    def exchange(self, command: Command) -> Answer:
        """Hold a drive voltage for one sample period and return the averaged readings at its end."""
        resolution_v = self._bench["amplifier_resolution_v"]
        self._drive_voltage_v = resolution_v * round(drive_voltage_of(command) / resolution_v)
        if self._off:  # looked at after it was applied, so that 0 V is the last word whichever thread comes first
            self._drive_voltage_v = 0.0
            return SWITCHED_OFF
        drive_v, instruments = self._drive_voltage_v, self._instruments
        self._wire.surround(self.conditions(self._time_s))
        means = self._wire.advance(drive_v, instruments.duration_s(), instruments.lead_ohm())
        self._samples += 1
        true = (means.wire_voltage_v, means.shunt_voltage_v, means.displacement_m - self._zero_m, means.force_n)
        wire_v, shunt_v, displacement_m, force_n = instruments.sample(true)
        return RawSample(self._time_s, drive_v, wire_v, shunt_v, displacement_m, force_n)

    def sense(self) -> bool:
        """Go to the sense voltage at once."""
        self._drive_voltage_v = self._facts.limits.sense_voltage_v
        return True

    def off(self) -> bool:
        """Switch the drive off."""
        self._off, self._drive_voltage_v = True, 0.0
        return True
