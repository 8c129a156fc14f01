"""Every number of a board's program in MicroPython: model, controller, limits, protection table, messages, circuit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from musclewire.controllers import (
    CONTROLLERS,
    AllowedDrive,
    ControllerSetup,
    DriveLimits,
    Effect,
    Event,
    FeedforwardSettings,
    Protection,
    ProtectionLimits,
    Signal,
    commanded,
    judged_sample,
    signalled,
)
from musclewire.errors import CallerError
from musclewire.extras.board._c.library import loop_checksum
from musclewire.extras.board._c.loops import ControllerSettings
from musclewire.extras.board._micropython.circuit import MonitorCircuit
from musclewire.extras.board._micropython.rules import Each, Translation
from musclewire.extras.board._serial import message_types as messages
from musclewire.physics import MINIMUM_CURRENT_A
from musclewire.sensing import ESTIMATORS, EstimatorSetup, SensingModel
from musclewire.signals import CONTROLLER_ANSWERS, ESTIMATOR_ANSWERS, CompiledTick, Reason, declared_tick

# So long without a command, and the wire is off [s]; as in our firmware.
EXPIRY_S = 0.25
# Names of the program for what is a column of a row of the protection or of its rules.
PLACES_OF_ROW = {
    "STATE": "state",
    "EVENT": "event",
    "TEMPERATURE_K": "temperature_k",
    "OFTEN_MISSING_S": "often_missing_s",
    "LASTING_S": "lasting_s",
    "WIRE_VOLTAGE_V": "wire_voltage_v",
    "SHUNT_VOLTAGE_V": "shunt_voltage_v",
}
PLACES_OF_RULES = {
    "OUTPUT_DRIVES": "output_drives",
    "EFFECTS": "effects",
    "SENSE_AFTER_S": "sense_after_s",
    "AMBIENT_K": "ambient_temperature_k",
    "CAPACITY": "heat_capacity_j_per_k",
    "LOSS": "heat_loss_w_per_k",
    "MAXIMUM_V": "maximum_voltage_v",
    "SHUNT_OHM": "shunt_resistance_ohm",
}
KINDS = {
    **{name: name for name in ("HELLO", "DRIVE", "TARGET", "OFF", "STREAM", "KEEP", "CORRECT", "INJECT", "IDENTITY")},
    **{name: name for name in ("SAMPLE", "ACKNOWLEDGEMENT", "CORRECTION")},
    "ARM_FRAME": "ARM",
    "EVENT_FRAME": "EVENT",
}
INJECTED = {"STUCK_LOOP", "FROZEN_CONVERTER", "SILENT_CONVERTER"}


class BoardLoop:
    """What closes the loop on a board: the ticks of an estimator and of a controller, and their numbers."""

    def __init__(
        self,
        model: SensingModel,
        settings: ControllerSettings,
        limits: ProtectionLimits,
        names: tuple[str, str],
        period_s: float,
    ) -> None:
        """Take estimator and controller by their names, for one period."""
        drive = DriveLimits(limits.sense_voltage_v, limits.maximum_voltage_v)
        estimator = ESTIMATORS.find(names[0])(EstimatorSetup(model, limits.shunt_resistance_ohm, period_s))
        if isinstance(settings, FeedforwardSettings):
            # Its power is that of the circuit at hand, whatever shunt the gains were found with.
            settings = settings.model_copy(update={"shunt_resistance_ohm": limits.shunt_resistance_ohm})
        controller = CONTROLLERS.find(names[1])(ControllerSetup(drive, settings=settings))
        self.model = model
        self.checksum = loop_checksum(model, settings, None, names[0])
        self.estimator = _declared(estimator)
        self.controller = _declared(controller, limits.sense_voltage_v)
        # A controller takes over at the drive that is out, which is a number of its state.
        elsewhere = _declared(controller, limits.maximum_voltage_v).state
        self.drive_places = np.flatnonzero(elsewhere != self.controller.state).tolist()
        if not np.array_equal(elsewhere[self.drive_places], np.full(len(self.drive_places), limits.maximum_voltage_v)):
            raise CallerError(f"controller {names[1]} begins in another way at each drive, so that no board can run it")
        self.answers = tuple(
            len(names) + len(each.columns)
            for names, each in ((ESTIMATOR_ANSWERS, estimator), (CONTROLLER_ANSWERS, controller))
        )
        self.knows_wire = len(estimator.columns) > 1
        fields = getattr(estimator.start(), "_fields", ())
        self.time_place = fields.index("time_s") if "time_s" in fields else -1

    def numbers(self) -> dict[str, Any]:
        """Return the numbers of both, and the range of targets."""
        model = self.model
        span = model.quantity_max - model.quantity_min
        return {
            "QUANTITY": model.quantity.encode(),
            "CHECKSUM": self.checksum,
            "LOWEST": model.quantity_min - span,
            "HIGHEST": model.quantity_max,
            "SPAN": span,
            "ESTIMATOR": self.estimator.constants.tolist(),
            "ESTIMATOR_STATE": self.estimator.state.tolist(),
            "ESTIMATOR_TIME": self.time_place,
            "KNOWS_WIRE": self.knows_wire,
            "CONTROLLER": self.controller.constants.tolist(),
            "CONTROL_STATE": self.controller.state.tolist(),
            "DRIVE_PLACES": self.drive_places,
            "ESTIMATOR_ANSWERS": self.answers[0],
            "CONTROLLER_ANSWERS": self.answers[1],
        }


# Of a board that the host alone drives: no target is within its range.
NO_LOOP = {
    "QUANTITY": b"",
    "CHECKSUM": 0,
    "LOWEST": math.inf,
    "HIGHEST": -math.inf,
    "SPAN": 0.0,
    "ESTIMATOR_STATE": [],
    "ESTIMATOR": [],
    "CONTROLLER": [],
    "ESTIMATOR_ANSWERS": 0,
    "CONTROLLER_ANSWERS": 0,
}


def rules_text(limits: ProtectionLimits, loop: BoardLoop | None) -> str:
    """Return the functions of protection, estimator and controller as a module of MicroPython."""
    protection, translation = Protection(limits), Translation()
    rows = {"rows": Each(protection.row.dtype), "rules": Each(protection.rules.dtype)}
    for function in (commanded, signalled, judged_sample):
        translation.add(function, rows)
    named = ""
    if loop is not None:
        for name, tick in (("estimator_tick", loop.estimator), ("controller_tick", loop.controller)):
            translation.add(tick.function)
            named += f"{name} = {translation.functions[tick.function]}\n"
    said = "Written by musclewire: the host's own protection and ticks, operation by operation."
    return f'"""{said}"""\n\n{translation.source}\n\n{named}'


def _declared(implementation: Any, *arguments: Any) -> CompiledTick:
    tick = declared_tick(implementation, *arguments)
    if tick is None:
        raise CallerError(f"{type(implementation).__name__} has no compiled tick, so that no board can run it")
    return tick


def nested(row: Any) -> list[Any]:
    """Return a row with its tables as nested lists of plain numbers."""
    return [np.asarray(field).tolist() for field in row.item()]


def numbers_of(
    limits: ProtectionLimits, loop: BoardLoop | None, circuit: MonitorCircuit, wire: str, *, injected: bool
) -> dict[str, Any]:
    """Return every number by its name in the program."""
    protection = Protection(limits)
    protection.close()
    row, rules = (each.dtype.names or () for each in (protection.row, protection.rules))
    return {
        **{name: row.index(field) for name, field in PLACES_OF_ROW.items()},
        **{name: rules.index(field) for name, field in PLACES_OF_RULES.items()},
        **{number.name: int(number) for number in (*SIGNALS, *EFFECTS, *EVENTS)},
        "NO_DRIVE": int(AllowedDrive.NONE),
        "NO_CURRENT": float(Reason.NO_CURRENT),
        "MINIMUM_CURRENT_A": MINIMUM_CURRENT_A,
        "SENSE_V": limits.sense_voltage_v,
        "EXPIRY_S": EXPIRY_S,
        "PROTECTION": nested(protection.row[0]),
        "RULES": nested(protection.rules[0]),
        **(NO_LOOP if loop is None else loop.numbers()),
        **_messages(),
        "FAULT_INJECTION": injected,
        "WIRE": wire.encode(),
        **circuit.numbers(),
    }


SIGNALS = (Signal.ARM, Signal.CLOSE, Signal.FAULT, Signal.PRESENT, Signal.COMMAND)
EFFECTS = (Effect.RESUME, Effect.FOLLOW)
EVENTS = (
    Event.NONE,
    Event.STOPPED,
    Event.COMMAND_MISSING,
    Event.COMMAND_REFUSED,
    Event.SAMPLE_LATE,
    Event.LINK_CORRUPTED,
    Event.WATCHDOG,
)


def _messages() -> dict[str, Any]:
    kinds = messages.MessageKind
    causes, results = messages.ResetCause, messages.AcknowledgementResult
    injected = messages.FaultInjection
    return {
        "VERSION": messages.PROTOCOL_VERSION,
        "MAX_BODY": messages.MAXIMUM_BODY_BYTES,
        "MAX_FRAME": messages.MAXIMUM_BODY_BYTES + 2,
        "FIRMWARE_MAJOR": 1,
        "FIRMWARE_MINOR": 2,
        **{name: int(kinds[field]) for name, field in KINDS.items()},
        **{result.name: int(result) for result in results},
        **{f"RESET_{cause.name}": int(cause) for cause in (causes.POWER_ON, causes.WATCHDOG)},
        **{name: int(injected[name]) for name in sorted(INJECTED)},
        "NAN_READING": int(injected.NAN),
        "LAYOUTS": {int(kind): layout.format for kind, layout in messages.LAYOUTS.items()},
    }


def module_text(numbers: Mapping[str, Any]) -> str:
    """Return the numbers as a module; what is not finite is written so that MicroPython reads it."""
    said = '"""Written by musclewire: the numbers of one wire in one circuit."""\n'
    lines = [f"{name} = {value!r}" for name, value in numbers.items()]
    return "\n".join([said, 'inf, nan = float("inf"), float("nan")', *lines, ""])
