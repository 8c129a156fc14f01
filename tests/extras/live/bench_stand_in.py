"""A bench without a process, for tests of access and leases: it notes what it is told and keeps no rig."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np

from musclewire.extras.live._messages import Answer
from musclewire.extras.live._ring import RingRows
from musclewire.extras.live._silence import LEASE_S

COLUMNS = ("time_s", "run_s", "drive_voltage_v", "wire_voltage_v", "shunt_voltage_v")


class BenchStandIn:
    """Notes every call; ``told`` has them in order."""

    def __init__(self, identifier: str = "simulated") -> None:
        self.identifier = identifier
        self.settings = SimpleNamespace(max_silence_s=LEASE_S)
        self.state: dict[str, Any] = {
            "bench": identifier,
            "revision": 1,
            "phase": "ready",
            "simulated": True,
            "rig": {"simulated": True, "shunt_resistance_ohm": 2.0, "sample_period_s": 0.05},
            "clock_speed": 1.0,
            "gains": None,
        }
        self.stops = 0
        self.told: list[tuple[str, Any]] = []
        self.on_change: list[Callable[[Any], None]] = []
        self.layouts = {1: COLUMNS}
        self.signs_of_life = 0
        self._rows: list[list[float]] = []

    @property
    def revision(self) -> int:
        return int(self.state["revision"])

    def change(self, **parts: Any) -> None:
        self.state = {**self.state, **parts, "revision": self.revision + 1}
        for listener in self.on_change:
            listener(self)

    async def start(self) -> None:
        self.told.append(("start", None))

    async def close(self) -> None:
        self.told.append(("close", None))

    async def command(self, command: Any, stops_before: int) -> Answer:
        self.told.append(("command", command))
        return Answer(stops_before == self.stops, "")

    def stop(self, who: str) -> asyncio.Future[None]:
        self.stops += 1
        self.told.append(("stop", who))
        self.change(phase="stopped")
        confirmation: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        confirmation.set_result(None)
        return confirmation

    def release(self, why: str) -> None:
        self.told.append(("release", why))

    def alive(self) -> None:
        self.signs_of_life += 1

    def add_row(self, *values: float) -> None:
        self._rows.append(list(values))

    def rows(self, cursor: int) -> tuple[int, list[RingRows], int]:
        count = len(self._rows)
        if cursor < 0 or cursor >= count:
            return count, [], 0
        return count, [RingRows(1, np.array(self._rows[cursor:]))], 0
