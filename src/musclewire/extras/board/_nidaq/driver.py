"""The few calls of nidaqmx that a rig makes, on a card here or behind NI's gRPC device server; and its errors."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RigError, require_extra

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


def daq_fault(error: Any, device: str) -> DaqFaultError:
    """Return an exception of ``nidaqmx.errors``, or its gRPC's ``RpcError``, as a fault of one line."""
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


# Longer than any sample, shorter than a user's patience.
TIMEOUT_S = 2.0
# [s] until a call fails: a machine that has lost its connection does not answer, and gRPC waits for it without end.
CALL_S = 2.5
CALL_AGAIN_S = 0.3  # [s] after a call that has failed so


def nidaqmx_package() -> ModuleType:
    """Return the package nidaqmx. Raises MissingExtraError if it is not installed."""
    require_extra("a rig of kind nidaq", "nidaq")
    import nidaqmx
    import nidaqmx.constants
    import nidaqmx.errors
    import nidaqmx.stream_readers
    import nidaqmx.stream_writers
    import nidaqmx.system

    package: ModuleType = nidaqmx
    return package


class AcquisitionCard:
    """A card by its name, in this machine or, with an address, behind a gRPC device server."""

    def __init__(self, device: str, grpc_address: str | None = None) -> None:
        """Keep name and address. Raises MissingExtraError if a package for the connection is not installed."""
        self.device, self.grpc_address = device, grpc_address
        self.package = nidaqmx_package()
        self._channel: Any = None
        self._options: Any = None
        if grpc_address is None:
            return
        import grpc

        self._channel = grpc.insecure_channel(grpc_address)
        limited = grpc.intercept_channel(self._channel, deadline_for_calls())
        self._options = self.package.GrpcSessionOptions(limited, "")

    @contextmanager
    def explaining(self) -> Iterator[None]:
        """Turn the driver's exceptions into faults of one line."""
        try:
            yield
        except self.package.errors.Error as error:
            raise daq_fault(error, self.device) from None

    def task(self) -> Any:
        """Return a new task of the driver."""
        return self.package.Task(grpc_options=self._options)

    def handle(self) -> Any:
        """Return the driver's object for the device."""
        if self._options is None:
            return self.package.system.Device(self.device)
        return self.package.system.System.remote(self._options).devices[self.device]

    def product(self) -> str:
        """Return what kind of card it is. Raises DaqFaultError if it is not there."""
        with self.explaining():
            return str(self.handle().product_type)

    def identity(self) -> str:
        """Return a text by which the card is known again: its serial number, else its name and machine."""
        number = 0
        with suppress(DaqFaultError), self.explaining():
            number = int(self.handle().serial_num)  # 0 if it has none
        return f"NI {number:08X}" if number else f"NI {self.device} {self.grpc_address or ''}".strip()

    def reset(self) -> None:
        """Abort every task on the card, whoever owns it, and put its outputs where a reset puts them."""
        with self.explaining():
            self.handle().reset_device()

    def close(self) -> None:
        """Close the connection to the server."""
        if self._channel is not None:
            self._channel.close()


def deadline_for_calls() -> Any:
    """Return a gRPC interceptor that ends calls without an answer, and sooner if the call before had none either."""
    import grpc

    class Details(NamedTuple):
        method: str
        timeout: float | None
        metadata: Any
        credentials: Any
        wait_for_ready: bool | None
        compression: Any

    class Deadline(grpc.UnaryUnaryClientInterceptor):  # type: ignore[misc]  # gRPC brings no types
        max_call_s = CALL_S

        def intercept_unary_unary(self, continuation: Any, details: Any, request: Any) -> Any:
            kept = (details.metadata, details.credentials, details.wait_for_ready, details.compression)
            call = continuation(Details(details.method, self.max_call_s, *kept), request)
            self.max_call_s = CALL_AGAIN_S if call.code() is grpc.StatusCode.DEADLINE_EXCEEDED else CALL_S
            return call

    return Deadline()


