"""A host that is killed or stalls while it heats: the guardian switches off. Real processes, real time.

A busy machine makes every process late, so what is waited for is an event; how long silence may last is tested by a
clock of the test's own (test_guardian_watch.py, test_guardian.py).
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from emulation.daq_bench import card_of
from emulation.daq_server import DaqServer
from tests.extras.board.contract.nidaq_rigs import COLD_K, at_seam, wiring_of

from musclewire.controllers import Event
from musclewire.errors import RigError
from musclewire.rigs import GuardedRig, ProtectionTripError, open_rig

pytestmark = pytest.mark.skipif(os.name != "posix", reason="not run: signals as POSIX has them")

NAMES = ("ni-pci-6229", "ni-usb-6001")
DRIVE_V = 2.0
# Only so that a fault does not hang a test: a busy machine takes long to start Python, and makes some hosts late.
PATIENCE_S = 180.0
# A host that heats until somebody stops it, by the public door.
HOST = f"""
import sys
import musclewire
with musclewire.open_rig(sys.argv[1], wire_temperature_k=295.15) as rig:
    rig.exchange(rig.sense_voltage_v)
    while True:
        rig.exchange({DRIVE_V})
"""


def interruptible() -> None:
    """Let a process be interrupted, also where this run was started as a shell's background job.

    Such a job ignores SIGINT, and so does all that it starts: a host of Python's would never notice.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class Bench:
    """A card that runs by the clock, and a host process that heats the wire on it."""

    def __init__(self, server: DaqServer, rig: Path) -> None:
        self.server, self.rig = server, rig
        self.host = heating(server, rig)

    def output_v(self) -> float:
        return output_v(self.server)

    def wait_until(self, reached: Callable[[float], bool]) -> None:
        """Wait until the output is as wanted."""
        until_s = time.monotonic() + PATIENCE_S
        while not reached(self.output_v()):
            assert time.monotonic() < until_s, f"{self.output_v()} V"
            time.sleep(0.001)

    def last_words(self) -> str:
        """Wait until host and guardian have ended, who share a standard error, and return what was said there."""
        return self.host.communicate(timeout=PATIENCE_S)[1]


@pytest.fixture(params=[NAMES[0], pytest.param(NAMES[1], marks=pytest.mark.emulated)])
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def bench(name: str, tmp_path: Path) -> Iterator[Bench]:
    with DaqServer(card_of(name, paced=True)) as server:
        found = Bench(server, rig_file(tmp_path, name, server.address))
        try:
            yield found
        finally:
            ended(found.host)


def output_v(server: DaqServer) -> float:
    return server.card.outputs_v["ao0"]


def heating(server: DaqServer, rig: Path) -> subprocess.Popen[str]:
    """Return a host that heats.

    A host that a busy machine makes late before it heats has rightly switched off and ended: another one is started.
    """
    until_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < until_s:
        command = [sys.executable, "-c", HOST, str(rig)]
        host = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=interruptible)
        while host.poll() is None and time.monotonic() < until_s:
            if output_v(server) == DRIVE_V:
                return host
            time.sleep(0.001)
        said = ended(host)
    raise AssertionError(f"no host heated within {PATIENCE_S} s; the last one said: {said}")


def ended(host: subprocess.Popen[str]) -> str:
    """End a host, also a stopped one, and return what it said on its standard error."""
    with contextlib.suppress(ProcessLookupError):
        host.send_signal(signal.SIGCONT)
    host.kill()
    return host.communicate()[1]


def exchange_often(rig: GuardedRig) -> None:
    """The kill may reach the guardian in the middle of an answer; the exchange after that must notice."""
    for _ in range(3):
        rig.exchange(DRIVE_V)


def leave(rig: GuardedRig) -> None:
    with rig:
        pass


def rig_file(folder: Path, name: str, address: str) -> Path:
    """Return a user's rig file: the one that comes along, with the address."""
    from musclewire.manifest import folder_of

    shipped = folder_of("musclewire.extras.board:rig_files") / f"{name}.toml"
    file = folder / "rig.toml"
    file.write_text(shipped.read_text().replace('kind = "nidaq"', f'kind = "nidaq"\ngrpc = "{address}"'))
    return file


def test_a_killed_host_leaves_no_voltage_on_the_card(bench: Bench) -> None:
    bench.host.kill()
    bench.last_words()
    assert bench.output_v() == 0.0


@pytest.mark.emulated
def test_after_a_killed_host_the_card_is_free_again(bench: Bench, name: str) -> None:
    bench.host.kill()
    bench.last_words()
    at_server = wiring_of(name).model_copy(update={"grpc": bench.server.address})
    with open_rig(at_server, wire_temperature_k=COLD_K) as rig:
        rig.exchange(rig.sense_voltage_v)


