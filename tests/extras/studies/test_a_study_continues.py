"""Finished runs are kept and never repeated: after a stop, after a killed client, whatever the chunks were."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from counted_study import Counted

from musclewire.errors import CallerError, NumericsError
from musclewire.extras.studies import Workers, read_study, sweep
from musclewire.parameters import load_alloy, load_wire, wire_file_text

pytestmark = pytest.mark.slow

HERE, TWO = Workers(processes=1), Workers(processes=2)


class Stop(Exception):  # noqa: N818  it is none of ours
    """What a caller raises to stop."""


def test_the_numbers_are_the_same_whatever_the_processes_and_the_chunks(counted: Counted) -> None:
    whole = sweep(counted.study(), workers=HERE)
    for workers in (TWO, Workers(processes=3, runs_per_chunk=1), Workers(processes=2, runs_per_chunk=7)):
        other = sweep(counted.study(), workers=workers)
        assert {name: column.tobytes() for name, column in other.columns.items()} == {
            name: column.tobytes() for name, column in whole.columns.items()
        }
    assert whole.columns["number"].tolist() == list(range(24))


def test_a_stopped_study_continues_and_repeats_nothing(counted: Counted) -> None:
    def stop(done: int, total: int) -> None:
        if done >= 12:
            raise Stop(total)

    with pytest.raises(Stop):
        sweep(counted.study(), counted.folder, workers=HERE, on_progress=stop)
    assert counted.evaluated() == list(range(12))
    # Cut otherwise: what is finished stays finished.
    result = sweep(counted.study(), counted.folder, workers=Workers(processes=1, runs_per_chunk=5))
    assert counted.evaluated() == list(range(24))
    assert result.evaluated == 12
    assert sweep(counted.study(), counted.folder, workers=HERE).evaluated == 0
    assert np.array_equal(result.columns["draw"], sweep(counted.study(), workers=HERE).columns["draw"])


def test_another_study_is_not_mixed_into_the_folder(counted: Counted) -> None:
    sweep(counted.study(8), counted.folder, workers=HERE)
    with pytest.raises(CallerError, match="belongs to another study"):
        sweep(counted.study(9), counted.folder, workers=HERE)
    result = sweep(counted.study(9), counted.folder, workers=HERE, overwrite=True)
    assert result.evaluated == 9


def test_a_folder_with_other_files_is_left_alone(counted: Counted, tmp_path: Path) -> None:
    (tmp_path / "precious.txt").write_text("mine", "utf-8")
    with pytest.raises(CallerError, match="not empty"):
        sweep(counted.study(), tmp_path, workers=HERE)
    assert [item.name for item in tmp_path.iterdir()] == ["precious.txt"]


def test_a_file_that_the_study_names_belongs_to_it(counted: Counted, tmp_path: Path) -> None:
    wire = tmp_path / "wire.toml"
    known = load_wire("paper-100um")
    wire.write_text(wire_file_text("mine", "", known, load_alloy(known.alloy), {}), "utf-8")
    study = {**counted.study(), "rig": {"wire": str(wire)}}
    before = read_study(study).fingerprint
    wire.write_text(wire.read_text("utf-8") + "\n# changed\n", "utf-8")
    assert read_study(study).fingerprint != before


def test_a_damaged_chunk_is_named(counted: Counted) -> None:
    sweep(counted.study(), counted.folder, workers=HERE)
    chunk = next((counted.folder / "chunks").glob("*.npz"))
    chunk.write_bytes(chunk.read_bytes()[:20])
    with pytest.raises(CallerError, match=chunk.name):
        sweep(counted.study(), counted.folder, workers=HERE)


def test_a_process_that_dies_is_replaced_and_its_runs_are_begun_again(counted: Counted) -> None:
    result = sweep(counted.study(dies_at=9), counted.folder, workers=TWO)
    assert sorted(counted.evaluated()) == list(range(24))
    assert result.columns["number"].tolist() == list(range(24))


def test_a_process_that_always_dies_ends_the_study_with_its_runs_named(counted: Counted) -> None:
    with pytest.raises(NumericsError, match=r"runs \d+ to \d+"):
        sweep(counted.study(dies_at=9, always=True), counted.folder, workers=Workers(processes=2, retries=1))
    assert 9 not in counted.evaluated()


def test_a_run_that_fails_does_not_end_the_others(counted: Counted) -> None:
    result = sweep(counted.study(fails_at=5), workers=TWO)
    assert result.failed == 1
    assert result.errors[5] == "NumericsError: this run fails on purpose"
    assert np.flatnonzero(np.isnan(result.columns["draw"])).tolist() == [5]


def test_a_killed_client_loses_nothing_that_was_finished(counted: Counted, tmp_path: Path) -> None:
    """The command dies by SIGKILL as soon as three chunks are finished; the same command does the rest only."""
    file = counted.written(tmp_path / "counted.toml", takes_s=0.2)
    command = [sys.executable, "-m", "musclewire", "sweep", str(file), "-o", str(counted.folder), "--workers", "2"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([*sys.path, str(Path(__file__).parent)])}
    first = subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL)
    while first.poll() is None and len(list((counted.folder / "chunks").glob("*-*.npz"))) < 3:
        time.sleep(0.02)
    first.send_signal(signal.SIGKILL)
    first.wait()
    chunks = (map(int, path.stem.split("-")) for path in (counted.folder / "chunks").glob("*-*.npz"))
    kept = [number for ends in chunks for number in range(*ends)]
    assert len(kept) >= 12
    done = subprocess.run([*command, "--json"], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    numbers = counted.evaluated()
    assert set(numbers) == set(range(24))
    assert all(numbers.count(number) == 1 for number in kept)
