"""The driver's errors, explained in one line: what is wrong, where, what to do."""

from __future__ import annotations

import re
from typing import Any

from musclewire.errors import RigError

# The driver's numbers (nidaqmx.error_codes), what they mean here, and what to do.
MEANINGS: dict[int, tuple[str, str]] = {
    -50103: (
        "is reserved by another program",
        "close NI MAX test panels and other programs that use it, or reset the device in NI MAX",
    ),
    -200022: ("is reserved by another program", "close other programs that use it, or reset the device in NI MAX"),
    -200220: ("is not known to the driver", "see its name in NI MAX, and write it as `device` into the rig file"),
    -200170: ("has no such channel", "see the card's terminals in NI MAX, and correct `channel` in the rig file"),
    -200077: (
        "does not support a setting of the rig file",
        "another `terminal`, `range` or `output_timing`: a USB card has no hardware-timed single point",
    ),
    -200081: ("cannot read this fast", "a lower `reading_rate`, or fewer inputs"),
    -200332: ("cannot read this fast", "a lower `reading_rate`, or fewer inputs"),
    -200335: ("cannot read this fast", "a lower `reading_rate`, or fewer inputs"),
    -200452: ("does not support a setting of the rig file", 'output_timing = "on-demand"'),
    -200368: ("cannot start its output by its inputs' trigger", 'output_timing = "on-demand"'),
    -89136: ("cannot start its output by its inputs' trigger", 'output_timing = "on-demand"'),
    -200284: ("gave no readings in time", "its sample clock has stopped: look at the cable, and reset the device"),
    -200279: (
        "had readings overwritten before they were fetched: the host stalled",
        "look at the host's load; the run is lost from there on",
    ),
    -200278: ("gave no readings: its task has ended", "open the rig again"),
    -200561: ("was asked for a voltage beyond its output range", "correct `range`, `gain` or `offset` of [output]"),
    -201003: ("cannot be reached: it is no longer in the system or has no power", "look at its cable and power"),
    -200324: ("cannot be reached: USB or bus lost it", "look at its cable and power"),
    -200045: ("was removed from the system", "look at its cable and power"),
    -50808: ("lost a transfer over USB", "look at its cable, and plug it into the machine itself"),
    -50405: ("stopped in the middle of a transfer", "look at its cable and power"),
    -88708: ("was reset by another program or has left the system", "open the rig again"),
    -88709: ("was reset by another program or has left the system", "open the rig again"),
    -88710: ("was reset by another program or has left the system", "open the rig again"),
}
LATE_WRITE = -209801
STALLED = -200279


class DaqFaultError(RigError):
    """An error of the driver, explained; ``code`` is its number, 0 if it has none."""

    def __init__(self, message: str, code: int) -> None:
        """Keep the number."""
        super().__init__(message)
        self.code = code


def explained(error: Any, device: str) -> DaqFaultError:
    """Return one of nidaqmx's exceptions as a fault of one line.

    Takes ``DaqError``, ``DaqNotFoundError``, ``DaqNotSupportedError``, ``DaqFunctionNotSupportedError`` and
    ``RpcError`` (package nidaqmx, ``nidaqmx.errors``).
    """
    kind = type(error).__name__
    if kind in ("DaqNotFoundError", "DaqNotSupportedError"):
        return DaqFaultError(
            "NI-DAQmx, the driver of NI's cards, is not installed on this machine: install it from ni.com, or name a "
            'machine that has it and runs NI\'s gRPC device server, grpc = "address:31763"',
            0,
        )
    if kind == "RpcError":
        # gRPC reports no more than "Failed to connect to server" if a machine does not answer.
        said = " ".join(str(error.description).split())
        return DaqFaultError(f"NI's gRPC device server does not answer for {device}: {said}: is it running there?", 0)
    code = int(getattr(error, "error_code", 0))
    if code in MEANINGS:
        meaning, remedy = MEANINGS[code]
        # The driver names the property that it refused.
        named = re.search(r"Property: *(\S+)", str(error))
        which = f", {named[1]}" if named else ""
        return DaqFaultError(f"{device} {meaning} (NI-DAQmx {code}{which}): {remedy}", code)
    first = str(error).strip().splitlines()[0].rstrip(". ") if str(error).strip() else kind
    return DaqFaultError(f"{device}: {first} (NI-DAQmx {code}): see this number in NI's documentation", code)
