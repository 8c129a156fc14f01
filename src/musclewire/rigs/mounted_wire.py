"""The keys of a rig file of real hardware that describe the mounted wire and its circuit."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.controllers.protection import ProtectionLimits
from musclewire.parameters.library import load_alloy, load_wire
from musclewire.parameters.parameter_groups import Wire
from musclewire.parameters.validity import validity_of
from musclewire.rigs.protocol import Metadata
from musclewire.rigs.quantities import measured_in
from musclewire.rigs.wire_limits import WireCircuit, limits_of

__all__ = ["LimitsTable", "LivePeriod", "MountedWire"]

Volts = Annotated[float, measured_in("V"), Field(gt=0.0, allow_inf_nan=False)]
Metres = Annotated[float, measured_in("m"), Field(gt=0.0, allow_inf_nan=False)]
Ohms = Annotated[float, measured_in("ohm"), Field(gt=0.0, allow_inf_nan=False)]
Newtons = Annotated[float, measured_in("N"), Field(ge=0.0, allow_inf_nan=False)]
Seconds = Annotated[float, measured_in("s"), Field(gt=0.0, le=1.0)]
# A fault shows in the next samples: with longer periods a frozen channel would not be off within half a second.
LivePeriod = Annotated[float, measured_in("s"), Field(gt=0.0, le=0.05 + 1e-9)]
Kelvins = Annotated[float, measured_in("K"), Field(gt=0.0, allow_inf_nan=False)]
# Air around a bench. A bare 22 would be read as kelvins, and air that cold would let the wire grow too hot.
AirKelvins = Annotated[float, measured_in("K"), Field(ge=223.15, le=373.15)]
Amperes = Annotated[float, measured_in("A"), Field(gt=0.0, allow_inf_nan=False)]
Watts = Annotated[float, measured_in("W"), Field(gt=0.0, allow_inf_nan=False)]


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

    maximum_current: Amperes | None = None
    maximum_power: Watts | None = None
    maximum_temperature: Kelvins | None = None
    minimum_current: Amperes | None = None
    resistance_low: Ohms | None = None
    resistance_high: Ohms | None = None
    jump_share: Annotated[float, Field(gt=0.0, le=1.0)] | None = None

    def changed(self) -> dict[str, float]:
        """Return what is set, by the names of ``ProtectionLimits``."""
        units = {"current": "a", "power": "w", "temperature": "k", "low": "ohm", "high": "ohm"}
        given = {key: value for key, value in self.model_dump().items() if value is not None}
        return {
            key if key == "jump_share" else f"{key}_{units[key.rpartition('_')[2]]}": float(value)
            for key, value in given.items()
        }


class MountedWire(BaseModel):
    """The wire on a real rig and its circuit. Numbers in SI or as text with a unit.

    Parameters
    ----------
    wire
        A wire's name (``musclewire simulate --list``) or wire file.
    wire_length
        Overall length between the terminals.
    legs
        Parts of the wire that share the force: 2 for a V, 1 for a straight wire.
    shunt
        R of Eq. 1.
    sense_voltage
        Drive that hardly heats the wire and still gives a reading.
    maximum_voltage
        Highest drive that is ever allowed; it depends on the length of the wire.
    drive_amplitude
        Amplitude of the slow sine.
    pretension
        Force of the cold wire, as set by hand.
    ambient_temperature
        Temperature of the air around the wire.
    sample_period
        Time between samples.
    limits
        Limits of the protection that replace those which follow from wire and circuit.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    wire: str
    wire_length: Metres
    legs: Annotated[int, Field(ge=1, le=2)] = 2
    shunt: Ohms
    sense_voltage: Volts
    maximum_voltage: Volts
    drive_amplitude: Volts
    pretension: Newtons | None = None
    ambient_temperature: AirKelvins = 295.15
    sample_period: Seconds = 0.05
    limits: LimitsTable = LimitsTable()

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
        )
        return limits_of(wire, load_alloy(wire.alloy), circuit, self.limits.changed())

    def facts(self) -> Metadata:
        """Return the metadata of a recording that describe wire and circuit."""
        wire = self.known_wire()
        return {
            "wire": wire.name,
            "wire_diameter_m": wire.diameter_m.value,
            "wire_length_m": self.wire_length,
            "leg_length_m": self.leg_length_m,
            "shunt_resistance_ohm": self.shunt,
            "maximum_force_n": wire.maximum_force_n.value,
            **validity_of(load_alloy(wire.alloy)).facts(),
            "pretension_n": self.pretension,
            "sample_period_s": self.sample_period,
        }
