"""``--help`` lists every command once, as a reader meets them; a wrong word leads to the right ones."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest
import typer

from musclewire.app.main import app
from musclewire.app.panels import PANELS


def test_every_command_is_in_one_panel_and_shown_there() -> None:
    listed = [name for names in PANELS.values() for name in names]
    shown = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    assert sorted(listed) == sorted(shown)
    assert {name: command.rich_help_panel for name, command in shown.items()} == {
        name: title for title, names in PANELS.items() for name in names
    }


def test_help_has_the_panels_in_their_order(musclewire: Callable[..., Any]) -> None:
    text = musclewire("--help").out
    places = [text.index(title) for title in PANELS]
    assert places == sorted(places)
    basic = [text.index(f"\u2502 {name} ") for name in PANELS["The basic loop: record, fit, move"]]
    assert basic == sorted(basic)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("foo",), "No such command 'foo'; 'musclewire --help' lists what there is"),
        (("charakterize",), "No such command 'charakterize'. Did you mean 'characterize'?"),
        (("control", "a", "b", "--settings", "x"), "'musclewire control --help' lists what there is"),
        (("control", "a", "b", "--refrence", "x"), "(Possible options: --reference)"),
    ],
)
def test_a_wrong_word_names_the_nearest_or_where_all_are_listed(
    words: tuple[str, ...], said: str, musclewire: Callable[..., Any]
) -> None:
    answer = musclewire(*words)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.endswith(said + "\n")
    assert len(answer.err.splitlines()) == 1


def test_help_loads_no_compiler() -> None:
    """What is read before a first command, and at every Tab, is to be quick (benchmarks/start_up.py)."""
    code = "import sys; from musclewire.app.main import run; run(['--help']); print('numba' in sys.modules)"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.splitlines()[-1] == "False"
