"""What checks/size.py counts, and that a copy of the checkout which has grown does not pass."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from checks.size import changed, imports_private, numbers_in_table, numbers_of
from tests.places import CHECKOUT

COUNTED = """
LIMIT_K, PARTS = 3.5, (1, -2, 3)

class Settings:
    period_s: float = 90.0
    name: str = "one"

def late(time_s, after_s=4, *, twice=True):
    def inner(again_s=5):
        return again_s + 6.0
    return 2 * time_s - 1 > 0.5 * after_s + 7 or inner(-1)
"""


def test_numbers_are_counted_where_they_stand() -> None:
    # 3.5, 1, -2, 3; 90, 4, 5; 6, 7 and, with the function inside, its default again.
    assert numbers_of(ast.parse(COUNTED)) == (4, 3, 3)


def test_a_table_of_a_method_has_the_numbers_of_all_its_levels() -> None:
    assert numbers_in_table({"a": [1, {"b": 2.5}], "c": True, "d": "3"}) == 2


@pytest.mark.parametrize(
    ("text", "private"),
    [
        ("from musclewire.sensing._curve import Curve", True),
        ("import musclewire.wire._step", True),
        ("from musclewire.sensing import Curve", False),
        ("from _pytest import fixtures", False),
    ],
)
def test_a_private_module_is_one_of_musclewire_behind_a_list(text: str, private: bool) -> None:
    assert imports_private(ast.parse(text)) is private


def test_what_has_risen_is_named_and_what_is_not_held_is_not() -> None:
    assert changed({"words": 40, "core_numbers": -5, "data_lines": 300, "options": 0}) == (["words"], ["core_numbers"])


@pytest.mark.slow
def test_statements_literals_and_words_that_are_added_are_seen(tmp_path: Path) -> None:
    subprocess.run(["git", "clone", "-q", str(CHECKOUT), str(tmp_path / "copy")], check=True)
    copy = tmp_path / "copy"
    count = "import sys, json; sys.path.insert(0, '.'); from checks.size import static_sizes; print(static_sizes())"

    def counted() -> dict[str, int]:
        done = subprocess.run([sys.executable, "-c", count], cwd=copy, capture_output=True, text=True, check=True)
        sizes: dict[str, int] = ast.literal_eval(done.stdout)
        return sizes

    before = counted()
    grown = copy / "src/musclewire/errors.py"
    grown.write_text(grown.read_text("utf-8") + "\n\n" + "A = 3\n" * 5 + "B = ''\n" * 25, encoding="utf-8")
    page = copy / "README.md"
    page.write_text(page.read_text("utf-8") + "word " * 40, encoding="utf-8")
    after = counted()
    risen = {name: after[name] - before[name] for name in after if after[name] != before[name]}
    assert risen == {"core_statements": 30, "core_lines": 32, "core_numbers": 5, "words": 40,
                     "src_statements": 30, "src_lines": 32}  # fmt: skip
