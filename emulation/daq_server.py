"""A server of NI's gRPC protocol for an emulated card that drives the simulated wire.

    python -m emulation.daq_server --card ni-pci-6229 --wire simulated --pace clock

prints its address and the line that a rig file needs. The client is NI's own nidaqmx package, unmodified: what it sends
is taken by the service that the same package declares. That shows that calls, their order and their shapes are right.
It shows nothing of NI's driver, its timing, or its hardware.
"""

from __future__ import annotations

import argparse
import gc
import signal
import sys
import threading
from collections.abc import Callable
from concurrent import futures
from typing import Any

import grpc
import session_pb2
from nidaqmx._stubs import nidaqmx_pb2 as messages
from nidaqmx._stubs import nidaqmx_pb2_grpc as services
from nidaqmx.constants import AcquisitionType, TaskMode, TerminalConfiguration

from emulation.daq_card import SINGLE_POINT, Card, CardError

__all__ = ["DaqServer", "main"]

# Attributes by the numbers that nidaqmx sends for them.
DEVICE_NAMES = 0x193B
PRODUCT_TYPE, SERIAL_NUMBER = 0x0631, 0x0632
AVAILABLE, CHANNELS = 0x1223, 0x217B
INPUT_BUFFER = 0x186C
SAMPLE_CLOCK_RATE = 0x1344
CHANNEL_TYPE, INPUT_TYPE, OUTPUT_TYPE, VOLTAGE = 0x187F, 10100, 10102, 10322
GROUPED_BY_CHANNEL = 0

TERMINALS = {
    TerminalConfiguration.DEFAULT.value: "default",
    TerminalConfiguration.RSE.value: "RSE",
    TerminalConfiguration.NRSE.value: "NRSE",
    TerminalConfiguration.DIFF.value: "differential",
    TerminalConfiguration.PSEUDO_DIFF.value: "pseudodifferential",
}
RELEASING = {TaskMode.TASK_UNRESERVE.value, TaskMode.TASK_ABORT.value}


def answered(method: Callable[..., Any]) -> Callable[..., Any]:
    """Return a call whose errors reach the client as the driver's do: as a number with a text."""

    def call(self: Service, request: Any, context: grpc.ServicerContext) -> Any:
        try:
            return method(self, request)
        except CardError as error:
            context.set_trailing_metadata((("ni-error", str(error.code)),))
            context.abort(grpc.StatusCode.UNKNOWN, error.text)

    return call


