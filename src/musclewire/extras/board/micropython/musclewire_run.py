"""The loop that runs until the power goes; whatever ends it, the wire is off."""

import asyncio
import time

import musclewire_numbers as n
import musclewire_pins
from musclewire_board import Application

TICK_US = round(1e6 * n.TICK_S)


async def run(bench):
    """Take bytes as they come and a reading at each tick; whatever ends this, the wire is off."""
    try:
        application = Application(bench.send, bench.set_drive, bench.reset_cause)
        due = time.ticks_add(time.ticks_us(), TICK_US)
        while True:
            for byte in bench.received():
                application.byte(byte)
            if time.ticks_diff(time.ticks_us(), due) >= 0:
                # Two clocks: heat counts the ticks that have passed, whatever a reading took.
                behind = time.ticks_diff(time.ticks_us(), due) // TICK_US
                application.tick(bench.reading(application.loop.armed), 1 + behind)
                due = time.ticks_add(due, TICK_US * (1 + behind))
                bench.watch(application.loop.armed)
            await asyncio.sleep_ms(1)
    finally:
        bench.close()


def start():
    """Run it on the chip."""
    asyncio.run(run(musclewire_pins.SwitchedCircuit()))
