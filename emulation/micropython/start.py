"""Before the board's own files: its time and its turns are the bench's."""

import asyncio
import sys

import bench
import bench_line
import bench_time

sys.modules["time"], sys.modules["musclewire_line"] = bench_time, bench_line
import machine  # noqa: E402

pause = asyncio.sleep_ms


async def sleep_ms(duration_ms):
    machine.pins.turn_ended()
    await pause(1)


async def said(program):
    """Run the program; an exception that ends it is printed, as a terminal shows it."""
    try:
        await program
    except BaseException as problem:
        sys.print_exception(problem)


started = []
asyncio.sleep_ms = sleep_ms
asyncio.run = lambda program: started.append(asyncio.create_task(said(program)))
import boot  # noqa: E402,F401
import main  # noqa: E402,F401

if not started:
    bench.halt()