class Service(services.NiDAQmxServicer):
    """The calls that a rig needs; every other one answers that it is not implemented."""

    def __init__(self, card: Card) -> None:
        """Answer for one card."""
        self._card = card

    @answered
    def GetSystemInfoAttributeUInt32(self, request: Any) -> Any:  # noqa: N802, ARG002
        # There is no driver: its version is 0.
        return messages.GetSystemInfoAttributeUInt32Response(value=0)

    @answered
    def GetSystemInfoAttributeString(self, request: Any) -> Any:  # noqa: N802
        if request.attribute_raw != DEVICE_NAMES:
            raise CardError(-200452, f"Specified property is not supported: {request.attribute_raw:#x}")
        return messages.GetSystemInfoAttributeStringResponse(value=self._card.name)

    @answered
    def GetDeviceAttributeString(self, request: Any) -> Any:  # noqa: N802
        self._card.require(request.device_name)
        if request.attribute_raw != PRODUCT_TYPE:
            raise CardError(-200452, f"Specified property is not supported: {request.attribute_raw:#x}")
        return messages.GetDeviceAttributeStringResponse(value=self._card.model.product)

    @answered
    def GetDeviceAttributeUInt32(self, request: Any) -> Any:  # noqa: N802
        self._card.require(request.device_name)
        if request.attribute_raw != SERIAL_NUMBER:
            raise CardError(-200452, f"Specified property is not supported: {request.attribute_raw:#x}")
        return messages.GetDeviceAttributeUInt32Response(value=self._card.serial_number)

    @answered
    def ResetDevice(self, request: Any) -> Any:  # noqa: N802
        self._card.reset(request.device_name)
        return messages.ResetDeviceResponse()

    @answered
    def CreateTask(self, request: Any) -> Any:  # noqa: N802, ARG002
        session = session_pb2.Session(id=self._card.create().number)
        return messages.CreateTaskResponse(task=session, new_session_initialized=True)

    @answered
    def ClearTask(self, request: Any) -> Any:  # noqa: N802
        self._card.clear(request.task.id)
        return messages.ClearTaskResponse()

    @answered
    def CreateAIVoltageChan(self, request: Any) -> Any:  # noqa: N802
        range_v = max(abs(request.min_val), abs(request.max_val))
        terminal = TERMINALS.get(request.terminal_config_raw, str(request.terminal_config_raw))
        self._card.add_input(request.task.id, request.physical_channel, range_v, terminal)
        return messages.CreateAIVoltageChanResponse()

    @answered
    def CreateAOVoltageChan(self, request: Any) -> Any:  # noqa: N802
        range_v = max(abs(request.min_val), abs(request.max_val))
        self._card.add_output(request.task.id, request.physical_channel, range_v)
        return messages.CreateAOVoltageChanResponse()

    @answered
    def CfgSampClkTiming(self, request: Any) -> Any:  # noqa: N802
        single = request.sample_mode_raw == AcquisitionType.HW_TIMED_SINGLE_POINT.value
        self._card.set_clock(request.task.id, request.rate, SINGLE_POINT if single else "continuous")
        return messages.CfgSampClkTimingResponse()

    @answered
    def CfgDigEdgeStartTrig(self, request: Any) -> Any:  # noqa: N802
        self._card.task(request.task.id).trigger = request.trigger_source
        return messages.CfgDigEdgeStartTrigResponse()

    @answered
    def SetBufferAttributeUInt32(self, request: Any) -> Any:  # noqa: N802
        if request.attribute_raw == INPUT_BUFFER:
            self._card.task(request.task.id).buffer = request.value
        return messages.SetBufferAttributeUInt32Response()

    @answered
    def GetTimingAttributeDouble(self, request: Any) -> Any:  # noqa: N802
        rate = self._card.task(request.task.id).rate_hz if request.attribute_raw == SAMPLE_CLOCK_RATE else None
        return messages.GetTimingAttributeDoubleResponse(value=rate or 0.0)

    @answered
    def StartTask(self, request: Any) -> Any:  # noqa: N802
        self._card.start(request.task.id)
        return messages.StartTaskResponse()

    @answered
    def StopTask(self, request: Any) -> Any:  # noqa: N802
        self._card.stop(request.task.id, release=False)
        return messages.StopTaskResponse()

    @answered
    def TaskControl(self, request: Any) -> Any:  # noqa: N802
        if request.action_raw in RELEASING:
            self._card.stop(request.task.id, release=True)
        return messages.TaskControlResponse()

    @answered
    def GetTaskAttributeUInt32(self, request: Any) -> Any:  # noqa: N802
        task = self._card.task(request.task.id)
        return messages.GetTaskAttributeUInt32Response(value=len(task.inputs) + len(task.outputs))

    @answered
    def GetTaskAttributeString(self, request: Any) -> Any:  # noqa: N802
        task = self._card.task(request.task.id)
        names = [f"{self._card.name}/{channel}" for channel, _ in (*task.inputs, *task.outputs)]
        # The client asks for the task's name before there are channels, and for the channels afterwards.
        return messages.GetTaskAttributeStringResponse(value=", ".join(names) or f"_unnamedTask<{task.number}>")

    @answered
    def GetChanAttributeInt32(self, request: Any) -> Any:  # noqa: N802
        kind = INPUT_TYPE if "/ai" in request.channel else OUTPUT_TYPE
        return messages.GetChanAttributeInt32Response(
            value_raw=kind if request.attribute_raw == CHANNEL_TYPE else VOLTAGE
        )

    @answered
    def GetReadAttributeUInt32(self, request: Any) -> Any:  # noqa: N802
        if request.attribute_raw == AVAILABLE:
            return messages.GetReadAttributeUInt32Response(value=self._card.available(request.task.id))
        return messages.GetReadAttributeUInt32Response(value=len(self._card.task(request.task.id).inputs))

    @answered
    def ReadAnalogF64(self, request: Any) -> Any:  # noqa: N802
        rows = self._card.read(request.task.id, request.num_samps_per_chan, request.timeout)
        # The client of nidaqmx requests all readings of one channel before those of the next.
        by_channel = zip(*rows, strict=True) if request.fill_mode_raw == GROUPED_BY_CHANNEL else rows
        values = [value for group in by_channel for value in group]
        return messages.ReadAnalogF64Response(read_array=values, samps_per_chan_read=len(rows))

    @answered
    def WriteAnalogScalarF64(self, request: Any) -> Any:  # noqa: N802
        self._card.write(request.task.id, request.value, auto_start=request.auto_start)
        return messages.WriteAnalogScalarF64Response()

    @answered
    def WriteAnalogF64(self, request: Any) -> Any:  # noqa: N802
        self._card.write(request.task.id, request.write_array[-1], auto_start=request.auto_start)
        return messages.WriteAnalogF64Response(samps_per_chan_written=len(request.write_array))

    def GetErrorString(self, request: Any, context: Any) -> Any:  # noqa: N802, ARG002
        return messages.GetErrorStringResponse(error_string=f"Error {request.error_code} of the emulated card.")


