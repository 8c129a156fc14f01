"""A running ``musclewire serve`` for benchmarks and tests: the real program with the real simulated rig."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple
from urllib.parse import parse_qs, urlsplit

__all__ = ["RunningServer", "running_server"]

# Far above what it takes: only a server that hangs meets it.
END_S = 60.0


class RunningServer(NamedTuple):
    """A server: the link of its page, its process, and the file of what it says on stderr."""

    link: str
    process: subprocess.Popen[str]
    errors: Path

    @property
    def token(self) -> str | None:
        """The token of its link; None if it is not printed."""
        return parse_qs(urlsplit(self.link).query).get("token", [None])[0]

    @property
    def url(self) -> str:
        """Its address without the token, with a slash at the end."""
        return self.link.partition("?")[0]

    @property
    def socket_url(self) -> str:
        """Where its WebSocket is."""
        return f"{self.url.replace('http', 'ws', 1)}api/v1/live"

    @property
    def headers(self) -> dict[str, str]:
        """What shows the token."""
        return {} if self.token is None else {"Authorization": f"Bearer {self.token}"}

    @property
    def said(self) -> str:
        """What it has said on stderr."""
        return self.errors.read_text("utf-8")


@contextmanager
def running_server(
    folder: Path,
    *options: str,
    rigs: Sequence[str] = ("simulated",),
    files: int | None = None,
    program: Sequence[str] = ("-m", "musclewire"),
) -> Iterator[RunningServer]:
    """Run ``musclewire serve`` in a folder until the block ends; on a port that is free, with so many open files."""
    errors = folder / "stderr.txt"
    command = [sys.executable, *program, "serve", *rigs, "--output", str(folder / "session"), *options]
    if files is not None:
        command = ["prlimit", f"--nofile={files}", *command]
    with errors.open("w") as file:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=file, text=True, cwd=folder)
    try:
        assert process.stdout is not None
        link = process.stdout.readline().strip()
        if not link:
            process.wait(END_S)
            raise RuntimeError(f"the server has not started: {errors.read_text('utf-8')}")
        yield RunningServer(link, process, errors)
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
        process.wait(END_S)
        if process.stdout is not None:
            process.stdout.close()
