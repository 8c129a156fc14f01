"""A network cable between browser and server that can be pulled: nothing is closed, and nothing arrives any more."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from urllib.parse import urlsplit

__all__ = ["Cable", "cable_to"]

PORTION_BYTES = 65536


class Cable:
    """Connections to a server are passed on while the cable is in; pulled, both ends hear nothing, not even an end.

    Parameters
    ----------
    url
        The server's address.
    """

    def __init__(self, url: str) -> None:
        """Begin with the cable in, not yet listening."""
        self._host, self._port = urlsplit(url).hostname or "127.0.0.1", urlsplit(url).port or 80
        self._query = urlsplit(url).query
        self._is_in = threading.Event()
        self._is_in.set()
        self._tasks: set[asyncio.Task[None]] = set()
        self.loop = asyncio.new_event_loop()
        self._ended = asyncio.Event()
        self.link = ""

    def pull(self) -> None:
        """Pull the cable."""
        self._is_in.clear()

    def run(self, listening: threading.Event) -> None:
        """Pass on until the end."""
        self.loop.run_until_complete(self._serve(listening))
        self.loop.close()

    def end(self) -> None:
        """End; called from another thread."""
        self.loop.call_soon_threadsafe(self._ended.set)

    async def _serve(self, listening: threading.Event) -> None:
        server = await asyncio.start_server(self._connect, "127.0.0.1", 0)
        self.link = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/?{self._query}"
        listening.set()
        await self._ended.wait()
        server.close()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there_reader, there_writer = await asyncio.open_connection(self._host, self._port)
        for source, sink in ((reader, there_writer), (there_reader, writer)):
            task = asyncio.create_task(self._pass_on(source, sink))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _pass_on(self, source: asyncio.StreamReader, sink: asyncio.StreamWriter) -> None:
        """Pass on what comes from one end to the other; what comes once the cable is out is gone."""
        try:
            with suppress(OSError):
                while data := await source.read(PORTION_BYTES):
                    if self._is_in.is_set():
                        sink.write(data)
                        await sink.drain()
            if not self._is_in.is_set():
                await self._ended.wait()
        finally:
            sink.close()


@contextmanager
def cable_to(url: str) -> Iterator[Cable]:
    """Lay a cable to a server, in a thread of its own."""
    cable, listening = Cable(url), threading.Event()
    thread = threading.Thread(target=cable.run, args=(listening,), daemon=True)
    thread.start()
    assert listening.wait(10.0)
    try:
        yield cable
    finally:
        cable.end()
        thread.join(10.0)
