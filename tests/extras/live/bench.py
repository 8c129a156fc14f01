"""A real bench process on the simulated rig, for tests."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from musclewire.extras.live._bench_handle import BenchHandle, BenchSettings
from musclewire.extras.live._messages import Answer, read_command

# Only so that a fault does not hang a test: no machine is judged by it.
MAX_WAIT_S = 60.0


@asynccontextmanager
async def bench(
    folder: Path, rig: str = "simulated", seed: int | None = 1, max_silence_s: float = MAX_WAIT_S
) -> AsyncIterator[BenchHandle]:
    """Start a bench and end it; unless it is given, no silence of a starved test ends a run."""
    handle = BenchHandle(BenchSettings("one", rig, folder, seed, max_silence_s=max_silence_s))
    await handle.start()
    try:
        yield handle
    finally:
        await handle.close()


async def ask(handle: BenchHandle, **command: Any) -> Answer:
    """Send a command."""
    return await handle.command(read_command(command))


async def until_phase(handle: BenchHandle, *phases: str) -> None:
    """Wait until the bench is in one of these phases."""
    async with asyncio.timeout(MAX_WAIT_S):
        while handle.state["phase"] not in phases:
            await asyncio.sleep(0.01)


@asynccontextmanager
async def in_control(handle: BenchHandle) -> AsyncIterator[None]:
    """Give the signs of somebody who is there."""

    async def beat() -> None:
        while True:
            handle.alive()
            await asyncio.sleep(0.1)

    beating = asyncio.create_task(beat())
    try:
        yield
    finally:
        beating.cancel()
