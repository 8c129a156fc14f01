"""Mutation testing's own parts: its operators, its sample, which tests it chooses. No mutant is judged here."""

from __future__ import annotations

import ast
from collections import Counter
from pathlib import Path

import pytest
from checks.mutants.choosing import Measured, Sources
from checks.mutants.operators import OPERATORS, Mutant, mutants_of
from checks.mutation import (
    EQUIVALENTS,
    PACKAGE,
    ROOT,
    equivalent_entries,
    mutants_of_rooms,
    sample_of,
    share,
    suspect_of,
)

CASES = [
    ("x = a + b", "arithmetic", "(a - b)"),
    ("total += a", "arithmetic", "total -= a"),
    ("x = -a", "sign", "a"),
    ("if a < b: pass", "comparison", "(a >= b)"),
    ("if a < b: pass", "boundary", "(a <= b)"),
    ("x = a and b", "boolean", "(a or b)"),
    ("x = True", "boolean", "False"),
    ("if a: pass", "condition", "(not a)"),
    ("x = 3", "constant", "4"),
    ("x = 0.5", "constant", "1.0"),
    ("x = 0.0", "constant", "1.0"),
    ("x = min(a, b)", "function", "(max(a, b))"),
    ("x = f(a, b)", "arguments", "(f(b, a))"),
    ("return a * b", "return", "(-(a * b))"),
    ("return a, b", "return", "((b, a))"),
    ("f(a)", "statement", "pass"),
    ("raise ValueError('no')", "statement", "pass"),
    ("self.x = a", "statement", "pass"),
]


def in_a_function(line: str) -> str:
    return f'def f(a, b):\n    """Return 2."""\n    {line}\n'


@pytest.mark.parametrize(("line", "operator", "after"), CASES)
def test_each_operator_changes_what_it_is_for(line: str, operator: str, after: str) -> None:
    source = in_a_function(line)
    found = [one for one in mutants_of("f.py", source) if one.operator == operator and one.after == after]
    assert len(found) == 1
    assert found[0].line == 3
    assert found[0].text == line


def test_every_operator_has_a_case() -> None:
    assert {operator for _, operator, _ in CASES} == set(OPERATORS)


@pytest.mark.parametrize("line", ["raise ValueError(f'{a + 1} is {b * 2}')", "x: dict[str, 3] = a"])
def test_neither_text_nor_annotations_are_changed(line: str) -> None:
    assert {one.operator for one in mutants_of("f.py", in_a_function(line))} <= {"statement"}


def every_mutant() -> list[Mutant]:
    return mutants_of_rooms(ROOT)


@pytest.mark.slow
def test_every_mutant_of_the_rooms_is_a_program_of_as_many_lines_and_another_one() -> None:
    every = every_mutant()
    assert {one.operator for one in every} == set(OPERATORS)
    texts = {path: (ROOT / path).read_text("utf-8") for path in {one.path for one in every}}
    for one in every[::29]:
        changed = one.applied(texts[one.path])
        assert changed.count("\n") == texts[one.path].count("\n")
        assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(texts[one.path]))
    assert len({one.key for one in every}) == len(every)


@pytest.mark.slow
def test_a_sample_is_the_same_for_one_seed_and_has_its_part_of_each_room_and_operator() -> None:
    every = every_mutant()
    sample = sample_of(every, 300, 1)
    assert [one.key for one in sample] == [one.key for one in sample_of(every, 300, 1)]
    assert {one.key for one in sample} != {one.key for one in sample_of(every, 300, 2)}
    assert len({one.key for one in sample}) == 300
    for kind in (lambda one: one.path.split("/")[2], lambda one: (one.path.split("/")[2], one.operator)):
        whole, part = Counter(map(kind, every)), Counter(map(kind, sample))
        for name, count in whole.items():
            assert part[name] == pytest.approx(300 * count / len(every), abs=2.0)
    assert len({one.path for one in sample}) > 60


def test_every_mutant_listed_as_equivalent_has_a_reason() -> None:
    entries = equivalent_entries(EQUIVALENTS)
    assert all(len(one["reason"]) > 20 for one in entries)
    assert len({(one["path"], one["text"], one["operator"], one["change"]) for one in entries}) == len(entries)


def test_the_share_leaves_equivalents_out_and_counts_what_does_not_end_as_killed() -> None:
    assert share(Counter({"killed": 6, "timed out": 2, "survived": 1, "not covered": 1, "equivalent": 5})) == 0.8


COMPILED_ROOM = '''"""A room."""
from musclewire.wire.other import LIMIT

STEP = 3


@compiled
def kernel(x):
    return x + STEP


def plain(x):
    return kernel(x) * 2
'''


@pytest.fixture
def room(tmp_path: Path) -> tuple[Path, Sources]:
    folder = tmp_path / PACKAGE / "wire"
    folder.mkdir(parents=True)
    (folder / "room.py").write_text(COMPILED_ROOM, "utf-8")
    (folder / "other.py").write_text("LIMIT = 1\n\n\ndef free(x):\n    return x - LIMIT\n", "utf-8")
    return tmp_path, Sources(tmp_path, PACKAGE)


def mutant(folder: Path, name: str, text: str) -> Mutant:
    path = PACKAGE / "wire" / name
    found = [one for one in mutants_of(str(path), (folder / path).read_text("utf-8")) if one.text == text]
    return found[0]


def test_compiled_code_and_what_it_has_copied_are_judged_with_compilation_off(room: tuple[Path, Sources]) -> None:
    folder, sources = room
    wanted = {"return x + STEP": "plain", "STEP = 3": "plain", "return kernel(x) * 2": "compiled"}
    assert {text: sources.mode_of(mutant(folder, "room.py", text)) for text in wanted} == wanted
    assert sources.mode_of(mutant(folder, "other.py", "LIMIT = 1")) == "plain"
    assert sources.mode_of(mutant(folder, "other.py", "return x - LIMIT")) == "compiled"


def test_the_tests_that_run_a_line_judge_it_the_quickest_first_within_the_budget(room: tuple[Path, Sources]) -> None:
    folder, sources = room
    path = str(PACKAGE / "wire" / "room.py")
    part = {
        "cpu_s": {"t.py::slow": 9.0, "t.py::quick": 0.1, "t.py::other": 0.2, "u.py::made": 1.0, "t.py::bad": 0.1},
        "left_out": {"t.py::bad": "failed"},
        "lines": {path: {"9": ["t.py::slow", "t.py::quick", "t.py::bad"], "13": ["t.py::other", "import u.py"]}},
    }
    measured = Measured([part], sources)
    compiled = mutant(folder, "room.py", "return x + STEP")
    assert measured.chosen(compiled, 20.0).stages == [["t.py::quick", "t.py::slow"]]
    assert measured.chosen(compiled, 5.0).stages == [["t.py::quick"]]
    # A file that runs a line while it is imported runs it for each of its tests.
    assert measured.tests_of(mutant(folder, "room.py", "return kernel(x) * 2")) == {"t.py::other", "u.py::made"}
    # A constant is judged by the tests of the functions that mention it.
    assert measured.tests_of(mutant(folder, "room.py", "STEP = 3")) == {"t.py::quick", "t.py::slow"}


def test_what_is_tried_without_the_change_is_the_test_that_failed_or_the_first_of_its_file() -> None:
    stages = [["a.py::one", "b.py::two"], ["b.py::three"]]
    assert suspect_of("b.py::three", stages) == "b.py::three"
    assert suspect_of("b.py: import", stages) == "b.py::two"
    assert suspect_of("MemoryError outside of any test", stages) == "a.py::one"
