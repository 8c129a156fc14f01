"""Rig files of kind "segmented": their schema, and what opens the device."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.extras.studies._segmented.conditions import Conditions, ConditionsInTime, LocalDraughts, steady
from musclewire.extras.studies._segmented.device import SegmentedDevice, SegmentedSpool
from musclewire.extras.studies._segmented.instruments import InstrumentSettings
from musclewire.extras.studies._segmented.structure import (
    NormalMixture,
    WireAgeing,
    WireStructure,
    mixture_distribution,
)
from musclewire.extras.studies._segmented.wire import DEFAULT_STEP_S
from musclewire.parameters import load_alloy
from musclewire.rigs import (
    AirKelvins,
    DeviceConfiguration,
    DeviceKind,
    LimitsTable,
    SiName,
    WireKeys,
    numbers_given,
    wire_on_bench,
)
from musclewire.signals import measured_in
from musclewire.wire import ONE_CLASS, BarrierClass

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Fraction = Annotated[float, Field(ge=0.0, le=0.3)]
Kelvins = Annotated[float, measured_in("K", difference=True), Field(allow_inf_nan=False)]
SomeKelvins = Annotated[float, measured_in("K", difference=True), Field(ge=0.0, allow_inf_nan=False)]
Newtons = Annotated[float, measured_in("N"), Field(allow_inf_nan=False)]
Ohms = Annotated[float, measured_in("ohm"), Field(ge=0.0, allow_inf_nan=False)]
Seconds = Annotated[float, measured_in("s"), Field(gt=0.0, allow_inf_nan=False)]
Volts = Annotated[float, measured_in("V"), Field(gt=0.0, allow_inf_nan=False)]
NoiseVolts = Annotated[float, measured_in("V"), Field(ge=0.0, allow_inf_nan=False)]
Conductivity = Annotated[float, measured_in("W/(m K)"), Field(gt=0.0, allow_inf_nan=False)]

STREAM = 7937


class RigFileTable(BaseModel):
    """A table of a rig file."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class GrainsTable(RigFileTable):
    """A normal population of grains.

    Parameters
    ----------
    weight
        Fraction of the grains; all weights add up to 1.
    mean
        Mean offset of its transformation temperatures, in units of the alloy's spread.
    deviation
        Their standard deviation, in the same unit.
    """

    weight: Positive
    mean: Annotated[float, Field(allow_inf_nan=False)]
    deviation: Positive


class BarrierTable(RigFileTable):
    """A class of grains.

    Parameters
    ----------
    weight
        Fraction of the grains; all weights add up to 1.
    barrier
        Barrier between austenite and martensite beyond that of the alloy [K].
    """

    weight: Positive
    barrier: Kelvins


class AgeingTable(RigFileTable):
    """What the wire changes by use.

    Parameters
    ----------
    cycles_scale
        Cycles over which the effects grow as ln(1 + cycles / cycles_scale).
    residual_strain
        Strain that the wire gains, per unit of that logarithm.
    resistance
        Relative rise of its resistance, per unit.
    temperature
        Rise of its transformation temperatures [K], per unit.
    cycles_before
        Cycles that the wire has behind it at the start.
    """

    cycles_scale: Positive = 20.0
    residual_strain: float = 0.0
    resistance: float = 0.0
    temperature: Kelvins = 0.0
    cycles_before: NotNegative = 0.0


class ConditionsTable(RigFileTable):
    """Constant conditions; programs may give a function of time instead (``SegmentedDevice.conditions``).

    Parameters
    ----------
    ambient
        Temperature of the air and of the clamps [K]; by default that of the bench, at which the wire was zeroed.
    convection_factor
        Loss to the air as a multiple of that in still air.
    load_force
        Constant force that adds to the load [N].
    stiffness_factor
        Stiffness of the spring as a multiple of the bench's.
    pretension_force
        Force that the spring's foot adds [N].
    resistance_factor
        Resistance of the wire as a multiple of its own.
    transformation_shift
        Rise of all transformation temperatures [K].
    draught
        Draughts that differ along the wire: standard deviation of convection, as a fraction.
    draught_time
        How long a draught lasts [s].
    draught_reach
        Correlation of the draughts of neighbouring segments.
    """

    ambient: AirKelvins | None = None
    convection_factor: Positive = 1.0
    load_force: Newtons = 0.0
    stiffness_factor: NotNegative = 1.0
    pretension_force: Newtons = 0.0
    resistance_factor: Positive = 1.0
    transformation_shift: Kelvins = 0.0
    draught: Fraction = 0.0
    draught_time: Seconds = 3.0
    draught_reach: Annotated[float, Field(ge=0.0, le=1.0)] = 0.7

    def in_time(self, n_segments: int, seed: int) -> ConditionsInTime:
        """Return the conditions as a function of time."""
        still = steady(
            Conditions(
                ambient_k=self.ambient,
                convection_factor=self.convection_factor,
                load_force_n=self.load_force,
                stiffness_factor=self.stiffness_factor,
                pretension_force_n=self.pretension_force,
                resistance_factor=self.resistance_factor,
                transformation_shift_k=self.transformation_shift,
            )
        )
        if self.draught == 0.0:
            return still
        draughts = {"strength": self.draught, "lasting_s": self.draught_time, "reach": self.draught_reach}
        return LocalDraughts(still, n_segments, seed=seed, **draughts)


