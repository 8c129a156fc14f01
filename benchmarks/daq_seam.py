"""How fast the NI-DAQ rig goes at its seam, and how fast its guardian switches off: NI's client against our server.

Prints JSON. ``closed_loop``: exchanges per second of a rig whose card does not wait for the clock, so that what is
left is what calls cost: NI's client, gRPC, the guardian, the emulated card and wire. ``by_the_clock``: rigs at their
own pace, with the fraction of late samples and the accuracy of their times. ``host_killed`` and ``host_stalled``:
the time from SIGKILL or SIGSTOP of a heating host to the card at 0 V. The server is a process of its own.
``--quick`` measures less. From the root of a checkout: python -m benchmarks.daq_seam
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from emulation.daq_bench import card_of
from emulation.daq_server import DaqServer

import musclewire
from musclewire.extras.board import NiDaqConfiguration
from musclewire.rigs import rig_configuration, shipped_rig_files

ROOT = Path(__file__).parents[1]
# Period, readings per second, readings averaged.
PACES = {20: (0.05, 1000.0, 40), 100: (0.01, 1000.0, 6), 200: (0.005, 2000.0, 5), 500: (0.002, 10_000.0, 8)}
HOST = """
import sys
import musclewire
with musclewire.open_rig(sys.argv[1]) as rig:
    rig.exchange(rig.sense_voltage_v)
    while True:
        rig.exchange(2.0)
"""


def changed(name: str, rate_hz: int, address: str | None = None) -> NiDaqConfiguration:
    """Return a shipped rig at another rate."""
    configuration = rig_configuration(name)[0]
    assert isinstance(configuration, NiDaqConfiguration)
    period, reading_rate, readings = PACES[rate_hz]
    data = {"sample_period": period, "reading_rate": reading_rate, "readings": readings, "grpc": address}
    return NiDaqConfiguration.model_validate({**configuration.model_dump(), **data})


def as_file(folder: Path, name: str, rate_hz: int, address: str) -> Path:
    """Return a rig file for another process."""
    period, reading_rate, readings = PACES[rate_hz]
    text = shipped_rig_files()[name].read_text()
    text = text.replace('kind = "nidaq"', f'kind = "nidaq"\ngrpc = "{address}"')
    text = text.replace('sample_period = "50 ms"', f"sample_period = {period}")
    text = text.replace('reading_rate = "1 kHz"', f"reading_rate = {reading_rate}")
    text = text.replace("readings = 40", f"readings = {readings}")
    file = folder / f"{name}.toml"
    file.write_text(text)
    return file


@contextlib.contextmanager
def served(name: str, rate_hz: int, pace: str) -> Iterator[str]:
    """Serve a card in a process of its own; give its address."""
    with tempfile.TemporaryDirectory() as folder:
        file = as_file(Path(folder), name, rate_hz, "127.0.0.1:0")
        server = subprocess.Popen(
            [sys.executable, "-m", "emulation.daq_server", "--card", str(file), "--pace", pace, "--port", "0"],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            assert server.stdout is not None
            line = next(line for line in server.stdout if line.startswith("grpc"))
            yield line.split('"')[1]
        finally:
            server.terminate()
            server.communicate()


def closed_loop(name: str, rate_hz: int, exchanges: int) -> dict[str, object]:
    """Return how many exchanges per second there are when no clock makes them wait."""
    with served(name, rate_hz, "free") as address, musclewire.open_rig(changed(name, rate_hz, address)) as rig:
        for _ in range(20):
            rig.exchange(rig.sense_voltage_v)
        lasted_s = []
        for index in range(exchanges):
            began = time.perf_counter()
            rig.exchange(0.6 + 0.001 * (index % 100))
            lasted_s.append(time.perf_counter() - began)
    ordered = sorted(lasted_s)
    return {
        "rig": name,
        "readings_per_sample": round(PACES[rate_hz][0] * PACES[rate_hz][1]),
        "exchanges_per_s": round(exchanges / sum(lasted_s)),
        "median_ms": round(1e3 * statistics.median(lasted_s), 3),
        "p99_ms": round(1e3 * ordered[int(0.99 * exchanges)], 3),
    }


def by_the_clock(name: str, rate_hz: int, lasting_s: float) -> dict[str, object]:
    """Return how a rig keeps its own pace against a card that runs by the clock; a trip ends it."""
    with served(name, rate_hz, "clock") as address, musclewire.open_rig(changed(name, rate_hz, address)) as rig:
        for _ in range(20):
            first = rig.exchange(rig.sense_voltage_v)
        began, late_before = time.monotonic(), rig.metadata()["late_samples"]
        count, wanted = 0, round(lasting_s * rate_hz)
        while count < wanted:
            # At the sense voltage a late sample is counted and does not end the run.
            sample = rig.exchange(rig.sense_voltage_v)
            count += 1
        wall_s = time.monotonic() - began
        card_s = sample.time_s - first.time_s
        late = rig.metadata()["late_samples"] - late_before
    return {
        "rig": name,
        "rate_hz": rate_hz,
        "samples": count,
        "late_share": round(late / count, 5),
        "card_minus_wall_ms": round(1e3 * (card_s - wall_s), 2),
    }


def switched_off(name: str, number: signal.Signals, rounds: int) -> dict[str, object]:
    """Return how long after a signal to its heating host the card is at 0 V.

    A host that a busy machine has made too late ends by itself; such a round is left out and counted.
    """
    found_s: list[float] = []
    disturbed = 0
    while len(found_s) < rounds and disturbed < 2 * rounds:
        with tempfile.TemporaryDirectory() as folder, DaqServer(card_of(changed(name, 20), paced=True)) as server:
            file = as_file(Path(folder), name, 20, server.address)
            host = subprocess.Popen([sys.executable, "-c", HOST, str(file)], stderr=subprocess.DEVNULL)
            wait_until(lambda: server.card.outputs_v["ao0"] == 2.0)
            time.sleep(0.3)
            os.kill(host.pid, number)
            began = time.monotonic()
            if server.card.outputs_v["ao0"] == 2.0:
                wait_until(lambda: server.card.outputs_v["ao0"] == 0.0)
                found_s.append(time.monotonic() - began)
            else:
                disturbed += 1
            host.kill()
            host.wait()
    return {
        "rig": name,
        "rounds": len(found_s),
        "disturbed": disturbed,
        "median_ms": round(1e3 * statistics.median(found_s), 1) if found_s else None,
        "longest_ms": round(1e3 * max(found_s), 1) if found_s else None,
    }


def wait_until(reached: Callable[[], bool]) -> None:
    """Wait, at most 30 s."""
    until = time.monotonic() + 30.0
    while not reached():
        if time.monotonic() > until:
            raise TimeoutError("the card did not come to the voltage within 30 s")
        time.sleep(0.0005)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    names = ("ni-pci-6229", "ni-usb-6001")
    result = {
        "load": [round(load, 1) for load in os.getloadavg()],
        "closed_loop": [
            closed_loop(name, rate_hz, 200 if quick else 1000) for name in names for rate_hz in (20, 100, 500)
        ],
        "by_the_clock": [
            by_the_clock(name, rate_hz, 2.0 if quick else 10.0)
            for name in names
            for rate_hz in ((20, 100) if quick else (20, 100, 200))
        ],
        "host_killed": [switched_off(name, signal.SIGKILL, 1 if quick else 5) for name in names],
        "host_stalled": [switched_off(name, signal.SIGSTOP, 1 if quick else 5) for name in names],
    }
    print(json.dumps(result, indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
