"""The keys of a rig file for the mounted wire, its circuit and its protection, each written once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic.fields import FieldInfo

from musclewire.controllers import ProtectionLimits
from musclewire.parameters import Wire, load_alloy, load_wire, validity_of
from musclewire.rigs._beyond_catalogue import WAY_OUT, StatedCircuit, confirmed_beyond, refuse_beyond_catalogue
from musclewire.rigs._device import Metadata
from musclewire.rigs._own_voltages import GivenVoltages, voltages_of_circuit
from musclewire.rigs._wire_limits import WireCircuit, limits_of
from musclewire.signals import measured_in


@dataclass(frozen=True)
class SiName:
    """Note on a key of a rig file: the name, with the unit, of the number that it sets."""

    name: str


def refuse_truth(given: Any) -> Any:
    """Return what is given for a number. Raises ValueError for true and false, which count as 1 and 0 elsewhere."""
    if isinstance(given, bool):
        raise ValueError(f"{str(given).lower()} is no number: give one in SI, or text with a unit")
    return given


NO_TRUTH = BeforeValidator(refuse_truth)
# A hundred thousand samples a second: faster than any converter that the product knows, and a loop of it still ends.
MIN_PERIOD_S = 1e-5
# Error of a multimeter or a supply's display on their best range, generously.
METER_ERROR = 0.02
Amperes = Annotated[float, measured_in("A"), Field(gt=0.0, allow_inf_nan=False)]
Kelvins = Annotated[float, measured_in("K"), Field(gt=0.0, allow_inf_nan=False)]
Ohms = Annotated[float, measured_in("ohm"), Field(gt=0.0, allow_inf_nan=False)]
Volts = Annotated[float, measured_in("V"), Field(gt=0.0, allow_inf_nan=False)]
Watts = Annotated[float, measured_in("W"), Field(gt=0.0, allow_inf_nan=False)]
# Air around a bench. A bare 22 would be read as kelvins, and air that cold would let the wire grow too hot.
AirKelvins = Annotated[float, measured_in("K"), Field(ge=223.15, le=373.15)]
# A fault shows in the next samples: with longer periods a frozen channel would not be off within half a second.
LivePeriod = Annotated[
    float,
    SiName("sample_period_s"),
    measured_in("s"),
    Field(gt=0.0, le=0.05 + 1e-9, description="Time between samples [s], at most 50 ms for a fault to end in time."),
]

# The keys of wire and circuit, each written once: the number that it sets (of wire or bench, and in a recording's
# metadata), its unit, its range, its meaning. Rig files of all kinds take their keys from here.
WireLength = Annotated[
    float,
    SiName("wire_length_m"),
    measured_in("m"),
    Field(gt=0.0, allow_inf_nan=False, description="Overall length between the terminals [m]."),
]
Legs = Annotated[
    int,
    SiName("legs"),
    Field(ge=1, le=2, description="Parts of the wire that share the force: 2 for a V, 1 for a straight wire."),
]
Shunt = Annotated[Ohms, SiName("shunt_resistance_ohm"), Field(description="R of Eq. 1 [ohm].")]
SenseVoltage = Annotated[
    Volts,
    SiName("sense_voltage_v"),
    Field(description="Drive that hardly heats the wire and still gives a reading [V]."),
]
MaximumVoltage = Annotated[
    Volts,
    SiName("maximum_voltage_v"),
    Field(description="Highest drive that is ever allowed [V]; it depends on the length of the wire."),
]
DriveAmplitude = Annotated[Volts, SiName("drive_amplitude_v"), Field(description="Amplitude of the slow sine [V].")]
Pretension = Annotated[
    float,
    SiName("pretension_n"),
    measured_in("N"),
    Field(ge=0.0, allow_inf_nan=False, description="Force of the cold wire [N], as set by hand."),
]
AmbientTemperature = Annotated[
    AirKelvins, SiName("ambient_temperature_k"), Field(description="Temperature of the air around the wire [K].")
]
LossFactor = Annotated[
    float,
    Field(
        gt=0.0,
        le=100.0,
        allow_inf_nan=False,
        description="Heat loss, as a fraction of the bare wire's in still air: less than 1 in a sleeve or foam.",
    ),
]
SamplePeriod = Annotated[
    float,
    SiName("sample_period_s"),
    measured_in("s"),
    Field(ge=MIN_PERIOD_S, le=1.0, description="Time between samples [s]."),
]


def notes_of(key: Any) -> tuple[Any, ...]:
    """Return the notes on a key, given its type or its field, whether or not it may be left out."""
    if isinstance(key, FieldInfo):
        return (*key.metadata, *(note for kind in get_args(key.annotation) for note in notes_of(kind)))
    return tuple(getattr(key, "__metadata__", ())) or tuple(note for kind in get_args(key) for note in notes_of(kind))


def may_be_left_out(key: Any) -> Any:
    """Return the field of a key that is None in files without it, with the meaning that its type states."""
    meaning = next(note.description for note in notes_of(key) if isinstance(note, FieldInfo) and note.description)
    return Field(default=None, description=meaning)


def follows_the_wire(key: Any) -> Any:
    """Return the field of a voltage that a file may leave to the wire, for its length, diameter and circuit."""
    meaning = next(note.description for note in notes_of(key) if isinstance(note, FieldInfo) and note.description)
    left_out = "by default what `musclewire simulate --table` lists, for this wire, length and circuit"
    return Field(default=None, description=f"{meaning.removesuffix('.')}; {left_out}.")


def si_name(key: str, field: FieldInfo) -> str:
    """Return the name of the number that a key of a rig file sets: that of its note, else its own."""
    return next((note.name for note in notes_of(field) if isinstance(note, SiName)), key)


def numbers_given(table: BaseModel) -> dict[str, Any]:
    """Return what a table of a rig file sets, by the names of the numbers."""
    fields = type(table).model_fields
    return {si_name(key, fields[key]): value for key, value in table if value is not None}


class LimitsTable(BaseModel):
    """``[limits]`` of a rig file: limits of the protection that differ from what follows from wire and circuit.

    Attributes:
        maximum_current: a higher current is over-current.
        maximum_power: a higher electrical power in the wire is over-power.
        maximum_temperature: highest allowed temperature, estimated from the power.
        minimum_current: below this current a driven wire counts as open.
        resistance_low: lowest resistance that this wire can have.
        resistance_high: highest resistance that it can have.
        jump_share: relative change of resistance from one reading to the next that heating cannot explain.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    maximum_current: Annotated[Amperes | None, SiName("maximum_current_a")] = None
    maximum_power: Annotated[Watts | None, SiName("maximum_power_w")] = None
    maximum_temperature: Annotated[Kelvins | None, SiName("maximum_temperature_k")] = None
    minimum_current: Annotated[Amperes | None, SiName("minimum_current_a")] = None
    resistance_low: Annotated[Ohms | None, SiName("resistance_low_ohm")] = None
    resistance_high: Annotated[Ohms | None, SiName("resistance_high_ohm")] = None
    jump_share: Annotated[float, Field(gt=0.0, le=1.0)] | None = None

    def changed(self) -> dict[str, float]:
        """Return what is set, by the names of ``ProtectionLimits``."""
        return {name: float(value) for name, value in numbers_given(self).items()}


