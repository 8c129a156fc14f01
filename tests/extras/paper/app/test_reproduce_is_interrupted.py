"""Ctrl-C and SIGTERM while the paper's numbers are computed: the documented exit code, and nothing left behind."""

from __future__ import annotations

import signal
import subprocess
import time
from pathlib import Path

import pytest
from tests.app.interrupting import ONE_IN_CI, PATIENCE_S, start


@pytest.mark.parametrize(("number", "code"), ONE_IN_CI)
def test_verdicts_over_seeds_stopped_by_a_signal_leave_no_process_and_no_page(
    number: signal.Signals, code: int, tmp_path: Path
) -> None:
    arguments = ("--only", "table1.resistance", "--seeds", 20000, "--workers", 3, "--output", tmp_path)
    process = start("reproduce", *arguments)
    assert process.stderr is not None
    assert "of 20000 seeds" in process.stderr.readline()
    deadline = time.monotonic() + PATIENCE_S
    while len(workers := workers_of(process.pid)) < 3:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline, f"{len(workers)} processes compute"
        time.sleep(0.05)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == code, err
    assert (out, "no page was written" in err, "Traceback" in err) == ("", True, False)
    assert [pid for pid in workers if Path(f"/proc/{pid}").exists()] == []
    assert list(tmp_path.iterdir()) == []


def workers_of(pid: int) -> list[str]:
    """Return the processes that compute for a process; loky's own helpers end with what they wait for.

    The width is asked for: with COLUMNS set, ps would cut what it is told by.
    """
    children = ["ps", "-ww", "-o", "pid=,args=", "--ppid", str(pid)]
    found = subprocess.run(children, capture_output=True, text=True, check=False).stdout.splitlines()
    return [line.split()[0] for line in found if "--process-name" in line]
