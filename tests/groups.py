"""Which tests a run without names leaves out: the groups of pyproject.toml, each a marker of the same name.

A test that takes long, or needs a compiler, an emulator or a browser, carries the marker of one group. A run without
names leaves the groups out and says at its end how many tests of which group it did not run, and the command that runs
them; files that need a missing package are named, too. What is named is run: a file, a folder or a test on the command
line, ``-m GROUP``, or ``--all``.

``--record FILE`` writes which tests ran and how they ended; CI compares the files of all its runs with what there is.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest

__all__ = ["Groups", "pytest_addoption", "pytest_configure"]

# The processes of a run; the rest of the command is the group.
COMMAND = "python -m pytest -n auto --dist worksteal"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add ``--all``, ``--record`` and the list of groups in pyproject.toml."""
    parser.addini("groups", "what a run without names leaves out: 'name: a sentence', one a line", type="linelist")
    options = parser.getgroup("groups of tests")
    options.addoption("--all", action="store_true", dest="run_all", help="run the tests of every group, too")
    options.addoption("--record", type=Path, default=None, metavar="FILE", help="write which tests ran, and their ends")


def pytest_configure(config: pytest.Config) -> None:
    """Register the groups as markers and what leaves them out."""
    for line in config.getini("groups"):
        config.addinivalue_line("markers", line)
    config.pluginmanager.register(Groups(config), "groups of tests")


class Groups:
    """Leaves groups out of a run, says so at its end, and records what ran."""

    def __init__(self, config: pytest.Config) -> None:
        """Decide which groups this run leaves out."""
        self._config = config
        self._sentences = dict(line.split(": ", 1) for line in config.getini("groups"))
        self._not_run: Counter[str] = Counter()
        self._ends: dict[str, str] = {}
        # A worker of xdist's has arguments of its own: it is told what was decided where the run was started.
        given = getattr(config, "workerinput", None)
        self._is_worker = given is not None
        self._left_out: list[str] = self._unnamed() if given is None else given["groups_left_out"]

    def _unnamed(self) -> list[str]:
        option = self._config.option
        named = self._config.args_source is pytest.Config.ArgsSource.ARGS
        asked = named or option.run_all or option.markexpr or getattr(option, "lf", False)
        return [] if asked else list(self._sentences)

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: Any) -> None:
        """Tell a worker which groups to leave out."""
        node.workerinput["groups_left_out"] = self._left_out

    def group_of(self, item: pytest.Item) -> str | None:
        """Return the group of a test, if it has one. UsageError for a test of two: in CI it would run twice."""
        found = [name for name in self._sentences if item.get_closest_marker(name)]
        if len(found) > 1:
            raise pytest.UsageError(f"{item.nodeid} is in {len(found)} groups ({', '.join(found)}): choose one")
        return found[0] if found else None

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out the groups that nobody named, after -k and -m have chosen, and count what is left out.

        A test that is expected to miss its bar is expected to fail by an assertion: any other error is a fault.
        """
        for mark in (mark for item in items for mark in item.iter_markers("xfail")):
            mark.kwargs.setdefault("raises", AssertionError)  # type: ignore[attr-defined]
        in_group = [(item, self.group_of(item)) for item in items]
        not_run = [item for item, group in in_group if group in self._left_out]
        if not_run:
            items[:] = [item for item, group in in_group if group not in self._left_out]
            self._not_run.update(group for _, group in in_group if group in self._left_out and group)
            self._config.hook.pytest_deselected(items=not_run)

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Note what was collected, by its group, if nothing will run."""
        if self._config.option.collectonly:
            self._ends = {item.nodeid: self.group_of(item) or "collected" for item in session.items}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note how a test ended; with xdist, what its workers ran is reported here, too."""
        if self._ends.get(report.nodeid, "passed") == "passed" and (report.when == "call" or not report.passed):
            # pytest calls a test that fails as its mark says "skipped"; but it has run, and strictly.
            failed_as_marked = report.when == "call" and report.skipped and hasattr(report, "wasxfail")
            self._ends[report.nodeid] = "failed as marked" if failed_as_marked else report.outcome

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Take what a worker has left out; every worker collects all tests."""
        self._not_run = Counter(getattr(node, "workeroutput", {}).get("groups_not_run", self._not_run))

    def pytest_sessionfinish(self) -> None:
        """Hand what was left out to the process that has started this one; write the record."""
        if self._is_worker:
            self._config.workeroutput["groups_not_run"] = dict(self._not_run)  # type: ignore[attr-defined]
        elif self._config.option.record is not None:
            lines = (f"{end}\t{name}\n" for name, end in sorted(self._ends.items()))
            self._config.option.record.write_text("".join(lines), encoding="utf-8")

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Say which files could not even be read, which groups were not run, and which command runs them."""
        skipped = terminalreporter.stats.get("skipped", [])
        unread = {report.nodeid: report.longrepr[2] for report in skipped if isinstance(report, pytest.CollectReport)}
        if unread:
            terminalreporter.section("not run: files of tests that need what is missing", sep="=", yellow=True)
        for name, why in sorted(unread.items()):
            terminalreporter.write_line(f"{name}: {why.removeprefix('Skipped: ')}")
        if not self._not_run:
            return
        terminalreporter.section("not run: groups of tests that nobody named", sep="=", yellow=True)
        for name, sentence in self._sentences.items():
            if self._not_run[name]:
                terminalreporter.write_line(f"{self._not_run[name]:5d} {name}: {sentence}")
                terminalreporter.write_line(f"        run them: {COMMAND} -m {name}")
        terminalreporter.write_line(f"every test: {COMMAND} --all")
