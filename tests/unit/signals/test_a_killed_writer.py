"""A writer is killed as the kernel kills: no warning, no cleanup. What was flushed must be there."""

import signal
import subprocess
import sys

import numpy as np
import pytest

from musclewire.files import read_hdf5

WRITER = """
import sys
from musclewire.signals import RecordingWriter

names = ["time_s", "wire_voltage_v", "shunt_voltage_v", "force_n"]
writer = RecordingWriter(sys.argv[1], names, {"wire": "Flexinol", "shunt_resistance_ohm": 1.0}, block_rows=7)
print(0, flush=True)
row = 0
while True:
    writer.append(dict(zip(names, (0.01 * (row + 1), row + 0.25, row + 0.5, row + 0.75), strict=True)))
    row += 1
    if writer.rows_written == row:
        print(row, flush=True)
"""


def write_and_kill(path, enough_rows):
    """Return the rows the writer had acknowledged when it was killed, in the middle of writing more."""
    with subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True) as writer:
        acknowledged = -1
        while acknowledged < enough_rows:
            acknowledged = int(writer.stdout.readline())
        writer.send_signal(signal.SIGKILL)
        # What it had still said before it died, up to a line that was cut.
        rest = [int(line) for line in writer.stdout.read().splitlines(keepends=True) if line.endswith("\n")]
    assert writer.returncode == -signal.SIGKILL
    return max([acknowledged, *rest])


@pytest.mark.slow
@pytest.mark.parametrize("enough_rows", [0, 7, 150, 333, 1500, 2800])
def test_after_a_kill_every_flushed_row_reads_back(tmp_path, enough_rows):
    acknowledged = write_and_kill(tmp_path / "run.h5", enough_rows)
    recording = read_hdf5(tmp_path / "run.h5")
    rows = np.arange(len(recording))
    assert len(recording) >= acknowledged
    assert recording["time_s"] == pytest.approx(0.01 * (rows + 1))
    assert np.array_equal(recording["wire_voltage_v"], rows + 0.25)
    assert np.array_equal(recording["shunt_voltage_v"], rows + 0.5)
    assert np.array_equal(recording["force_n"], rows + 0.75)
    assert recording.metadata["ended"] == "cut off"
    assert recording.metadata["shunt_resistance_ohm"] == 1.0