class InstrumentsTable(RigFileTable):
    """Instruments where they differ from the bench's.

    Parameters
    ----------
    voltage_noise
        Noise of a reading [V], rms.
    bits
        Resolution of the converter.
    wire_range
        End of the range of the wire's channel [V].
    shunt_range
        End of the range of the shunt's channel [V].
    bipolar
        Whether the steps of the converter cover both sides of 0.
    readings
        Readings averaged into a sample.
    wire_gain
        Readings as a multiple of the wire's true voltage.
    shunt_gain
        Readings as a multiple of the shunt's true voltage.
    lead_resistance
        Leads within the measured voltage of the wire [ohm].
    contact_jump
        Resistance that a bad contact adds while it is bad [ohm].
    contact_interval
        Mean time until the contact changes [s].
    clock_jitter
        Standard deviation of a sample's time as a fraction of the period.
    """

    voltage_noise: Annotated[NoiseVolts | None, SiName("voltage_noise_v")] = None
    bits: Annotated[int, Field(ge=1, le=32)] | None = None
    wire_range: Annotated[Volts | None, SiName("wire_range_v")] = None
    shunt_range: Annotated[Volts | None, SiName("shunt_range_v")] = None
    bipolar: bool | None = None
    readings: Annotated[int, Field(ge=1)] | None = None
    wire_gain: Positive | None = None
    shunt_gain: Positive | None = None
    lead_resistance: Annotated[Ohms | None, SiName("lead_resistance_ohm")] = None
    contact_jump: Annotated[Ohms | None, SiName("contact_jump_ohm")] = None
    contact_interval: Annotated[Seconds | None, SiName("contact_interval_s")] = None
    clock_jitter: Annotated[float, Field(ge=0.0, le=0.2)] | None = None

    def over(self, settings: InstrumentSettings) -> InstrumentSettings:
        """Return instruments with what the table sets."""
        return settings._replace(**numbers_given(self))


class SegmentedConfiguration(WireKeys, DeviceConfiguration):
    """A rig file of a simulated wire in segments. The keys of wire and circuit are those of the simulated rig.

    Parameters
    ----------
    kind
        "segmented".
    wire
        Name of a wire, or a wire file next to the rig file.
    bench
        Name of a bench.
    seed
        Seed of noise, draughts and of what differs along the wire.
    segments
        Number of segments along the wire.
    clamped
        Whether both ends are held by clamps as cold as the air.
    thermal_conductivity
        Along the wire [W/(m K)].
    temperature_spread
        Standard deviation of the transformation temperatures along the wire [K].
    convection_spread
        Standard deviation of convection along the wire, as a fraction.
    time_step
        Longest step of the simulation [s].
    grains
        Normal populations of grains; by default the alloy's distribution.
    barriers
        Classes of grains by their barrier; by default one.
    ageing
        What the wire changes by use.
    conditions
        Constant conditions and draughts.
    instruments
        Instruments that differ from the bench's.
    limits
        Limits of the protection that replace those which follow from wire and circuit.
    """

    kind: Literal["segmented"] = "segmented"
    wire: str = "paper-100um"
    bench: str = "paper"
    seed: int = Field(default=1, ge=0)
    segments: Annotated[int, Field(ge=1, le=1000)] = 12
    clamped: bool = True
    thermal_conductivity: Conductivity = 18.0
    temperature_spread: SomeKelvins = 0.0
    convection_spread: Fraction = 0.0
    time_step: Seconds = DEFAULT_STEP_S
    grains: list[GrainsTable] = Field(default_factory=list)
    barriers: list[BarrierTable] = Field(default_factory=list)
    ageing: AgeingTable = AgeingTable()
    conditions: ConditionsTable = ConditionsTable()
    instruments: InstrumentsTable = InstrumentsTable()
    limits: LimitsTable = LimitsTable()

    @model_validator(mode="after")
    def _weights_add_up(self) -> SegmentedConfiguration:
        for name in ("grains", "barriers"):
            total = sum(part.weight for part in getattr(self, name))
            if getattr(self, name) and abs(total - 1.0) > 1e-9:
                raise ValueError(f"the weights of {name} add up to {total:g}: they must add up to 1")
        return self

    def structure(self) -> WireStructure:
        """Return what the file says of segments, grains, barriers and ageing."""
        random = np.random.default_rng([self.seed, STREAM])
        strengths = np.clip(random.standard_normal((2, self.segments)), -3.0, 3.0)
        ageing = self.ageing
        return WireStructure(
            n_segments=self.segments,
            clamped=self.clamped,
            thermal_conductivity_w_per_m_k=self.thermal_conductivity,
            temperature_shifts_k=tuple(self.temperature_spread * strengths[0]),
            convection_factors=tuple(1.0 + self.convection_spread * strengths[1]),
            classes=tuple(BarrierClass(one.weight, one.barrier) for one in self.barriers) or ONE_CLASS,
            grains=mixture_distribution([NormalMixture(one.weight, one.mean, one.deviation) for one in self.grains])
            if self.grains
            else None,
            ageing=WireAgeing(
                ageing.cycles_scale, ageing.residual_strain, ageing.resistance, ageing.temperature, ageing.cycles_before
            ),
        )


def opened(configuration: SegmentedConfiguration) -> SegmentedDevice:
    """Return the device of a rig file, cold and at 0 V. Raises CallerError for numbers that cannot be."""
    stated = configuration.bench if "bench" in configuration.model_fields_set else None
    names = configuration.numbers_set()
    wire, bench = wire_on_bench(configuration.wire, stated, names, configuration.number, "rig file")
    structure = configuration.structure()
    return SegmentedDevice(
        SegmentedSpool(wire, load_alloy(wire.alloy), bench, structure, configuration.time_step),
        conditions=configuration.conditions.in_time(structure.n_segments, configuration.seed),
        instruments=configuration.instruments.over(InstrumentSettings.of_bench(bench.values())),
        seed=configuration.seed,
        limits=configuration.limits.changed(),
    )


SEGMENTED = DeviceKind(SegmentedConfiguration, opened)
