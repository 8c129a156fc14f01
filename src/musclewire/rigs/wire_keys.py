"""Keys of a simulated rig's file that are those of real hardware: length and pretension of the wire, its circuit."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.rigs.mounted_wire import AirKelvins, Metres, Newtons, Ohms, Seconds, Volts

__all__ = ["SETTINGS", "WireKeys"]

# Each key, and the number of wire or bench that it sets; ``settings`` still accepts that number by its own name.
SETTINGS = {
    "wire_length": "wire_length_m",
    "legs": "legs",
    "shunt": "shunt_resistance_ohm",
    "sense_voltage": "sense_voltage_v",
    "maximum_voltage": "maximum_voltage_v",
    "drive_amplitude": "drive_amplitude_v",
    "pretension": "pretension_n",
    "ambient_temperature": "ambient_temperature_k",
    "sample_period": "sample_period_s",
}


class WireKeys(BaseModel):
    """The keys of wire and circuit as in ``MountedWire``; each is optional here, by default that of wire or bench.

    Parameters
    ----------
    wire_length
        Length of the wire, all legs together [m], in files as text with a unit.
    legs
        1 for a straight wire, 2 for a V.
    shunt
        Resistance of the shunt [ohm].
    sense_voltage
        Drive that hardly heats the wire and still gives a reading [V].
    maximum_voltage
        Highest drive [V].
    drive_amplitude
        Amplitude of the slow sine [V].
    pretension
        Force of the cold wire [N].
    ambient_temperature
        Temperature of the air [K].
    sample_period
        Time between samples [s].
    settings
        Other numbers of wire and bench that are changed, in SI or as text with a unit.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    wire_length: Metres | None = None
    legs: Annotated[int, Field(ge=1, le=2)] | None = None
    shunt: Ohms | None = None
    sense_voltage: Volts | None = None
    maximum_voltage: Volts | None = None
    drive_amplitude: Volts | None = None
    pretension: Newtons | None = None
    ambient_temperature: AirKelvins | None = None
    sample_period: Seconds | None = None
    settings: dict[str, float | str] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _said_once(self) -> WireKeys:
        for key in self.wire_settings():
            name = next(own for own, setting in SETTINGS.items() if setting == key)
            if key in self.settings:
                raise ValueError(f"{name} and settings.{key} are the same number: give {name} only")
        return self

    def wire_settings(self) -> dict[str, float]:
        """Return the numbers of wire and bench that the keys set, in SI."""
        return {setting: float(value) for key, setting in SETTINGS.items() if (value := getattr(self, key)) is not None}

    def all_settings(self) -> dict[str, float | str]:
        """Return the numbers of wire and bench that the file sets, by keys and by ``settings``."""
        return {**self.settings, **self.wire_settings()}
