"""A process that judges mutants: it has imported what no mutant changes, and forks one process for each of them.

    python -m checks.mutants.judging compiled|plain FOLDER

It reads one mutant a line from its input, as JSON, and answers each by a line: which test kills it, and the time.
The mutant's text is what the import system gives for its module; the file is not touched, so that Numba still finds the
machine code of all functions that are not changed.
"""

from __future__ import annotations

import gc
import importlib
import json
import os
import resource
import select
import shutil
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from checks.mutants.importing import install, module_name
from checks.mutants.test_runs import FewExamples, options

# What the tests import and no mutant changes: other packages, and the rooms below those that are mutated.
BEFOREHAND = (
    "numpy", "scipy.integrate", "scipy.optimize", "scipy.interpolate", "scipy.special", "scipy.signal", "scipy.stats",
    "numba", "h5py", "pydantic", "pint", "matplotlib.figure", "hypothesis.strategies", "hypothesis.extra.numpy",
    "musclewire", "musclewire.errors", "musclewire.compiled", "musclewire.registry", "musclewire.signals",
    "musclewire.signals._exchange", "musclewire.signals._hdf5", "musclewire.signals._units", "musclewire.parameters",
    "musclewire.physics._heat", "musclewire.physics._material", "musclewire.physics._resistance",
)  # fmt: skip
MAX_MEMORY_BYTES = 6 << 30


class Verdict:
    """Notes the first test that fails; orders the tests as they were given."""

    def __init__(self, order: Sequence[str]) -> None:
        """Take the tests in their order."""
        self._places = {name: place for place, name in enumerate(order)}
        self.by = ""

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Quick tests first."""
        items.sort(key=lambda item: self._places.get(item.nodeid, len(self._places)))

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """A file of tests that cannot be imported any more."""
        if report.failed:
            self.by = self.by or f"{report.nodeid or 'the tests'}: import"

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """A test that fails."""
        if report.failed:
            self.by = self.by or report.nodeid


def judge(job: dict[str, Any], mode: str, temporary: str) -> str:
    """Return in a forked process by which test a mutant is killed; "" if it survives."""
    name = module_name(job["path"])
    assert name not in sys.modules, f"{name} was imported before it could be changed"
    install(job["path"], job["text"], Path(f"{temporary}.json"))
    for tests in job["tests"]:
        verdict = Verdict(tests)
        code = pytest.main([*options(mode, temporary), *tests], plugins=[verdict, FewExamples(mode)])
        if code is not pytest.ExitCode.OK or verdict.by:
            return verdict.by or f"pytest ends with {code!r}"
    return ""


def forked(job: dict[str, Any], mode: str, temporary: str) -> dict[str, Any]:
    """Judge a mutant in a process of its own, with limits of processor time and of time."""
    began_s, spent_s = time.monotonic(), children_s()
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.setpgrp()  # not a session of its own, which the scheduler would give as much time as all others together
        os.close(reading)
        nowhere = os.open(os.devnull, os.O_RDWR)
        for descriptor in (0, 1, 2):
            os.dup2(nowhere, descriptor)
        resource.setrlimit(resource.RLIMIT_CPU, (int(job["limit_s"]), int(job["limit_s"]) + 5))
        resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY_BYTES, MAX_MEMORY_BYTES))
        try:
            by = judge(job, mode, temporary)
        except BaseException as error:
            by = f"{type(error).__name__} outside of any test"
        os.write(writing, json.dumps({"by": by}).encode())
        os._exit(0)
    os.close(writing)
    # A loaded machine gives a process a part of its time only.
    ready, _, _ = select.select([reading], [], [], 6.0 * job["limit_s"])
    said = os.read(reading, 1 << 16) if ready else b""
    os.close(reading)
    end_group(child)
    found = {"timed_out": True, "by": ""} if not said else {"timed_out": False, **json.loads(said)}
    shutil.rmtree(temporary, ignore_errors=True)
    return {**found, "cpu_s": round(children_s() - spent_s, 2), "clock_s": round(time.monotonic() - began_s, 2)}


def end_group(child: int) -> None:
    """End a forked process and what it has started."""
    try:
        os.killpg(child, signal.SIGKILL)
    except ProcessLookupError:
        os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)


def children_s() -> float:
    """Return the processor time of all forked processes that have ended [s]."""
    spent = os.times()
    return spent.children_user + spent.children_system


def main(mode: str, folder: str) -> int:
    """Judge until the input ends."""
    for name in BEFOREHAND:
        importlib.import_module(name)
    gc.collect()
    gc.freeze()
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        print(json.dumps(forked(json.loads(line), mode, f"{folder}/tests-{os.getpid()}")), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
