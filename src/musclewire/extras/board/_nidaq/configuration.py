"""The schema of rig files of kind nidaq: the card, the wiring of its terminals, and the wire.

kind = "nidaq"
device = "Dev1"
output_timing = "hardware"
reading_rate = "1 kHz"
readings = 40

[output]
channel = "ao0"

[inputs.wire_voltage]
channel = "ai0"

[inputs.shunt_voltage]
channel = "ai1"
"""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from musclewire.errors import CallerError
from musclewire.extras.board._nidaq.scale import LinearScale
from musclewire.rigs import DeviceConfiguration, LivePeriod, MountedWire
from musclewire.signals import measured_in

# The first reading after the output's clock edge is taken while the output still settles.
SETTLING_READINGS = 1


class ReadingSpan(NamedTuple):
    """The readings of a sample: how many to fetch, and how many of the last ones to average."""

    fetch: int
    average: int
    periods: int


class SamplePeriodLayout(NamedTuple):
    """The division of a sample period: its readings, the averaged ones, and whether the card's clock sets the drive.

    On demand, a period begins with the host's time to decide, in which the drive changes, followed by the averaged
    readings. By the card's clock it begins with one reading to settle, then the averaged ones, then the host's time to
    decide.
    """

    period: int
    readings: int
    clocked: bool

    @property
    def decision(self) -> int:
        """Readings that pass while the host may decide."""
        return self.period - self.readings - (SETTLING_READINGS if self.clocked else 0)

    def first(self) -> ReadingSpan:
        """Return the span of the first sample, whose drive is out before the readings begin."""
        fetch = SETTLING_READINGS + self.readings if self.clocked else self.period
        return ReadingSpan(fetch, self.readings, 1)

    def following(self, waiting: int) -> ReadingSpan:
        """Return the span of a sample whose drive was written after ``waiting`` readings.

        A late host skips whole periods, so that times stay their multiples.
        """
        late = max(0, waiting - self.decision)
        if self.clocked:
            periods = 1 + -(-late // self.period)
            return ReadingSpan(periods * self.period, self.readings, periods)
        # A late write leaves fewer readings of its period; under half of them is too few.
        periods = 1 + late // self.period
        left = periods * self.period - waiting
        if 2 * left < self.readings:
            periods, left = periods + 1, left + self.period
        return ReadingSpan(periods * self.period, min(self.readings, left), periods)


def layout_of(sample_period_s: float, reading_rate_hz: float, readings: int, *, clocked: bool) -> SamplePeriodLayout:
    """Return how a sample period is divided. Raises CallerError if the numbers do not fit together."""
    exact = sample_period_s * reading_rate_hz
    period = round(exact)
    if period < 1 or abs(exact - period) > 1e-6 * exact:
        raise CallerError(
            f"a sample_period of {sample_period_s:g} s has {exact:g} readings at a reading_rate of "
            f"{reading_rate_hz:g} Hz: it must be a whole number"
        )
    layout = SamplePeriodLayout(period, readings, clocked)
    if layout.decision < 1:
        raise CallerError(
            f"readings {readings} of the {period} in a sample period leave the host no time to decide: "
            f"average at most {readings - 1 + layout.decision}"
        )
    return layout


def nonzero_scale(value: float) -> float:
    """Refuse a scale of 0 per volt; a negative one reverses a sensor."""
    if value == 0.0:
        raise ValueError("a scale of 0 per volt would measure nothing: give the instrument's")
    return value


Terminal = Literal["differential", "RSE", "NRSE", "pseudodifferential"]
Hertz = Annotated[float, measured_in("Hz"), Field(gt=0.0, allow_inf_nan=False)]
RangeVolts = Annotated[float, measured_in("V"), Field(gt=0.0, le=60.0)]
Volts = Annotated[float, measured_in("V"), Field(allow_inf_nan=False)]
Gain = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
MetresPerVolt = Annotated[float, measured_in("m/V"), AfterValidator(nonzero_scale), Field(allow_inf_nan=False)]
Metres = Annotated[float, measured_in("m"), Field(allow_inf_nan=False)]
NewtonsPerVolt = Annotated[float, measured_in("N/V"), AfterValidator(nonzero_scale), Field(allow_inf_nan=False)]
Newtons = Annotated[float, measured_in("N"), Field(allow_inf_nan=False)]


class Input(BaseModel):
    """A terminal of the card.

    Parameters
    ----------
    channel
        The card's name of the input, such as ``ai0``.
    terminal
        How it is referred to ground; differential reads a pair of terminals.
    range
        Largest voltage at the terminal to both sides [V]; the card takes the next of its ranges.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    channel: Annotated[str, Field(pattern=r"^ai\d+$")]
    terminal: Terminal = "differential"
    range: RangeVolts = 10.0


class VoltageInput(Input):
    """A voltage of the circuit.

    Parameters
    ----------
    gain
        Volts on the circuit per volt at the terminal: above 1 with a divider, below 1 with an amplifier.
    offset
        Volts on the circuit when the terminal reads 0 V [V]; ``musclewire doctor --write`` finds both.
    """

    gain: Gain = 1.0
    offset: Volts = 0.0

    @property
    def rule(self) -> LinearScale:
        """How volts at the terminal become volts on the circuit."""
        return LinearScale(self.gain, self.offset)


class DisplacementInput(Input):
    """A displacement sensor with a voltage output: an LVDT's conditioner or a laser.

    Parameters
    ----------
    scale
        Contraction per volt at the terminal [m/V]; negative if the sensor counts the other way.
    offset
        Contraction when the terminal reads 0 V [m].
    """

    scale: MetresPerVolt
    offset: Metres = 0.0

    @property
    def rule(self) -> LinearScale:
        """How volts become metres."""
        return LinearScale(self.scale, self.offset)


class ForceInput(Input):
    """A load cell with its amplifier.

    Parameters
    ----------
    scale
        Pull per volt at the terminal [N/V]; negative if the cell counts the other way.
    offset
        Pull when the terminal reads 0 V [N].
    """

    scale: NewtonsPerVolt
    offset: Newtons = 0.0

    @property
    def rule(self) -> LinearScale:
        """How volts become newtons."""
        return LinearScale(self.scale, self.offset)


class Inputs(BaseModel):
    """The wiring of the inputs: always both voltages, and reference instruments if there are any."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    wire_voltage: VoltageInput
    shunt_voltage: VoltageInput
    displacement: DisplacementInput | None = None
    force: ForceInput | None = None
    endpoint_displacement: DisplacementInput | None = None
    endpoint_force: ForceInput | None = None

    def wired(self) -> dict[str, VoltageInput | DisplacementInput | ForceInput]:
        """Return the inputs that are wired, by the names of their quantities."""
        found = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: item for name, item in found.items() if item is not None}


