"""How long a stop takes that another thread asks for while a sample is awaited.

Prints JSON, a row for each rig and rate: [{rig, sample_period_s, stops, ordered_ms, confirmed_ms, loop_ended_ms}], each
time as {median, p95, max}, counted from the call of ``close`` at a random moment of the sample period:

- ordered: 0 V is the drive of the simulated rig, is on its way to the board, has reached the card's output
- confirmed: ``close`` has returned: a board has answered, a card's guardian has ended
- loop_ended: the exchange that was waiting has ended with its RigError

``bars_met`` says whether every ordered and confirmed stop of the simulated and serial rigs took at most 20 ms. The
serial rig is the real firmware in its emulator, which keeps time by the clock. ``--stops`` sets how often each rig is
stopped, ``--quick`` stops each five times, ``--only`` takes the rigs whose name contains a text. From the root of a
checkout: python -m benchmarks.stop_latency
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from emulation.board import EmulatedBoard, firmware_for
from emulation.daq_bench import card_of
from emulation.daq_server import DaqServer

from musclewire.errors import CallerError, RigError
from musclewire.extras.board import MessageKind, NiDaqConfiguration, SerialConfiguration, SerialDevice
from musclewire.rigs import GuardedRig, open_rig, rig_configuration

BAR_MS = 20.0
# A stop comes at a random moment of a sample period, after a few samples.
SAMPLES_BEFORE = 3
COLD_K = 295.15
Opens = Callable[[], GuardedRig]
Orders = list[int]


class Stop(NamedTuple):
    """Times of one stop after its call [ms]; ``ordered_ms`` is that of the return where nothing shows it earlier."""

    ordered_ms: float
    confirmed_ms: float
    loop_ended_ms: float


def stopped(rig: GuardedRig, orders: Orders, after_s: float) -> Stop:
    """Stop a rig whose loop waits for a sample, some time after its first samples."""
    ended_ns: list[int] = []
    going = threading.Event()

    def loop() -> None:
        try:
            for sample in range(10**9):
                if sample == SAMPLES_BEFORE:
                    going.set()
                rig.exchange(rig.drive_amplitude_v * 0.5)
        except RigError:
            ended_ns.append(time.perf_counter_ns())

    thread = threading.Thread(target=loop)
    thread.start()
    assert going.wait(60.0)
    time.sleep(after_s)
    began_ns = time.perf_counter_ns()
    rig.close()
    confirmed_ns = time.perf_counter_ns()
    thread.join(60.0)
    first_ns = next((at for at in orders if at >= began_ns), confirmed_ns)
    return Stop(*(1e-6 * (at - began_ns) for at in (first_ns, confirmed_ns, ended_ns[0])))


def noted(call: Callable[..., Any], orders: Orders, off: Callable[..., bool]) -> Callable[..., Any]:
    """Return a function as it is that also notes when it has ordered 0 V."""

    def noting(*given: Any, **named: Any) -> Any:
        answer = call(*given, **named)
        if off(*given):
            orders.append(time.perf_counter_ns())
        return answer

    return noting


@contextmanager
def simulated(sample_period_s: float, real_time: bool) -> Iterator[tuple[Opens, Orders]]:
    """Give what opens a simulated rig; 0 V is out when ``close`` returns."""
    yield partial(open_rig, "simulated", real_time=real_time, sample_period_s=sample_period_s), []


@contextmanager
def serial(sample_period_s: float) -> Iterator[tuple[Opens, Orders]]:
    """Give what opens a rig on an emulated board that runs all the time, and when OFF was handed to its line."""
    shipped = rig_configuration("serial-board")[0]
    orders: Orders = []

    def opened(configuration: SerialConfiguration) -> GuardedRig:
        rig = open_rig(configuration, wire_temperature_k=COLD_K)
        assert isinstance(rig.device, SerialDevice)
        board = rig.device._board
        board.send = noted(board.send, orders, lambda kind, *_: kind is MessageKind.OFF)  # type: ignore[method-assign]
        return rig

    with tempfile.TemporaryDirectory() as folder:
        elf = firmware_for("mps2-an386", Path(folder))
        with EmulatedBoard(pace="clock", elf=elf) as board:
            changed = {"port": board.port_url, "sample_period": sample_period_s}
            yield partial(opened, SerialConfiguration.model_validate({**shipped.model_dump(), **changed})), orders


@contextmanager
def card(sample_period_s: float) -> Iterator[tuple[Opens, Orders]]:
    """Give what opens a rig on an emulated card that keeps time by the clock, and when 0 V reached its output."""
    shipped = rig_configuration("ni-usb-6001")[0]
    wiring = NiDaqConfiguration.model_validate({**shipped.model_dump(), "sample_period": sample_period_s})
    off_v = (0.0 - wiring.output.offset) / wiring.output.gain
    emulated, orders = card_of(wiring, paced=True), []
    emulated.write = noted(emulated.write, orders, lambda _, volts: volts == off_v)  # type: ignore[method-assign]
    with DaqServer(emulated) as server:
        yield partial(open_rig, wiring.model_copy(update={"grpc": server.address}), wire_temperature_k=COLD_K), orders


CASES = {
    "simulated, 1 Hz": (1.0, partial(simulated, 1.0, True)),
    "simulated, 20 Hz": (0.05, partial(simulated, 0.05, True)),
    "simulated, 1 kHz": (1e-3, partial(simulated, 1e-3, True)),
    "simulated, no clock": (0.05, partial(simulated, 0.05, False)),
    "serial, 20 Hz": (0.05, partial(serial, 0.05)),
    "serial, 100 Hz": (0.01, partial(serial, 0.01)),
    "card, 20 Hz": (0.05, partial(card, 0.05)),
}


def summary(times_ms: list[float]) -> dict[str, float]:
    """Return median, 95th percentile and maximum."""
    median, p95 = np.percentile(times_ms, [50.0, 95.0])
    return {"median": round(median, 2), "p95": round(p95, 2), "max": round(max(times_ms), 2)}


def main() -> None:
    """Stop every rig and print the times."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stops", type=int, default=40)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="")
    given = parser.parse_args()
    rows: list[dict[str, object]] = []
    met = True
    for name, (period_s, opened) in CASES.items():
        if given.only not in name:
            continue
        moments = random.Random(1)
        try:
            with opened() as (opens, orders):
                stops = [
                    stopped(opens(), orders, moments.uniform(0.0, period_s))
                    for _ in range(5 if given.quick else given.stops)
                ]
        except CallerError as missing:
            print(f"{name}: not measured: {missing}", file=sys.stderr)
            continue
        times = {f"{key}": summary([getattr(stop, key) for stop in stops]) for key in Stop._fields}
        judged = not name.startswith("card")
        met = met and (not judged or max(times["ordered_ms"]["max"], times["confirmed_ms"]["max"]) <= BAR_MS)
        rows.append({"rig": name, "sample_period_s": period_s, "stops": len(stops), **times})
    print(json.dumps({"rows": rows, "bar_ms": BAR_MS, "bars_met": met}, indent=1))


if __name__ == "__main__":
    main()
