"""The circuit that everybody has: a supply, the wire, one MOSFET, one current monitor; its numbers on one board."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters import validated
from musclewire.signals import measured_in
from musclewire.small_files import read_toml, toml_of

FOLDER = files("musclewire.extras.board") / "circuits"
Volts = Annotated[float, measured_in("V"), Field(gt=0.0, le=26.0)]
Ohms = Annotated[float, measured_in("ohm"), Field(ge=0.0, le=10.0)]
Seconds = Annotated[float, measured_in("s"), Field(gt=0.0, le=1.0)]
Pin = Annotated[int, Field(ge=0, le=48)]


class MonitorCircuit(BaseModel):
    """One board with a MOSFET and a current monitor; pins are the chip's own numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    board: Annotated[str, Field(max_length=16)]
    gate_pin: Pin
    i2c_bus: Annotated[int, Field(ge=0, le=1)]
    sda_pin: Pin
    scl_pin: Pin
    monitor_address: Annotated[int, Field(ge=0x40, le=0x4F)] = 0x40
    supply: Volts = 5.0
    # Between module and ground besides the wire: the MOSFET's R_DS(on) by its data sheet, and leads.
    beside_wire: Ohms = 0.03
    # A changed pulse begins with the timer's next period: 50 us, before the command to the monitor is sent.
    pulse_hz: Annotated[int, Field(ge=10_000, le=40_000)] = 20_000
    tick: Seconds = 0.05  # 20 readings a second
    # Of a tick the wire has the full supply, for a reading: a command on I2C, two conversions.
    reading: Seconds = 1.27e-3
    watchdog: Seconds = 0.2

    @property
    def lowest_drive_v(self) -> float:
        """The root mean square [V] of a tick with nothing but its reading's pulse: no drive is lower but none."""
        return float(self.supply * (self.reading / self.tick) ** 0.5)

    def numbers(self) -> dict[str, Any]:
        """Return the circuit's numbers by their names in the program."""
        pins = ("gate_pin", "i2c_bus", "sda_pin", "scl_pin", "monitor_address", "pulse_hz")
        return {
            "BOARD": self.board.encode(),
            **{name.upper(): getattr(self, name) for name in pins},
            "SUPPLY_V": self.supply,
            "BESIDE_WIRE_OHM": self.beside_wire,
            "TICK_S": self.tick,
            "READING_S": self.reading,
            "WATCHDOG_MS": round(1e3 * self.watchdog),
            **INA219,
        }


# Texas Instruments, INA219, SBOS448: both inputs once, 12 bits, 532 us each; ranges of shunt and bus 320 mV and 16 V.
INA219 = {
    "CONFIGURATION": 0x00,
    "TRIGGER": (0x199B).to_bytes(2, "big"),
    "READY_REGISTER": 0x02,
    "READY_BYTES": 2,
    "READY_MASK": 0x0002,
    "BUS_REGISTER": 0x02,
    "BUS_BYTES": 2,
    "BUS_SHIFT": 3,
    "BUS_STEP_V": 4e-3,
    "SHUNT_REGISTER": 0x01,
    "SHUNT_BYTES": 2,
    "SHUNT_SHIFT": 0,
    "SHUNT_STEP_V": 10e-6,
    "OVERFLOW_MASK": 0x0001,
    "CONVERSIONS_US": 2 * 586,  # the longest by the data sheet
}


def circuit_names() -> list[str]:
    """Return the boards that have a circuit here."""
    return sorted(item.name.removesuffix(".toml") for item in FOLDER.iterdir() if item.name.endswith(".toml"))


def load_circuit(board: str) -> MonitorCircuit:
    """Return the circuit of a board by its name, or of a file (TOML). Raises CallerError naming file and key."""
    if board.endswith(".toml"):
        return validated(MonitorCircuit, read_toml(Path(board), "circuit"), f"circuit {board}")
    if board not in circuit_names():
        raise CallerError(f"there is no circuit of board '{board}'{nearest_hint(board, circuit_names())}")
    return validated(MonitorCircuit, toml_of((FOLDER / f"{board}.toml").read_text("utf-8"), board), f"circuit {board}")