class Output(BaseModel):
    """The output that drives the circuit through a buffer amplifier.

    Parameters
    ----------
    channel
        The card's name of the output.
    range
        Largest voltage of the card to both sides [V].
    gain
        Drive volts per volt of the card: the buffer amplifier's.
    offset
        Drive voltage when the card applies 0 V [V].
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    channel: Annotated[str, Field(pattern=r"^ao\d+$")] = "ao0"
    range: RangeVolts = 10.0
    gain: Gain = 1.0
    offset: Volts = 0.0

    @property
    def rule(self) -> LinearScale:
        """How volts of the card become the drive voltage."""
        return LinearScale(self.gain, self.offset)


class NiDaqConfiguration(DeviceConfiguration, MountedWire):
    """A rig file of an NI card; the wire's keys are those of every real rig (``MountedWire``).

    Attributes:
        sample_period: time between samples, at most 50 ms, so that every fault ends with 0 V within half a second.
        device: the card's name in NI MAX.
        grpc: address of an NI gRPC device server, if the card is in another machine.
        output_timing: ``hardware``: the drive changes at the card's clock edges (hardware-timed single point);
            ``on-demand``: when the host writes it.
        reading_rate: readings of each channel per second.
        readings: number of a sample period's readings that are averaged; the rest is the host's time to decide.
        output: ``[output]``: the channel that drives the circuit.
        inputs: ``[inputs.NAME]``: the channels that are read; wire_voltage and shunt_voltage always, displacement,
            force, endpoint_displacement and endpoint_force if there are such instruments.
        lockstep: whether time passes only by reading, in an emulator: the host's clock then says nothing.
    """

    kind: Literal["nidaq"]
    sample_period: LivePeriod = 0.05
    device: Annotated[str, Field(min_length=1)]
    grpc: str | None = None
    output_timing: Literal["hardware", "on-demand"] = "on-demand"
    reading_rate: Hertz = 1000.0
    readings: Annotated[int, Field(ge=1)]
    output: Output = Output()
    inputs: Inputs
    lockstep: bool = False

    @model_validator(mode="after")
    def _fits_together(self) -> NiDaqConfiguration:
        try:
            self.layout()
        except CallerError as error:
            raise ValueError(str(error)) from None
        channels = [item.channel for item in self.inputs.wired().values()]
        twice = next((name for name in channels if channels.count(name) > 1), None)
        if twice:
            raise ValueError(f"the channel {twice} is named for two inputs: give each its own")
        rule = self.output.rule
        for voltage_v in (0.0, self.maximum_voltage):
            if abs(rule.voltage_v(voltage_v)) > self.output.range:
                raise ValueError(
                    f"a drive of {voltage_v:g} V needs {rule.voltage_v(voltage_v):g} V at {self.output.channel}, "
                    f"outside its range of {self.output.range:g} V to both sides: a larger range, or a lower "
                    "maximum_voltage"
                )
        return self

    def layout(self) -> SamplePeriodLayout:
        """Return how a sample period is divided. Raises CallerError if the numbers do not fit together."""
        clocked = self.output_timing == "hardware"
        return layout_of(self.sample_period, self.reading_rate, self.readings, clocked=clocked)
