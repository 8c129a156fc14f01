"""Which test runs which line of the rooms, and how long it takes: one run of pytest under coverage.py.

    python -m checks.mutants.collecting compiled|plain LIMIT_S OUTPUT TEST_FILE ...

The tests that fail, are skipped or take longer than the limit are left out, with the reason.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import coverage
import pytest
from checks.mutants.test_runs import FewExamples, cpu_s, options, time_limit

# Lines that a test file's import executes are those of every test in it.
IMPORT = "import "


class Collector:
    """Tells coverage which test runs, and notes each test's time and end."""

    def __init__(self, measured: coverage.Coverage, limit_s: float) -> None:
        """Take the running measurement and the processor time that a test may take [s]."""
        self._coverage, self._limit_s = measured, limit_s
        self.cpu_s: dict[str, float] = {}
        self.left_out: dict[str, str] = {}
        self._long: set[str] = set()

    @pytest.hookimpl(wrapper=True)
    def pytest_make_collect_report(self, collector: pytest.Collector) -> Iterator[Any]:
        """Lines that run while a file of tests is imported."""
        self._coverage.switch_context(IMPORT + collector.nodeid.split("::")[0])
        report = yield
        if report.failed:
            self.left_out[collector.nodeid] = "cannot be imported"
        return report

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[Any]:
        """Lines that run in a test, with its fixtures."""
        self._coverage.switch_context(item.nodeid)
        began_s = cpu_s()
        result = yield
        self.cpu_s[item.nodeid] = cpu_s() - began_s
        return result

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """If one case of a test has taken too long, its other cases do not run."""
        if item.nodeid.split("[")[0] in self._long:
            pytest.skip("another case of it takes too long")

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self) -> Iterator[Any]:
        """End a test that takes too long."""
        with time_limit(self._limit_s):
            return (yield)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note which tests cannot judge."""
        if report.outcome != "passed":
            said = str(report.longrepr).splitlines()
            if any("TooLongError" in line for line in said[-3:]):
                self._long.add(report.nodeid.split("[")[0])
                self.left_out[report.nodeid] = f"takes too long: more than {self._limit_s:g} s"
            else:
                self.left_out[report.nodeid] = f"{report.outcome}: {said[-1][:200] if said else ''}"


def lines_of(measured: coverage.CoverageData) -> dict[str, dict[int, list[str]]]:
    """Return for each file and line the tests that ran it."""
    found: dict[str, dict[int, list[str]]] = {}
    for file in measured.measured_files():
        by_line = measured.contexts_by_lineno(file)
        found[str(Path(file).relative_to(Path.cwd()))] = {
            line: sorted(context for context in contexts if context) for line, contexts in by_line.items()
        }
    return found


def main(mode: str, limit_s: str, output: str, *tests: str) -> int:
    """Run the tests and write what was found."""
    rooms = [f"{Path.cwd()}/src/musclewire/*"]
    measured = coverage.Coverage(data_file=None, config_file=False, include=rooms, messages=False)
    collector = Collector(measured, float(limit_s))
    measured.start()
    with tempfile.TemporaryDirectory() as folder:
        arguments = [one for one in options(mode, f"{folder}/tests") if one != "-x"]
        code = pytest.main(
            [*arguments, "-m", "not emulated and not browser and not documented", *tests],
            plugins=[collector, FewExamples(mode)],
        )
    measured.stop()
    found = {"cpu_s": collector.cpu_s, "left_out": collector.left_out, "lines": lines_of(measured.get_data())}
    Path(output).write_text(json.dumps(found), encoding="utf-8")
    return 0 if code in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED, pytest.ExitCode.NO_TESTS_COLLECTED) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
