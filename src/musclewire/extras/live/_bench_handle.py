"""The server's end of one bench: it starts the rig's process, passes on what people ask, and knows what it shows."""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
import tempfile
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from musclewire.errors import RigError
from musclewire.extras.live._messages import Answer, Command
from musclewire.extras.live._ring import RingRows, RowRing, create_ring
from musclewire.extras.live._silence import LEASE_S

# A command is answered with its first sample: after compiling, and after the slowest of samples.
MAX_ANSWER_S = 60.0
MAX_STOP_S = 1.0  # [s] in which a process must confirm a stop, or it is ended by SIGTERM
MAX_TERM_S = 0.5  # [s] after which it is killed then
# How long one that has confirmed may take to end: its recording is written meanwhile.
MAX_END_S = 3.0
# A state may hold the branches of a model and a long list of recordings.
MAX_LINE_BYTES = 1 << 24
GONE = "{}: a board's drive expires by itself, a card's guardian switches off; cut the supply to be sure"
ENDED = "the rig's process has ended ({})"
GIVEN_UP = f"the rig's process did not confirm a stop within {MAX_STOP_S:g} s and was ended"
SERVER_ENDED = "the end of the server"


@dataclass(frozen=True)
class BenchSettings:
    """How a bench's process is started."""

    identifier: str  # the bench's name in addresses and messages
    rig: str  # name, or path of a rig file, from the command line and from nowhere else
    folder: Path  # where recordings and models go; it exists
    seed: int | None = None
    cpu: int | None = None  # core that the process is pinned to
    priority: bool = False
    # A run that heats ends, and its lease, if whoever has control gives no sign for this long: with it the wire is safe
    # within a second of a lost connection. No option sets it; a test that is not about it gives more, as a busy machine
    # starves it.
    max_silence_s: float = LEASE_S


