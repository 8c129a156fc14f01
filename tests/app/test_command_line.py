"""The command line as a whole: its list of commands, its options, the Tab key, and its version."""

from __future__ import annotations

import importlib.metadata
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.command_line import CommandLine
from tests.subjects import subjects_of

from musclewire.app import (
    COMMANDS,
    OPTIONS,
    PANELS,
    REQUIREMENT,
    commit_of,
    complete_controllers,
    complete_estimators,
    complete_rigs,
    complete_rule_bases,
    complete_wires,
    every_command,
    listed_commands,
)
from musclewire.controllers import CONTROLLERS, rule_base_names
from musclewire.parameters import names
from musclewire.rigs import rig_names
from musclewire.sensing import ESTIMATORS

# ``--help`` lists every command once, as a reader meets them; a wrong word leads to the right ones.


def test_every_command_is_in_a_known_panel() -> None:
    assert {command.rich_help_panel for command in listed_commands().values()} <= set(PANELS)
    assert {command.name for command in COMMANDS} <= listed_commands().keys()


def first_paragraph(text: str) -> str:
    """The first paragraph of a help as one line."""
    return " ".join(text.split("\n\n")[0].split())


def test_the_list_says_of_each_command_what_the_command_says_of_itself() -> None:
    """The list is static, so that ``--help`` imports no command; it must not tell something else."""
    listed = {}
    for name, command in listed_commands().items():
        members = getattr(command, "commands", None)
        listed |= {name: command} if members is None else {f"{name} {key}": one for key, one in members.items()}
    assert {name: command.help for name, command in listed.items()} == {
        name: first_paragraph(command.help) for name, command in every_command().items()
    }


def test_help_loads_no_compiler() -> None:
    """What is read before a first command, and at every Tab, is to be quick (benchmarks/start_up.py)."""
    code = "import sys; from musclewire.app._main import run; run(['--help']); print('numba' in sys.modules)"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.splitlines()[-1] == "False"


# What --version says is what is installed, and what cite says is that version.


def test_the_first_line_is_the_version_alone(musclewire: CommandLine) -> None:
    answer = musclewire("--version")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.splitlines()[0] == f"musclewire {importlib.metadata.version('musclewire')}"


def test_the_document_says_what_is_there(musclewire: CommandLine) -> None:
    found = musclewire("--version", "--json").json
    assert found["packages"]["numpy"] == np.__version__
    assert found["packages"]["llvmlite"] == importlib.metadata.version("llvmlite")
    assert found["extras"]["pandas"] is True
    assert not {"test", "oracles", "dev"} & set(found["extras"])


def test_what_to_cite_is_this_version_in_words_and_in_bibtex(musclewire: CommandLine) -> None:
    words, entries = musclewire("cite", "--json").json.values()
    assert importlib.metadata.version("musclewire") in entries[0]
    printed = musclewire("cite", "--bibtex").out
    assert printed.strip() == "\n\n".join(entries)
    assert len(words) == printed.count("@") == 4
    assert all(entry.count("{") == entry.count("}") and entry.endswith("\n}") for entry in entries)


def test_a_requirement_is_a_name_and_an_extra() -> None:
    requirement = 'nidaqmx[grpc]<2,>=1.7; python_version < "4" and extra == "nidaq"'
    found = [REQUIREMENT.match(text) for text in ("numpy>=1.26", requirement)]
    assert [match and match.groups() for match in found] == [("numpy", None), ("nidaqmx", "nidaq")]


@pytest.mark.slow
def test_the_commit_of_a_checkout_and_whether_it_was_changed(tmp_path: Path) -> None:
    def git(*arguments: str) -> str:
        who = ("-c", "user.name=a", "-c", "user.email=a@b")
        done = subprocess.run(["git", *who, *arguments], cwd=tmp_path, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    (tmp_path / "pyproject.toml").touch()
    git("init", "-q")
    git("add", "-A")
    git("commit", "-q", "-m", "first")
    assert commit_of(tmp_path / "no checkout") is None
    name = git("rev-parse", "--short=12", "HEAD")
    assert commit_of(tmp_path) == name
    (tmp_path / "another").touch()
    assert commit_of(tmp_path) == f"{name}, with changes"


# The options of all commands are one list: a name means one thing.


def kind_of(option: Any) -> tuple[Any, bool]:
    """What Python type an option becomes, a list of it if repeatable, and whether it is a switch without a value."""
    return option.type_descriptor.annotation, option.is_flag


OPTIONS_OF = {
    name: [one for one in command.params if one.param_type_name == "option" and one.opts[0] != "--help"]
    for name, command in every_command().items()
}
# A package beside ours may bring a command, which is judged where developers' packages are: README's tests do without.
EACH = [
    pytest.param(name, marks=() if command.callback.__module__.startswith("musclewire.") else pytest.mark.slow)
    for name, command in every_command().items()
    if command.callback is not None
]
USES = [option for options in OPTIONS_OF.values() for option in options]
# A help may name the options of another command as that command's.
OF_ANOTHER = re.compile(r"'musclewire [^']*'")
NAMED = re.compile(r"(?<![\w-])--[a-z][a-z-]+")


def test_every_option_is_one_of_the_list() -> None:
    for use in USES:
        definition = OPTIONS[use.opts[0]]
        assert tuple(use.opts) == definition.names
        assert (use.metavar == "QUANTITY") == (definition.quantity is not None)


def test_what_all_of_its_commands_say_otherwise_is_not_in_the_list() -> None:
    said = {use.help for use in USES} | {OPTIONS["--output"].help}
    here = {use.opts[0] for use in USES}  # a package that is not installed may bring the others' commands
    assert [name for name in OPTIONS if name in here and OPTIONS[name].help not in said] == []


@pytest.mark.parametrize("command", EACH)
def test_a_help_names_options_of_its_own_command(command: str) -> None:
    own = {name for option in OPTIONS_OF[command] for name in option.opts}
    named = {name for option in OPTIONS_OF[command] for name in NAMED.findall(OF_ANOTHER.sub("", option.help))}
    assert named <= own


@pytest.mark.parametrize("command", EACH)
def test_a_default_that_a_help_names_is_no_other_than_the_commands_own(command: str) -> None:
    own = {option.opts[0]: option.default for option in OPTIONS_OF[command] if "Default:" in option.help}
    assert {name: default for name, default in own.items() if default is not None} == {}


def test_the_same_name_takes_the_same_kind_of_value_everywhere() -> None:
    kinds: dict[str, set[tuple[Any, bool]]] = {}
    for use in USES:
        kinds.setdefault(use.opts[0], set()).add(kind_of(use))
    assert {name: kind for name, kind in kinds.items() if len(kind) > 1} == {}


def test_times_lengths_and_all_other_quantities_have_a_unit() -> None:
    plain = {use.opts[0] for use in USES if kind_of(use)[0] is float}
    assert plain - {name for name, one in OPTIONS.items() if one.quantity} <= {"--friction", "--clock-speed"}  # ratios


# Names are completed as a shell asks for them; bash runs what it is given.

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
