"""Groups of tests: what a run without names leaves out is said, what is named runs, and a record tells what ran."""

from __future__ import annotations

import pytest
from tests.groups import COMMAND
from tests.places import CHECKOUT

pytest_plugins = ["pytester"]
PROJECT = """
[tool.pytest.ini_options]
testpaths = ["tests"]
addopts = "--strict-markers"
groups = ["slow: takes long", "emulated: runs firmware"]
"""
TESTS = """
import pytest

def test_quick():
    pass

@pytest.mark.slow
@pytest.mark.parametrize("number", [1, 2])
def test_long(number):
    pass

@pytest.mark.emulated
def test_firmware():
    pytest.skip("no compiler")
"""


@pytest.fixture
def project(pytester: pytest.Pytester) -> pytest.Pytester:
    pytester.makefile(".toml", pyproject=PROJECT)
    (pytester.path / "tests").mkdir()
    conftest = f"import sys\nsys.path.insert(0, {str(CHECKOUT / 'tests')!r})\nfrom groups import *\n"
    (pytester.path / "tests/conftest.py").write_text(conftest, encoding="utf-8")
    (pytester.path / "tests/test_some.py").write_text(TESTS, encoding="utf-8")
    return pytester


@pytest.mark.parametrize("processes", [(), ("-n", "1")], ids=["one process", "xdist"])
def test_a_run_without_names_says_what_it_leaves_out_and_how_to_run_it(
    project: pytest.Pytester, processes: tuple[str, ...]
) -> None:
    """And which file needs a package that is missing."""
    needy = "import pytest\npytest.skip('not run: gmsh is missing', allow_module_level=True)\n"
    (project.path / "tests/test_solids.py").write_text(needy, encoding="utf-8")
    result = project.runpytest_subprocess(*processes) if processes else project.runpytest_inprocess()
    result.stdout.fnmatch_lines(
        [
            "*not run: files of tests*",
            "tests/test_solids.py: not run: gmsh is missing",
            "*not run: groups of tests that nobody named*",
            "    2 slow: takes long",
            f"        run them: {COMMAND} -m slow",
            "    1 emulated: runs firmware",
            f"        run them: {COMMAND} -m emulated",
            f"every test: {COMMAND} --all",
            "*1 passed*",
        ]
    )


@pytest.mark.parametrize(
    ("arguments", "outcomes"),
    [
        (("-m", "slow"), {"passed": 2, "deselected": 2}),
        (("-m", "not slow"), {"passed": 1, "skipped": 1, "deselected": 2}),
        (("--all",), {"passed": 3, "skipped": 1}),
        (("tests/test_some.py",), {"passed": 3, "skipped": 1}),
        (("tests/test_some.py::test_long",), {"passed": 2}),
        (("-k", "quick or long"), {"passed": 1, "deselected": 3}),
    ],
    ids=lambda value: " ".join(value),
)
def test_what_is_named_runs(project: pytest.Pytester, arguments: tuple[str, ...], outcomes: dict[str, int]) -> None:
    project.runpytest_inprocess(*arguments).assert_outcomes(**outcomes)


@pytest.mark.parametrize("processes", [(), ("-n", "1")], ids=["one process", "xdist"])
def test_a_record_says_what_ran_and_how_it_ended(project: pytest.Pytester, processes: tuple[str, ...]) -> None:
    marked = "\n@pytest.mark.xfail(strict=True, reason='a bar that is missed')\ndef test_bar():\n    assert False\n"
    (project.path / "tests/test_some.py").write_text(TESTS + marked, encoding="utf-8")
    run = project.runpytest_subprocess if processes else project.runpytest_inprocess
    run("--all", "--record", "ran.txt", *processes)
    assert (project.path / "ran.txt").read_text("utf-8").splitlines() == [
        "failed as marked\ttests/test_some.py::test_bar",
        "skipped\ttests/test_some.py::test_firmware",
        "passed\ttests/test_some.py::test_long[1]",
        "passed\ttests/test_some.py::test_long[2]",
        "passed\ttests/test_some.py::test_quick",
    ]


def test_a_test_of_two_groups_is_refused(project: pytest.Pytester) -> None:
    twice = TESTS.replace("@pytest.mark.emulated", "@pytest.mark.emulated\n@pytest.mark.slow")
    (project.path / "tests/test_some.py").write_text(twice, encoding="utf-8")
    project.runpytest_inprocess().stderr.fnmatch_lines(["*test_firmware is in 2 groups (slow, emulated)*"])


def test_an_expected_miss_is_no_excuse_for_another_error(project: pytest.Pytester) -> None:
    marked = (
        "\n@pytest.mark.xfail(strict=True, reason='a bar that is missed')\ndef test_bar():\n    raise KeyError(1)\n"
    )
    (project.path / "tests/test_some.py").write_text(TESTS + marked, encoding="utf-8")
    project.runpytest_inprocess("-k", "bar").assert_outcomes(failed=1, deselected=4)