class BenchHandle:
    """One bench as the server sees it. All methods are called from the event loop's thread."""

    def __init__(self, settings: BenchSettings) -> None:
        """Start nothing yet."""
        self.settings = settings
        self.state: dict[str, Any] = {"bench": settings.identifier, "revision": 0, "phase": "starting", "why": ""}
        self.on_change: list[Callable[[BenchHandle], None]] = []
        # How many stops have been ordered: an order to switch on that came before the last one is not passed on.
        self.stops = 0
        self._given_up = False
        self._process: asyncio.subprocess.Process | None = None
        self._answers: dict[int, asyncio.Future[Answer]] = {}
        self._numbers = 0
        self._ring: RowRing | None = None
        self._ring_folder: tempfile.TemporaryDirectory[str] | None = None
        self._reader: asyncio.Task[None] | None = None
        # Of the stops that were ordered, in their order; done when the drive is off or the process has ended.
        self._confirmations: deque[asyncio.Future[None]] = deque()
        self._killers: set[asyncio.Task[None]] = set()

    @property
    def identifier(self) -> str:
        """Name of the bench."""
        return self.settings.identifier

    @property
    def revision(self) -> int:
        """Number of the present state."""
        return int(self.state["revision"])

    @property
    def layouts(self) -> dict[int, tuple[str, ...]]:
        """Columns of rows by the number of their layout."""
        return {int(key): tuple(names) for key, names in self.state.get("layouts", {}).items()}

    async def start(self) -> None:
        """Start the process; its state says when it is there. Raises OSError if it cannot be started."""
        memory = Path("/dev/shm")
        self._ring_folder = tempfile.TemporaryDirectory(prefix="musclewire-", dir=memory if memory.is_dir() else None)
        path = Path(self._ring_folder.name) / "rows"
        create_ring(path)
        self._ring = RowRing(path)
        self._process = await asyncio.create_subprocess_exec(
            sys.executable,
            *("-P", "-m", "musclewire.extras.live._bench"),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            start_new_session=True,
            limit=MAX_LINE_BYTES,
        )
        chosen = self.settings
        self._send(
            {
                "bench": chosen.identifier,
                "rig": chosen.rig,
                "folder": str(chosen.folder.absolute()),
                "ring": str(path),
                "seed": chosen.seed,
                "cpu": chosen.cpu,
                "priority": chosen.priority,
                "max_silence_s": chosen.max_silence_s,
            }
        )
        self._reader = asyncio.create_task(self._read(self._process))

    async def close(self) -> None:
        """Switch off and end the process, by force if it does not end."""
        process = self._process
        if process is not None:
            self.stop(SERVER_ENDED)
            self._process = None
            if process.stdin is not None:
                process.stdin.close()  # its end is the order to switch off and to end
            await ended(process, None, process.terminate, process.kill)
        if self._reader is not None:
            await self._reader
        if self._ring is not None and self._ring_folder is not None:
            self._ring.close()
            self._ring_folder.cleanup()
            self._ring = None

    async def command(self, command: Command, stops_before: int | None = None) -> Answer:
        """Pass on a command, unless there was a stop after the count ``stops_before``; return whether it has begun."""
        if command.do == "stop":
            self.stop("whoever is at the page")
            return Answer(True)
        if stops_before not in (None, self.stops):
            return Answer(False, "a stop came after this command: order it again when it is safe")
        if self._process is None:
            return Answer(False, str(self.state["why"]))
        self._numbers += 1
        number = self._numbers
        answer = self._answers[number] = asyncio.get_running_loop().create_future()
        self._send({"command": command.model_dump(), "number": number})
        try:
            return await asyncio.wait_for(answer, MAX_ANSWER_S)
        except TimeoutError:
            return Answer(False, f"the rig's process has not answered for {MAX_ANSWER_S:g} s: stop it")
        finally:
            self._answers.pop(number, None)

    def stop(self, who: str) -> asyncio.Future[None]:
        """Order the drive off, now; the future is done when it is confirmed or the process has ended.

        Not to be cancelled.

        A process that does not confirm within a second, because it is frozen or hangs, is ended: by SIGTERM, and half a
        second later by force. One that has only just been started has no rig yet and is waited for.
        """
        self.stops += 1
        confirmation: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        if self._process is None:
            confirmation.set_result(None)
            return confirmation
        self._confirmations.append(confirmation)
        self._send({"stop": who})
        killer = asyncio.create_task(self._end_unless_stopped(self._process, confirmation))
        self._killers.add(killer)
        killer.add_done_callback(self._killers.discard)
        return confirmation

    def release(self, why: str) -> None:
        """End the present run: whoever had control is lost or has left."""
        self._send({"release": why})

    def alive(self) -> None:
        """Pass on that whoever has control is there."""
        self._send({"alive": 1})

    def rows(self, cursor: int) -> tuple[int, list[RingRows], int]:
        """Return the rows after a cursor, as ``RowRing.read`` does; below 0 for none of those that are there."""
        return (cursor, [], 0) if self._ring is None else self._ring.read(cursor)

    def _send(self, message: dict[str, Any]) -> None:
        """Write a message; never waits."""
        process = self._process
        if process is not None and process.stdin is not None and not process.stdin.is_closing():
            with contextlib.suppress(OSError, RuntimeError):
                process.stdin.write(json.dumps(message).encode() + b"\n")

    async def _read(self, process: asyncio.subprocess.Process) -> None:
        """Take what the process says until it ends."""
        assert process.stdout is not None
        while line := await process.stdout.readline():
            self._take(json.loads(line))
        code = await process.wait()
        if self._process is not None:
            self._process = None
            self._become(
                {
                    **self.state,
                    "revision": self.revision + 1,
                    "phase": "failed",
                    "why": GONE.format(GIVEN_UP if self._given_up else ENDED.format(code)),
                    "doing": None,
                }
            )
        for waiting in self._answers.values():
            if not waiting.done():
                waiting.set_result(Answer(False, str(self.state["why"])))
        while self._confirmations:
            self._confirmations.popleft().set_result(None)

    def _take(self, message: dict[str, Any]) -> None:
        """Take one message of the process."""
        if "state" in message:
            self._become(message["state"])
        elif "stopped" in message:
            self._confirmations.popleft().set_result(None)
        elif (waiting := self._answers.get(message["answer"])) is not None and not waiting.done():
            waiting.set_result(Answer(bool(message["accepted"]), str(message["message"])))

    def _become(self, state: dict[str, Any]) -> None:
        """Take a state and pass it on."""
        self.state = state
        for call in self.on_change:
            call(self)

    async def _end_unless_stopped(
        self, process: asyncio.subprocess.Process, confirmation: asyncio.Future[None]
    ) -> None:
        """End the process if it does not confirm a stop in time; before its first state it has no rig."""
        await asyncio.wait([confirmation], timeout=MAX_STOP_S if self.revision else MAX_ANSWER_S)
        if not confirmation.done():
            self._given_up = True
            await ended(process, process.terminate, process.kill, max_wait_s=MAX_TERM_S)


async def ended(
    process: asyncio.subprocess.Process, *forces: Callable[[], None] | None, max_wait_s: float = MAX_END_S
) -> None:
    """Wait for a process's end, so long [s] after each of the forces. Raises RigError if it goes on after the last."""
    for force in forces:
        if force is not None:
            with contextlib.suppress(ProcessLookupError):
                force()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(process.wait(), max_wait_s)
            return
    raise RigError("the rig's process cannot be ended: cut the supply")
