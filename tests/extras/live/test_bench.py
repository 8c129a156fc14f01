"""The process of a bench, really started: what it does when asked, and what when nobody asks any more."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from pathlib import Path

import pytest
from tests.extras.live.bench import MAX_WAIT_S, ask, bench, in_control, until_phase

from musclewire.files import read_recording

pytestmark = pytest.mark.slow


async def frozen(pid: int) -> None:
    """Stop a process, and wait until it is: a thread of it that runs meanwhile can still confirm an order."""
    os.kill(pid, signal.SIGSTOP)
    async with asyncio.timeout(MAX_WAIT_S):
        while Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "T":
            await asyncio.sleep(0.001)


def drive_v(handle: object, rows: list) -> float:  # type: ignore[type-arg]
    """Return the last drive voltage in rows."""
    last = rows[-1]
    return float(last.values[-1][handle.layouts[last.layout].index("drive_voltage_v")])  # type: ignore[attr-defined]


def test_a_wire_is_warmed_only_while_somebody_is_there(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path, max_silence_s=5.0) as handle:
            await until_phase(handle, "off")
            refused = await ask(handle, do="characterize")
            assert not refused.accepted
            assert "switch on first" in refused.message
            assert (await ask(handle, do="switch_on")).accepted
            async with in_control(handle):
                assert (await ask(handle, do="characterize", period_s=20.0)).accepted
                busy = await ask(handle, do="doctor")
                assert (busy.accepted, busy.message) == (False, "'characterize' is running: end it first")
                await asyncio.sleep(1.0)
                assert handle.state["phase"] == "busy"
            await until_phase(handle, "ready")
            assert "nobody in control" in handle.state["messages"][-1]["text"]
            (recorded,) = tmp_path.glob("characterize-*.h5")
            cut = read_recording(recorded)
            assert "nobody in control" in cut.metadata["ended"]
            assert len(cut) >= 20
            await asyncio.sleep(0.2)
            assert (
                drive_v(handle, handle.rows(0)[1]) == 0.30012
            )  # of the sense voltage of 0.3 V, what the amplifier applies

    asyncio.run(run())


def test_a_stop_switches_off_in_the_middle_of_a_run_and_stays(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as handle, in_control(handle):
            await ask(handle, do="switch_on")
            assert (await ask(handle, do="pulse", duration_s=10.0)).accepted
            handle.stop("a test")
            await until_phase(handle, "stopped")
            assert handle.state["why"].startswith("stopped by a test: the drive is off")
            rows = handle.rows(0)[0]
            await asyncio.sleep(0.3)
            assert handle.rows(0)[0] <= rows + 1
            assert not (await ask(handle, do="characterize")).accepted
            assert handle.state["phase"] == "stopped"
            assert (await ask(handle, do="switch_on")).accepted
            await until_phase(handle, "ready")

    asyncio.run(run())


def test_a_stop_right_behind_an_order_to_switch_on_counts_and_a_later_order_switches_on(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as handle, in_control(handle):
            await until_phase(handle, "off")
            for _ in range(3):
                switching_on = asyncio.create_task(ask(handle, do="switch_on"))
                await asyncio.sleep(0.0)  # it is sent
                handle.stop("a test")
                await switching_on
                assert not (await ask(handle, do="pulse")).accepted
                assert handle.state["phase"] == "stopped"
            assert (await ask(handle, do="switch_on")).accepted
            assert (await ask(handle, do="pulse")).accepted
            handle.stop("a test")
            handle.stop("a test")
            await until_phase(handle, "stopped")

    asyncio.run(run())


def test_a_bench_whose_process_is_killed_says_so(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as handle:
            await until_phase(handle, "off")
            assert handle._process is not None
            os.kill(handle._process.pid, signal.SIGKILL)
            await until_phase(handle, "failed")
            assert "has ended (-9)" in handle.state["why"]
            assert not (await ask(handle, do="switch_on")).accepted

    asyncio.run(run())


@pytest.mark.parametrize("how", ["stop", "close"])
def test_a_frozen_bench_is_given_up_within_two_seconds_and_says_so(tmp_path: Path, how: str) -> None:
    """SIGSTOP: the process takes no order and no SIGTERM any more. What waits for it is told."""

    async def run() -> None:
        async with bench(tmp_path) as handle, in_control(handle):
            assert (await ask(handle, do="switch_on")).accepted
            process = handle._process
            assert process is not None
            await frozen(process.pid)
            waiting = asyncio.create_task(ask(handle, do="pulse"))
            await asyncio.sleep(0.0)  # it is sent
            began_s = time.monotonic()
            await asyncio.wait_for(handle.stop("a test") if how == "stop" else handle.close(), MAX_WAIT_S)
            assert time.monotonic() - began_s < 2.0
            assert process.returncode == -signal.SIGKILL
            assert not (await waiting).accepted
            if how == "stop":
                assert handle.state["phase"] == "failed"
                assert handle.state["why"].startswith(
                    "the rig's process did not confirm a stop within 1 s and was ended"
                )
                await handle.stop("a test")  # there is nothing left to stop: answered at once

    asyncio.run(run())


def test_a_stop_of_a_bench_that_has_only_just_been_started_is_carried_out_and_ends_nothing(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as handle:
            await handle.stop("a test")
            assert handle.state["phase"] == "stopped"
            assert (await ask(handle, do="switch_on")).accepted

    asyncio.run(run())


def test_what_a_killed_bench_had_recorded_is_there_at_the_next_start(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as handle, in_control(handle):
            await ask(handle, do="switch_on")
            assert (await ask(handle, do="characterize")).accepted
            await asyncio.sleep(1.5)
            assert handle._process is not None
            os.kill(handle._process.pid, signal.SIGKILL)
            await until_phase(handle, "failed")
        assert list(tmp_path.glob("*.h5")) == []
        async with bench(tmp_path) as handle:
            await until_phase(handle, "off")
            (listed,) = handle.state["recordings"]
            assert listed["name"].startswith("characterize-")
            assert len(read_recording(tmp_path / listed["name"])) >= 20

    asyncio.run(run())


def test_a_rig_that_cannot_be_opened_is_a_state_and_no_crash(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path, "there-is-no-such-rig") as handle:
            await until_phase(handle, "off")
            refused = await ask(handle, do="switch_on")
            assert not refused.accepted
            assert handle.state["phase"] == "failed"
            assert handle.state["why"] == refused.message

    asyncio.run(run())


PATH = {"kind": "path", "time_s": [0.0, 5.0], "target": [0.015, 0.02]}


def test_a_whole_session_on_a_simulated_rig_that_runs_faster_than_the_clock(tmp_path: Path) -> None:
    async def run() -> None:
        async with bench(tmp_path) as handle, in_control(handle):
            await ask(handle, do="switch_on")
            assert (await ask(handle, do="clock_speed", factor=100.0)).accepted
            assert handle.state["clock_speed"] == 100.0
            for command in (
                {"do": "doctor"},
                {"do": "pulse"},
                {"do": "characterize"},
                {"do": "fit"},
                {"do": "home"},
                {"do": "control", "reference": {"kind": "staircase"}},
                {"do": "control", "reference": {"kind": "sine", "middle": 0.02, "amplitude": 0.002, "period_s": 20.0}},
                {"do": "control", "controller": "fuzzy-pid", "reference": PATH},
            ):
                answer = await ask(handle, **command)
                assert answer.accepted, (command, answer.message)
                await until_phase(handle, "ready", "failed")
                assert handle.state["phase"] == "ready", (command, handle.state["why"])
            assert all(handle.state["steps"].values())
            # The last path is short: after an approach of 12 s only 5 s count.
            assert handle.state["metrics"]["rms_pct"] < 10.0
            # Choosing another pretension forgets the model of this one.
            assert (await ask(handle, do="choose_pretension", pretension_n=1.7)).accepted
            await until_phase(handle, "ready")
            assert handle.state["model"] is None
            assert handle.state["rig"]["pretension_n"] == 1.7
            assert len(handle.state["recordings"]) == 6
            runs = [read_recording(path) for path in sorted(tmp_path.glob("control-*.h5"))]
            assert [one.metadata["ended"] for one in runs] == ["done"] * 3
            assert runs[0].metadata["clock_speed"] == 100.0

    asyncio.run(run())
