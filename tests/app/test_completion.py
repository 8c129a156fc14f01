"""Names are completed as a shell asks for them; bash runs what it is given."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from tests.subjects import subjects_of

from musclewire.app import (
    complete_controllers,
    complete_estimators,
    complete_rigs,
    complete_rule_bases,
    complete_wires,
)
from musclewire.controllers import CONTROLLERS, rule_base_names
from musclewire.parameters import names
from musclewire.rigs import rig_names
from musclewire.sensing import ESTIMATORS

# What is typed, and the one answer: all in bash, and some in every shell.
QUESTIONS: list[tuple[str, str]] = subjects_of("app", "*_completions.py", "QUESTIONS")
IN_EVERY_SHELL: list[tuple[str, str]] = subjects_of("app", "*_completions.py", "IN_EVERY_SHELL")


def test_all_names_are_offered_and_no_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert complete_rigs("") == rig_names()
    assert complete_wires("") == names("wire")
    assert complete_rule_bases("") == list(rule_base_names())
    assert complete_estimators("") == list(ESTIMATORS.names())
    assert complete_controllers("") == list(CONTROLLERS.names())


def test_own_files_are_offered_next_to_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("finger_of_mine.toml", "finger_of_mine.h5", "bench.toml"):
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    assert complete_rigs("fin") == ["finger", "finger_of_mine.toml"]
    assert complete_rigs("./fin") == []  # a path is the shell's own business


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """Variables of a shell that finds this musclewire by its name."""
    program = tmp_path / "bin" / "musclewire"
    program.parent.mkdir()
    program.write_text(f"#!{sys.executable}\nfrom musclewire.app._main import main\nmain()\n", "utf-8")
    program.chmod(0o755)
    home = {"HOME": str(tmp_path), "PATH": f"{program.parent}:{os.environ['PATH']}", "TERM": "dumb", "PS1": "$ "}
    return {**os.environ, **home}


def script_of(shell: str, environment: dict[str, str]) -> str:
    asked = {**environment, "_MUSCLEWIRE_COMPLETE": f"source_{shell}"}
    return subprocess.run(["musclewire"], env=asked, capture_output=True, text=True, check=True).stdout


@pytest.mark.slow
@pytest.mark.parametrize(("typed", "answer"), QUESTIONS)
def test_bash_completes(typed: str, answer: str, environment: dict[str, str]) -> None:
    words = ["musclewire", *typed.split(" ")]
    lines = [
        script_of("bash", environment),
        f"COMP_WORDS=({' '.join(words)}); COMP_CWORD={len(words) - 1}",
        "_musclewire_completion musclewire; printf '%s\\n' \"${COMPREPLY[@]}\"",
    ]
    done = subprocess.run(["bash", "-c", "\n".join(lines)], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [answer]


@pytest.mark.slow
@pytest.mark.parametrize("shell", ["zsh", "fish"])
@pytest.mark.parametrize(("typed", "answer"), IN_EVERY_SHELL)
def test_zsh_and_fish_are_answered_what_their_lines_ask(
    shell: str, typed: str, answer: str, environment: dict[str, str]
) -> None:
    asked = {"_MUSCLEWIRE_COMPLETE": f"complete_{shell}", "_TYPER_COMPLETE_ARGS": f"musclewire {typed}"}
    assert all(name in script_of(shell, environment) for name in asked)
    asked["_TYPER_COMPLETE_FISH_ACTION"] = "get-args"
    done = subprocess.run(["musclewire"], env={**environment, **asked}, capture_output=True, text=True, check=False)
    assert answer in done.stdout