@pytest.mark.emulated
def test_a_stalled_host_leads_to_the_sense_voltage_and_then_off(bench: Bench, name: str) -> None:
    """The guardian's own record of the silence is at least the 0.25 s of the protection table."""
    until_s = time.monotonic() + PATIENCE_S
    while True:
        bench.host.send_signal(signal.SIGSTOP)
        bench.wait_until(lambda volts: volts < DRIVE_V)
        assert bench.output_v() in (0.0, pytest.approx(wiring_of(name).sense_voltage))
        bench.wait_until(lambda volts: volts == 0.0)
        bench.host.send_signal(signal.SIGCONT)
        said = bench.last_words()
        assert bench.output_v() == 0.0
        silent = re.search(r"no command for ([\d.]+) s: the guardian has switched off", said)
        if silent is not None:
            break
        # Stopped too late: a busy machine had made it late before, and it had switched off by itself, and says so.
        assert re.search(r"sample_late|command_missing|clock_leapt", said), said
        assert time.monotonic() < until_s, said
        bench.host = heating(bench.server, bench.rig)
    assert float(silent[1]) >= 0.25


def test_a_host_that_is_interrupted_switches_off_by_itself(bench: Bench) -> None:
    bench.host.send_signal(signal.SIGINT)
    assert bench.last_words().splitlines()[-1] == "KeyboardInterrupt"
    assert bench.output_v() == 0.0


def test_a_host_that_closes_after_its_guardian_was_killed_switches_off_by_itself(name: str) -> None:
    with at_seam(name) as rig:
        rig.exchange(DRIVE_V)
        rig.device.at_card._output._process.kill()
        rig.device.at_card._output._process.wait()
        assert rig.device.server.card.outputs_v["ao0"] == DRIVE_V  # a card holds its last voltage
    assert rig.device.server.card.outputs_v["ao0"] == 0.0


@pytest.mark.emulated
def test_a_card_that_cannot_be_reached_at_the_end_is_an_error_and_not_called_off(name: str) -> None:
    rig = at_seam(name, paced=True)
    rig.exchange(rig.sense_voltage_v)
    rig.device.server.close()
    with pytest.raises(RigError, match="did not answer at the end: 0 V was ordered and nothing confirms it"):
        leave(rig)


def test_an_answer_left_unread_by_ctrl_c_is_not_taken_for_that_of_the_next_command(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted() -> float:
        raise KeyboardInterrupt

    with at_seam(name) as rig:
        rig.exchange(rig.sense_voltage_v)
        with monkeypatch.context() as patched:
            patched.setattr(rig.device.at_card._output, "_answer", interrupted)
            with pytest.raises(KeyboardInterrupt):
                rig.device.at_card._output.put_now(DRIVE_V)
        rig.device.at_card._output.put_now(rig.sense_voltage_v)
        assert rig.device.at_card._output._answers_due == 0
        assert rig.device.at_card._output._received == b""
        assert rig.device.server.card.outputs_v["ao0"] == pytest.approx(rig.sense_voltage_v)


def test_a_killed_guardian_is_noticed_and_the_host_switches_off(name: str) -> None:
    with at_seam(name) as rig:
        rig.exchange(DRIVE_V)
        rig.device.at_card._output._process.kill()
        with pytest.raises(ProtectionTripError, match="this one has switched off") as caught:
            exchange_often(rig)
        assert rig.device.server.card.outputs_v["ao0"] == 0.0
    assert caught.value.event is Event.DEVICE_LOST


def test_a_forgotten_rig_is_switched_off() -> None:
    rig = at_seam("ni-usb-6001")
    card = rig.device.server.card
    rig.exchange(DRIVE_V)
    assert card.outputs_v["ao0"] == DRIVE_V
    del rig
    assert card.outputs_v["ao0"] == 0.0


@pytest.mark.emulated
def test_a_server_that_is_cut_off_is_a_lost_device_and_does_not_hang_the_program(name: str) -> None:
    """A stopped server answers as a cut network does: not at all."""
    command = [sys.executable, "-m", "emulation.daq_server", "--card", name, "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            at_server = wiring_of(name).model_copy(update={"grpc": address_of(server)})
            rig = open_rig(at_server, wire_temperature_k=COLD_K)
            rig.exchange(rig.sense_voltage_v)
            server.send_signal(signal.SIGSTOP)
            with pytest.raises(ProtectionTripError, match="nothing confirms it") as caught:
                rig.exchange(rig.sense_voltage_v)
            assert caught.value.event is Event.DEVICE_LOST
        finally:
            server.kill()


def address_of(server: subprocess.Popen[str]) -> str:
    assert server.stdout is not None
    return next(line for line in server.stdout if line.startswith("grpc")).split('"')[1]