class InputStream:
    """All inputs of a rig in one task, read at the card's sample clock into the driver's buffer."""

    def __init__(self, card: AcquisitionCard, inputs: Mapping[str, Any], rate_hz: float, buffer: int) -> None:
        """Set up channels, clock and buffer. Raises DaqFaultError for what the card does not have."""
        self._card = card
        constants = card.package.constants
        configurations = {
            "differential": constants.TerminalConfiguration.DIFF,
            "RSE": constants.TerminalConfiguration.RSE,
            "NRSE": constants.TerminalConfiguration.NRSE,
            "pseudodifferential": constants.TerminalConfiguration.PSEUDO_DIFF,
        }
        with card.explaining():
            self._task = card.task()
            try:
                for item in inputs.values():
                    self._task.ai_channels.add_ai_voltage_chan(
                        f"{card.device}/{item.channel}",
                        terminal_config=configurations[item.terminal],
                        min_val=-item.range,
                        max_val=item.range,
                    )
                self._task.timing.cfg_samp_clk_timing(
                    rate_hz, sample_mode=constants.AcquisitionType.CONTINUOUS, samps_per_chan=buffer
                )
                self._task.in_stream.input_buf_size = buffer
                self.rate_hz = float(self._task.timing.samp_clk_rate)
            except BaseException:
                self._task.close()
                raise
            self._reader = card.package.stream_readers.AnalogMultiChannelReader(self._task.in_stream)
            self._reader.verify_array_shape = False
        self._width = len(inputs)
        self._closed = False

    def start(self) -> None:
        """Begin to read."""
        with self._card.explaining():
            self._task.start()

    def stop(self) -> None:
        """End reading; readings that were not fetched are lost."""
        with self._card.explaining():
            self._task.stop()

    def waiting(self) -> int:
        """Return how many readings of each channel wait to be fetched."""
        with self._card.explaining():
            return int(self._task.in_stream.avail_samp_per_chan)

    def fetch(self, count: int) -> FloatArray:
        """Return the next readings [V], shaped (inputs, count), waiting until they are there."""
        values = np.empty((self._width, count))
        with self._card.explaining():
            self._reader.read_many_sample(values, count, timeout=TIMEOUT_S)
        return values

    def close(self) -> None:
        """Release the inputs; may be called twice; never raises."""
        if self._closed:
            return
        self._closed = True
        with suppress(self._card.package.errors.Error):
            self._task.close()


class OutputSettings(NamedTuple):
    """Settings of an output for its owner: plain values, because they are sent to another process."""

    device: str
    grpc_address: str | None
    channel: str
    range_v: float
    clock_hz: float | None


class OutputLine:
    """One analogue output: at once, or at the edges of the card's clock once ``begin`` has been called."""

    def __init__(self, settings: OutputSettings) -> None:
        """Set up the output. Raises DaqFaultError for what the card does not have."""
        self._settings = settings
        self._card = AcquisitionCard(settings.device, settings.grpc_address)
        self._timed: Any = None
        self._timed_writer: Any = None
        self._now: Any = None
        self._now_writer: Any = None
        with self._card.explaining():
            self._now, self._now_writer = self._output()
            if settings.clock_hz is not None:
                self._timed, self._timed_writer = self._output()
                mode = self._card.package.constants.AcquisitionType.HW_TIMED_SINGLE_POINT
                self._timed.timing.cfg_samp_clk_timing(settings.clock_hz, sample_mode=mode)
                self._timed.triggers.start_trigger.cfg_dig_edge_start_trig(f"/{settings.device}/ai/StartTrigger")
        self._clocked = False

    def _output(self) -> tuple[Any, Any]:
        task = self._card.task()
        range_v = self._settings.range_v
        task.ao_channels.add_ao_voltage_chan(
            f"{self._settings.device}/{self._settings.channel}", min_val=-range_v, max_val=range_v
        )
        writer = self._card.package.stream_writers.AnalogSingleChannelWriter(task.out_stream)
        writer.verify_array_shape = False
        return task, writer

    def clock_hz(self) -> float | None:
        """Return the rate at which the card changes the output, None if the host does."""
        if self._timed is None:
            return None
        with self._card.explaining():
            return float(self._timed.timing.samp_clk_rate)

    def begin(self, voltage_v: float) -> None:
        """Apply a voltage now; if the output has a clock, the inputs' start triggers it."""
        self.put_now(voltage_v)
        if self._timed is None:
            return
        with self._card.explaining():
            self._release(self._now)
            self._timed.start()
        self._clocked = True

    def put(self, voltage_v: float) -> None:
        """Apply a voltage: at the next clock edge if the clock runs, at once otherwise."""
        if not self._clocked:
            self.put_now(voltage_v)
            return
        try:
            with self._card.explaining():
                self._timed_writer.write_one_sample(voltage_v)
        except DaqFaultError as fault:
            # The clock was faster. The host sees by its readings how late it is, and skips the periods it missed.
            if fault.code != LATE_WRITE:
                raise

    def put_now(self, voltage_v: float) -> None:
        """Apply a voltage at once, whatever the clock does."""
        with self._card.explaining():
            if self._clocked:
                self._clocked = False
                self._release(self._timed)
            self._now_writer.write_one_sample(voltage_v)

    def _release(self, task: Any) -> None:
        task.stop()
        task.control(self._card.package.constants.TaskMode.TASK_UNRESERVE)

    def take_over(self, voltage_v: float) -> None:
        """Apply a voltage by every means: abort all tasks on the card, whoever owns them, and write."""
        self._card.reset()
        with self._card.explaining():
            self._now, self._now_writer = self._output()
        self._clocked = False
        self.put_now(voltage_v)

    def release_card(self) -> None:
        """Abort the tasks that a dead host left on a card in another machine; never raises.

        In this machine the driver frees a process's tasks when it ends. A gRPC device server keeps them.
        """
        if self._settings.grpc_address is None:
            return
        with suppress(DaqFaultError):
            self._card.reset()

    def close(self) -> None:
        """Release the output, which holds its last voltage; never raises."""
        for task in (self._timed, self._now):
            if task is not None:
                with suppress(self._card.package.errors.Error):
                    task.close()
        self._card.close()
