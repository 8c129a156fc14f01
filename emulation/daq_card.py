"""An acquisition card as its driver shows it: tasks, a sample clock, a buffer, outputs that hold, errors by number.

It knows nothing of the line its calls come over (``daq_server``) and nothing of wires: what hangs on its terminals is a
``Terminals``. The rules are those that NI's manuals state for M Series cards; none of them was measured on a card.
"""

from __future__ import annotations

import itertools
import threading
import time
from collections import deque
from dataclasses import dataclass, field
from typing import Protocol

__all__ = ["Card", "CardError", "CardTask", "Model", "Terminals"]

# The numbers by which NI's driver names what is wrong (nidaqmx.error_codes).
LATE_WRITE = -209801
DEVICE_GONE = -201003
NOT_RUNNING = -200846
OUT_OF_RANGE = -200561
NOT_YET = -200284
OVERWRITTEN = -200279
UNKNOWN_DEVICE = -200220
UNKNOWN_CHANNEL = -200170
UNKNOWN_TASK = -200088
NOT_SUPPORTED = -200077
ABORTED = -88710
RESERVED = -50103

SINGLE_POINT = "single point"
# How long the clock of a paced card sleeps between looks: shorter than any sample, longer than a thread's switch.
LOOK_S = 0.002


class CardError(Exception):
    """What the driver reports: a number and a text."""

    def __init__(self, code: int, text: str) -> None:
        """Keep both."""
        super().__init__(text)
        self.code = code
        self.text = text


class Terminals(Protocol):
    """What is wired to the card, moving on by one tick of its fastest clock at a time."""

    def advance(self, outputs_v: dict[str, float]) -> dict[str, float]:
        """Return the voltages at the input terminals after a tick with these voltages at the output terminals."""
        ...


@dataclass(frozen=True)
class Model:
    """A model of card: its terminals, its resolution and its noise."""

    product: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    terminals: tuple[str, ...]
    single_point: bool
    bits: int
    noise_v: float
    range_v: float = 10.0


@dataclass
class CardTask:
    """A task of the driver: its channels, its clock and the readings that have not been fetched."""

    number: int
    inputs: list[tuple[str, float]] = field(default_factory=list)
    outputs: list[tuple[str, float]] = field(default_factory=list)
    rate_hz: float | None = None
    mode: str = "on demand"
    trigger: str = ""
    buffer: int = 10_000
    reserved: bool = False
    running: bool = False
    aborted: bool = False
    overwritten: bool = False
    ticks: int = 0
    pending_v: float | None = None
    late: bool = False
    rows: deque[tuple[float, ...]] = field(default_factory=deque)