class Arriving(BaseModel):
    """``[arrives]`` of a rig file: a voltage at wire and shunt that something else than the rig's channels has shown.

    By it the protection counts with less than what is ordered; without it the order counts.

    Attributes:
        ordered: drive that was ordered.
        measured: largest voltage across wire and shunt together at this order.
        by: a ``multimeter`` of yours, the ``supply``'s display, or a ``circuit`` that lets no more through.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    ordered: Volts
    measured: Volts
    by: Literal["multimeter", "supply", "circuit"]

    def facts(self) -> Metadata:
        """Return what a recording states of it; the largest fraction is a limit of the protection."""
        return {"arriving_fraction_by": self.by, "arriving_fraction_least": self.fractions[0]}

    @property
    def fractions(self) -> tuple[float, float]:
        """Least and largest fraction of an order that is at wire and shunt, by the instrument's error."""
        fraction = self.measured / self.ordered
        return min((1.0 - METER_ERROR) * fraction, 1.0), min((1.0 + METER_ERROR) * fraction, 1.0)


class MountedWire(BaseModel):
    """The wire on a real rig and its circuit. Numbers in SI or as text with a unit; each type says what its key means.

    Parameters
    ----------
    wire
        A wire's name (``musclewire simulate --list``) or wire file.
    limits
        Limits of the protection that replace those which follow from wire and circuit.
    arrives
        How much of an ordered voltage is at the wire, if not all of it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    wire: str
    wire_length: WireLength
    legs: Legs = 2
    shunt: Shunt
    sense_voltage: SenseVoltage
    maximum_voltage: MaximumVoltage = follows_the_wire(MaximumVoltage)
    drive_amplitude: DriveAmplitude = follows_the_wire(DriveAmplitude)
    pretension: Pretension | None = may_be_left_out(Pretension)
    ambient_temperature: AmbientTemperature = 295.15
    loss_factor: LossFactor = 1.0
    sample_period: SamplePeriod = 0.05
    limits: LimitsTable = LimitsTable()
    arrives: Arriving | None = None
    beyond_catalogue: bool = Field(
        default_factory=confirmed_beyond,
        description="Whether numbers that no wire of the catalogue has or survives are meant so.",
    )

    @model_validator(mode="after")
    def _is_of_the_catalogue(self) -> MountedWire:
        if not self.beyond_catalogue:
            stated = {"maximum_voltage": self.maximum_voltage, "drive_amplitude": self.drive_amplitude}
            circuit = StatedCircuit(self.wire_length, self.shunt, {"wire_length": self.wire_length, **stated})
            refuse_beyond_catalogue(circuit, self.limits.changed())
        return self

    @model_validator(mode="after")
    def _loss_is_no_more_than_known(self) -> MountedWire:
        if self.loss_factor > 1.0 and not self.beyond_catalogue:
            raise ValueError(
                f"loss_factor {self.loss_factor:g} is more than still air takes, and lets the wire be heated more: "
                "leave it out, or confirm it" + WAY_OUT
            )
        return self

    @model_validator(mode="after")
    def _voltages_follow_the_wire(self) -> MountedWire:
        given = GivenVoltages(*(dict(self)[key] for key in ("drive_amplitude", "maximum_voltage")))
        amplitude_v, maximum_v = given.amplitude_v, given.maximum_v
        if amplitude_v is None or maximum_v is None:  # a file that states both is checked without its wire
            amplitude_v, maximum_v = voltages_of_circuit(
                given,
                self.wire,
                wire_length_m=self.wire_length,
                shunt_ohm=self.shunt,
                ambient_temperature_k=self.ambient_temperature,
                loss_factor=self.loss_factor,
            )
        # As pydantic's documentation has it for a frozen model that completes itself.
        object.__setattr__(self, "drive_amplitude", amplitude_v)
        object.__setattr__(self, "maximum_voltage", maximum_v)
        return self

    @model_validator(mode="after")
    def _voltages_rise(self) -> MountedWire:
        if not self.sense_voltage < self.drive_amplitude <= self.maximum_voltage:
            raise ValueError(
                f"sense_voltage {self.sense_voltage:g} V, drive_amplitude {self.drive_amplitude:g} V and "
                f"maximum_voltage {self.maximum_voltage:g} V must rise in this order"
            )
        return self

    @property
    def leg_length_m(self) -> float:
        """Length whose relative shortening is the strain [m]."""
        return self.wire_length / self.legs

    def known_wire(self) -> Wire:
        """Return the wire's parameters. Raises CallerError for an unknown wire or a wrong file."""
        return load_wire(self.wire)

    def protection_limits(
        self, *, wire_range_v: float, shunt_range_v: float, readings_noisy: bool = True
    ) -> ProtectionLimits:
        """Return the limits of the protection for this wire on its circuit.

        Parameters
        ----------
        wire_range_v
            End of the range [V] of the channel that reads the wire.
        shunt_range_v
            End of the range [V] of the channel that reads the shunt.
        readings_noisy
            Whether noise changes every reading, so that a constant reading is a fault by itself.

        Returns
        -------
        The limits, with those that the file sets.
        """
        wire = self.known_wire()
        circuit = WireCircuit(
            sense_voltage_v=self.sense_voltage,
            maximum_voltage_v=self.maximum_voltage,
            shunt_resistance_ohm=self.shunt,
            wire_length_m=self.wire_length,
            ambient_temperature_k=self.ambient_temperature,
            sample_period_s=self.sample_period,
            wire_range_v=wire_range_v,
            shunt_range_v=shunt_range_v,
            readings_noisy=readings_noisy,
            loss_factor=self.loss_factor,
        )
        limits = limits_of(wire, load_alloy(wire.alloy), circuit, self.limits.changed())
        return limits if self.arrives is None else limits._replace(arriving_fraction=self.arrives.fractions[1])

    def facts(self) -> Metadata:
        """Return the metadata of a recording that describe wire and circuit."""
        wire = self.known_wire()
        return {
            "wire": wire.name,
            "wire_diameter_m": wire.diameter_m.value,
            "leg_length_m": self.leg_length_m,
            "maximum_force_n": wire.maximum_force_n.value,
            **validity_of(load_alloy(wire.alloy)).facts(),
            **{name: getattr(self, key) for key, name in STATED.items()},
            **({} if self.arrives is None else self.arrives.facts()),
        }


# Keys of a mounted wire that each kind of rig has in its own way, and those that a recording states in other words: as
# limits of the protection, as amplitude, as length of a leg.
OWN_TO_A_KIND = ("wire", "limits", "arrives", "loss_factor", "beyond_catalogue")
IN_OTHER_WORDS = ("legs", "sense_voltage", "maximum_voltage", "drive_amplitude", "ambient_temperature")
# The keys of wire and circuit that rig files of every kind have, and the numbers that a recording states by them.
SHARED_KEYS = {key: field for key, field in MountedWire.model_fields.items() if key not in OWN_TO_A_KIND}
STATED = {key: si_name(key, field) for key, field in SHARED_KEYS.items() if key not in IN_OTHER_WORDS}
