"""A Dask cluster of processes on this machine, started as the documentation says; its workers can be killed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Self


class DaskCluster:
    """A scheduler and its workers, one thread each, as processes; all are gone at the end of the ``with`` block."""

    def __init__(self, folder: Path, workers: int = 2) -> None:
        self._folder, self._wanted = folder, workers
        self._file = folder / "scheduler.json"
        self._environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
        self._workers: list[subprocess.Popen[bytes]] = []
        self.address = ""
        self.killed = 0

    def _started(self, *arguments: str) -> subprocess.Popen[bytes]:
        """Start a part of Dask; what it says goes into a file of the folder."""
        with (self._folder / f"dask-{arguments[0]}.log").open("ab") as log:
            command = [sys.executable, "-W", "ignore", "-m", "dask", *arguments, "--no-dashboard"]
            return subprocess.Popen(command, env=self._environment, stdout=log, stderr=log, cwd=self._folder)

    def __enter__(self) -> Self:
        self._scheduler = self._started("scheduler", "--port", "0", "--scheduler-file", str(self._file))
        # The scheduler writes it when it listens, and makes it before it fills it.
        while not (self._file.exists() and self._file.read_text("utf-8").endswith("}")):
            assert self._scheduler.poll() is None, (self._folder / "dask-scheduler.log").read_text("utf-8")
            time.sleep(0.05)
        self.address = json.loads(self._file.read_text("utf-8"))["address"]
        for _ in range(self._wanted):
            self.add_worker()
        return self

    def add_worker(self) -> None:
        """Start one more worker. Nobody nurses it: killed, it stays dead."""
        options = ("--scheduler-file", str(self._file), "--nthreads", "1", "--no-nanny", "--death-timeout", "60")
        self._workers.append(self._started("worker", *options))

    def kill_a_worker(self) -> None:
        """Kill the oldest worker, whatever it does, and start another one."""
        oldest = self._workers.pop(0)
        oldest.kill()
        oldest.wait()
        self.killed += 1
        self.add_worker()

    def replace_dead_workers(self) -> None:
        """Start a worker for each that has died by itself."""
        for worker in [one for one in self._workers if one.poll() is not None]:
            self._workers.remove(worker)
            self.add_worker()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        for process in (*self._workers, self._scheduler):
            process.kill()
            process.wait()
