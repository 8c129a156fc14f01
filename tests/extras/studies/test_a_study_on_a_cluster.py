"""A study on a real Dask scheduler with real workers, as processes of this machine: the same digits, whoever dies."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest
from counted_study import Counted
from dask_cluster import DaskCluster

from musclewire.errors import CallerError, NumericsError
from musclewire.extras.studies import StudyResult, Workers, sweep


def same(one: StudyResult, other: StudyResult) -> bool:
    """Return whether two results are equal to the bit."""
    return one.errors == other.errors and all(
        one.columns[name].tobytes() == other.columns[name].tobytes() for name in one.columns
    )


@pytest.mark.slow
def test_workers_are_killed_and_nothing_that_was_finished_is_lost_or_repeated(counted: Counted, tmp_path: Path) -> None:
    """A worker is killed after every fourth chunk, whatever it does; in the end the numbers are those of one core."""
    study = counted.study(96, takes_s=0.1)
    with DaskCluster(tmp_path) as cluster:
        finished: list[int] = []

        def kill(done: int, total: int) -> None:
            if cluster.killed < 5 and done >= 16 * (cluster.killed + 1):
                # Until here every run is on the disk, and must not be evaluated any more.
                finished[:] = [int(path.stem.partition("-")[0]) for path in (counted.folder / "chunks").glob("*.npz")]
                before.append((list(finished), counted.evaluated()))
                cluster.kill_a_worker()
            assert done <= total

        before: list[tuple[list[int], list[int]]] = []
        workers = Workers(scheduler=cluster.address, retries=10)
        result = sweep(study, counted.folder, workers=workers, on_progress=kill)
        assert cluster.killed == 5
    numbers = counted.evaluated()
    for kept, evaluated in before:
        for number in kept:
            assert numbers.count(number) == evaluated.count(number)
    assert result.columns["number"].tolist() == list(range(96))
    assert same(result, sweep(study, workers=Workers(processes=1)))


@pytest.mark.slow
def test_loops_on_a_cluster_have_the_digits_of_this_machines_cores(tmp_path: Path) -> None:
    study = {
        "format": "musclewire-study",
        "version": 1,
        "name": "loops",
        "run": {"kind": "characterize", "cycles": 1, "period": "30 s", "keep": ["strain_gap", "strain"]},
        "sampling": {"method": "latin-hypercube", "samples": 12},
        "parameters": {"pretension": {"low": "1.5 N", "high": "2.2 N"}, "run.readings": {"values": ["ideal", "rig"]}},
    }
    here = sweep(study, workers=Workers(processes=1))
    assert here.failed == 0
    with DaskCluster(tmp_path) as cluster:
        there = sweep(study, workers=Workers(scheduler=cluster.address, runs_per_chunk=5))
    assert same(here, there)


@pytest.mark.full
def test_a_run_that_kills_every_worker_ends_the_study(counted: Counted, tmp_path: Path) -> None:
    with DaskCluster(tmp_path, workers=1) as cluster:

        def look() -> None:
            cluster.replace_dead_workers()

        workers = Workers(scheduler=cluster.address, retries=0, runs_per_chunk=4)
        with pytest.raises(NumericsError, match=r"runs \d+ to \d+ have failed 1 times on the cluster \(KilledWorker"):
            sweep(counted.study(12, dies_at=9, always=True), counted.folder, workers=workers, look=look)
    assert 9 not in counted.evaluated()


@pytest.mark.slow
def test_a_cluster_that_is_not_there_is_one_line(counted: Counted, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("musclewire.extras.studies._cluster.CONNECT_S", 0.5)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        with pytest.raises(CallerError, match=f"no Dask scheduler at {address}"):
            sweep(counted.study(), workers=Workers(scheduler=address))