class Card:
    """One card with a device name; every call may come from another thread."""

    def __init__(self, name: str, model: Model, terminals: Terminals, tick_s: float, *, paced: bool) -> None:
        """Start at 0 V. ``paced`` lets the clock run in real time; otherwise time passes only during a read."""
        self.name, self.model, self.tick_s, self.paced = name, model, tick_s, paced
        self.serial_number = 0  # it has none, as a simulated device of NI's driver, until a test gives it one
        self.outputs_v = dict.fromkeys(model.outputs, 0.0)
        self.late_writes = 0
        self._terminals = terminals
        self._tasks: dict[int, CardTask] = {}
        self._numbers = itertools.count(1)
        self._changed = threading.Condition()
        self._present = True
        self._closed = False
        self._clock = threading.Thread(target=self._run_clock, name="card clock", daemon=True)
        if paced:
            self._clock.start()

    def close(self) -> None:
        """Stop the clock."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if self.paced:
            self._clock.join()

    def remove(self) -> None:
        """Pull the card out: without power its outputs are at 0 V, and every call finds no device."""
        with self._changed:
            self._present = False
            self.outputs_v = dict.fromkeys(self.model.outputs, 0.0)
            self._changed.notify_all()

    def reset(self, device: str) -> None:
        """Abort every task and put the outputs to 0 V, as a reset does on M Series cards."""
        with self._changed:
            self.require(device)
            for task in self._tasks.values():
                task.aborted = task.aborted or task.running or task.reserved
                task.running = task.reserved = False
            self.outputs_v = dict.fromkeys(self.model.outputs, 0.0)
            self._changed.notify_all()

    def require(self, device: str) -> None:
        """Raise CardError for a device that is not this one or is no longer there."""
        if device != self.name:
            raise CardError(UNKNOWN_DEVICE, f"Device identifier is invalid. Device Specified: {device}")
        if not self._present:
            raise CardError(DEVICE_GONE, "Device cannot be accessed: it is no longer present in the system.")

    def create(self) -> CardTask:
        """Return a new task without channels."""
        with self._changed:
            task = CardTask(next(self._numbers))
            self._tasks[task.number] = task
            return task

    def task(self, number: int) -> CardTask:
        """Return a task by its number. Raises CardError for one that was cleared, aborted or lost with the card."""
        task = self._tasks.get(number)
        if task is None:
            raise CardError(UNKNOWN_TASK, "Task specified is invalid or does not exist.")
        return task

    def add_input(self, number: int, channel: str, range_v: float, terminal: str) -> None:
        """Add an input to a task. Raises CardError for a terminal or a configuration that the card does not have."""
        with self._changed:
            own = self._own(channel, self.model.inputs)
            if terminal not in ("default", *self.model.terminals):
                raise CardError(NOT_SUPPORTED, f"Requested value {terminal} is not a supported value: terminal config.")
            self._check_range(range_v)
            self.task(number).inputs.append((own, range_v))

    def add_output(self, number: int, channel: str, range_v: float) -> None:
        """Add an output to a task. Raises CardError for one that the card does not have."""
        with self._changed:
            own = self._own(channel, self.model.outputs)
            self._check_range(range_v)
            self.task(number).outputs.append((own, range_v))

    def _own(self, channel: str, known: tuple[str, ...]) -> str:
        device, _, own = channel.partition("/")
        self.require(device)
        if own not in known:
            raise CardError(UNKNOWN_CHANNEL, f"Physical channel specified does not exist on this device: {channel}")
        return own

    def _check_range(self, range_v: float) -> None:
        if not 0.0 < range_v <= self.model.range_v:
            raise CardError(NOT_SUPPORTED, f"Requested value {range_v} V is not a supported value: range.")

    def set_clock(self, number: int, rate_hz: float, mode: str) -> None:
        """Time a task by the card. Raises CardError for what this card or this emulation cannot do."""
        with self._changed:
            task = self.task(number)
            every = 1.0 / (rate_hz * self.tick_s)
            if every < 1.0 - 1e-6 or abs(every - round(every)) > 1e-6:
                raise CardError(NOT_SUPPORTED, f"The emulated card has ticks of {self.tick_s} s; {rate_hz} Hz is none.")
            if mode == SINGLE_POINT and not self.model.single_point:
                raise CardError(NOT_SUPPORTED, "Requested value is not a supported value: hardware timed single point.")
            task.rate_hz, task.mode = rate_hz, mode

    def start(self, number: int) -> None:
        """Reserve what a task needs and start it. Raises CardError if another task has reserved it."""
        with self._changed:
            task = self.task(number)
            self._reserve(task)
            task.running, task.aborted, task.overwritten, task.late, task.ticks = True, False, False, False, 0
            task.rows.clear()

    def _reserve(self, task: CardTask) -> None:
        self.require(self.name)
        for other in self._tasks.values():
            if other is task or not other.reserved:
                continue
            shared = bool(task.inputs and other.inputs) or {c for c, _ in task.outputs} & {c for c, _ in other.outputs}
            if shared:
                raise CardError(RESERVED, "The specified resource is reserved.")
        task.reserved = True

    def stop(self, number: int, *, release: bool) -> None:
        """Stop a task; its outputs hold. ``release`` lets another task have what it reserved."""
        with self._changed:
            task = self.task(number)
            task.running, task.aborted, task.pending_v = False, False, None
            task.reserved = task.reserved and not release

    def clear(self, number: int) -> None:
        """Forget a task; its outputs hold."""
        with self._changed:
            self._tasks.pop(number, None)

    def write(self, number: int, value_v: float, *, auto_start: bool) -> None:
        """Apply a voltage now, or at the next clock edge of a task that has one."""
        with self._changed:
            task = self.task(number)
            self._require_unbroken(task)
            channel, range_v = task.outputs[0]
            if not abs(value_v) <= range_v:
                raise CardError(
                    OUT_OF_RANGE, f"Attempted writing analog data that is too large or too small: {value_v}"
                )
            if not task.running:
                if not auto_start:
                    raise CardError(NOT_RUNNING, "Write cannot be performed when the task is not running.")
                self._reserve(task)
            if task.mode != SINGLE_POINT:
                self.outputs_v[channel] = value_v
                return
            late, task.late, task.pending_v = task.late, False, value_v
            if late:
                raise CardError(LATE_WRITE, "Write did not complete before the arrival of the next sample clock.")

    def available(self, number: int) -> int:
        """Return how many readings of each channel wait to be fetched."""
        with self._changed:
            task = self.task(number)
            self._require_unbroken(task)
            return len(task.rows)

    def read(self, number: int, count: int, timeout_s: float) -> list[tuple[float, ...]]:
        """Return the next readings of all channels of a task, waiting until they are there.

        Raises CardError when they do not come in time, and when unread ones were overwritten.
        """
        with self._changed:
            task = self.task(number)
            until = time.monotonic() + timeout_s
            while len(task.rows) < count:
                self._require_unbroken(task)
                if not task.running:
                    raise CardError(NOT_RUNNING, "Read cannot be performed when the task is not running.")
                if not self.paced:
                    self._tick()
                elif not self._changed.wait(max(0.0, until - time.monotonic())) and time.monotonic() >= until:
                    raise CardError(NOT_YET, "Some or all of the samples requested have not yet been acquired.")
            self._require_unbroken(task)
            return [task.rows.popleft() for _ in range(count)]

    def _require_unbroken(self, task: CardTask) -> None:
        self.require(self.name)
        if task.aborted:
            raise CardError(ABORTED, "Operation aborted: the device was reset.")
        if task.overwritten:
            raise CardError(OVERWRITTEN, "The application is not able to keep up: unread samples were overwritten.")

    def _tick(self) -> None:
        """Let one tick pass: the wiring advances, then inputs are read, then outputs change."""
        read_v = self._terminals.advance(self.outputs_v)
        for task in self._tasks.values():
            if not task.running or task.rate_hz is None or not self._triggered(task):
                continue
            task.ticks += 1
            every = round(1.0 / (task.rate_hz * self.tick_s))
            if task.inputs and task.ticks % every == 0:
                self._take(task, read_v)
            if task.mode == SINGLE_POINT and task.ticks % every == 0:
                self._put(task)

    def _triggered(self, task: CardTask) -> bool:
        """Return whether a task's clock runs: at once, or from the start of the inputs if they trigger it."""
        if not task.trigger or task.ticks:
            return True
        return any(other.running and other.inputs and other.ticks <= 1 for other in self._tasks.values())

    def _take(self, task: CardTask, read_v: dict[str, float]) -> None:
        row = tuple(min(max(read_v.get(channel, 0.0), -range_v), range_v) for channel, range_v in task.inputs)
        if len(task.rows) >= task.buffer:
            task.overwritten = True
        else:
            task.rows.append(row)

    def _put(self, task: CardTask) -> None:
        if task.pending_v is None:
            # The output holds; the driver reports it at the next write.
            self.late_writes += 1
            task.late = True
        else:
            self.outputs_v[task.outputs[0][0]] = task.pending_v
            task.pending_v = None

    def _run_clock(self) -> None:
        start = time.monotonic()
        done = 0
        while not self._closed:
            due = int((time.monotonic() - start) / self.tick_s)
            with self._changed:
                # A few ticks at a time, so that calls are served even if the wire takes longer than the clock.
                for _ in range(min(due - done, 20)):
                    self._tick()
                    done += 1
                self._changed.notify_all()
            if done >= due:
                time.sleep(LOOK_S)