class DaqServer:
    """The service on an address of this machine; leaving the ``with`` block stops it."""

    def __init__(self, card: Card, port: int = 0) -> None:
        """Listen on this machine only. Raises OSError if the port is taken.

        While it listens, this process collects no garbage: a collection in the card's clock, which holds the card,
        would close channels of a client in this process, and wait for threads that wait for the card.
        """
        self.card = card
        self._server = grpc.server(futures.ThreadPoolExecutor(max_workers=8), options=(("grpc.so_reuseport", 0),))
        services.add_NiDAQmxServicer_to_server(Service(card), self._server)
        try:
            found = self._server.add_insecure_port(f"127.0.0.1:{port}")
        except RuntimeError as error:
            raise OSError(f"port {port} is taken") from error
        self.address = f"127.0.0.1:{found}"
        gc.disable()
        self._server.start()

    def close(self) -> None:
        """Stop answering, then stop the card's clock."""
        self._server.stop(grace=None).wait()
        self.card.close()
        gc.enable()

    def __enter__(self) -> DaqServer:
        """Return the server itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Stop it."""
        self.close()


def split(text: str) -> tuple[str, str, str]:
    """Return terminal, gain and offset of an ``--error``."""
    name, _, numbers = text.partition("=")
    gain, _, offset = numbers.partition(",")
    return name, gain, offset or "0"


def main(arguments: list[str] | None = None) -> int:
    """Serve until interrupted."""
    from emulation.daq_bench import card_of

    parser = argparse.ArgumentParser(prog="python -m emulation.daq_server", description=__doc__)
    parser.add_argument("--card", default="ni-pci-6229", help="the nidaq rig (name or file) that describes the wiring")
    parser.add_argument("--wire", default="simulated", help="the simulated rig (name or file) at its terminals")
    parser.add_argument("--pace", choices=("clock", "free"), default="clock", help="free: time passes by reading")
    parser.add_argument("--port", type=int, default=31763, help="0: any that is free")
    parser.add_argument(
        "--error",
        action="append",
        default=[],
        metavar="ai0=1.002,0.005",
        help="errors of a terminal: gain and offset [V] in addition to the rig file's, for doctor to find",
    )
    chosen = parser.parse_args(arguments)
    errors = {name: (float(gain), float(offset)) for name, gain, offset in (split(text) for text in chosen.error)}
    over = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: over.set())
    card = card_of(chosen.card, chosen.wire, paced=chosen.pace == "clock", errors=errors)
    try:
        opened = DaqServer(card, chosen.port)
    except OSError as error:
        card.close()
        print(f"error: {error}: end what holds it, or take another with --port", file=sys.stderr)
        return 3
    with opened as server:
        gc.enable()  # no client lives in this process
        print(f"an emulated {server.card.model.product} as {server.card.name}, with the rig {chosen.wire} behind it")
        print("a rig file of kind nidaq reaches it by the line")
        print(f'grpc = "{server.address}"', flush=True)
        while not over.wait(0.2):  # a signal that the kernel hands to a thread of gRPC's does not wake this one
            pass
    return 0


if __name__ == "__main__":
    sys.exit(main())
