"""The files of a board's program in MicroPython: those that are the same for all, and those of one wire and circuit."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from musclewire.controllers import ProtectionLimits
from musclewire.errors import CallerError
from musclewire.extras.board._c.loops import settings_in_c
from musclewire.extras.board._micropython.circuit import MonitorCircuit, load_circuit
from musclewire.extras.board._micropython.numbers import BoardLoop, module_text, numbers_of, rules_text
from musclewire.extras.board._serial.device import SerialConfiguration
from musclewire.rigs import rig_configuration

# Copied in this order, the one that starts the others last of all.
LAST = ("boot.py", "main.py")


class BoardProgram(NamedTuple):
    """A program for a board: its files' texts in the order in which they are copied, and what it was made of."""

    texts: dict[str, str]
    circuit: MonitorCircuit
    limits: ProtectionLimits
    loop: BoardLoop | None
    wire: str


def program_of(board: str, rig: str | Path, model: Path | None, names: tuple[str, str]) -> BoardProgram:
    """Return the program for a board's circuit, the wire of a rig file and, if there is one, a model.

    Raises CallerError for what does not fit: a rig of another kind, a model of another wire, drives that the circuit
    cannot give.
    """
    from musclewire.identify import check_made_for
    from musclewire.sensing import load_model

    configuration, where = rig_configuration(rig)
    if not isinstance(configuration, SerialConfiguration):
        raise CallerError(f"{where} is no board on a serial line: give a copy of the rig file 'pico' with your wire")
    circuit, loop = load_circuit(board), None
    limits = configuration.protection_limits(
        wire_range_v=configuration.wire_range, shunt_range_v=configuration.shunt_range, readings_noisy=False
    )
    if model is not None:
        loaded = load_model(model)
        check_made_for(loaded, configuration.facts(), where, "name the rig with your wire, or fit one")
        settings = settings_in_c(loaded, names[1], sample_period_s=circuit.tick, file=model)
        loop = BoardLoop(loaded, settings, limits, names, circuit.tick)
    wire = configuration.known_wire().name
    return BoardProgram(program_files(limits, loop, circuit, wire), circuit, limits, loop, wire)


def program_files(
    limits: ProtectionLimits,
    loop: BoardLoop | None,
    circuit: MonitorCircuit,
    wire: str,
    *,
    injected: bool = False,
) -> dict[str, str]:
    """Return the text of each file by its name, in the order in which they are copied.

    ``loop`` is what the board closes itself, None if the host does; ``injected`` includes the faults of tests.
    Raises CallerError for a sense voltage below what a reading's pulse gives, and a maximum above the supply.
    """
    lowest_v = circuit.lowest_drive_v
    if limits.sense_voltage_v < lowest_v:
        raise CallerError(
            f"sense_voltage {limits.sense_voltage_v:g} V is less than a reading's pulse gives, {lowest_v:.2f} V of a "
            f"supply of {circuit.supply:g} V: state at least {lowest_v + 0.005:.2f} V or take a lower supply"
        )
    if limits.maximum_voltage_v > circuit.supply:
        raise CallerError(
            f"maximum_voltage {limits.maximum_voltage_v:g} V is above the supply, {circuit.supply:g} V: lower it, or "
            "state another supply in the circuit's file"
        )
    folder = files("musclewire.extras.board") / "micropython"
    texts = {item.name: item.read_text("utf-8") for item in folder.iterdir() if item.name.endswith(".py")}
    texts["musclewire_rules.py"] = rules_text(limits, loop)
    texts["musclewire_numbers.py"] = module_text(numbers_of(limits, loop, circuit, wire, injected=injected))
    hashes = {name: hashlib.sha256(text.encode()).digest() for name, text in sorted(texts.items()) if name != "main.py"}
    texts["main.py"] = texts["main.py"].replace("HASHES = {}", f"HASHES = {hashes!r}")
    return {name: texts[name] for name in (*sorted(texts.keys() - set(LAST)), *LAST)}


def write_program(texts: Mapping[str, str], folder: Path) -> None:
    """Write the files into a folder, which is made if need be. Raises CallerError if it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise CallerError(f"{folder}: {error.strerror or error}; choose another folder") from None
