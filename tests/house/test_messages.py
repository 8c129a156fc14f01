"""The list of messages has every way in which the source says one, and its rules find what a user cannot act on."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from checks.messages import Finder, Message, Rules, Source, messages_below

RULES = Rules.read()
ERRORS = "class CallerError(ValueError): ...\nclass RigError(Exception): ...\nclass LostError(RigError): ...\n"


def messages(tmp_path: Path, source: str) -> list[tuple[str, str]]:
    path = tmp_path / "source.py"
    path.write_text(ERRORS + source, "utf-8")
    parsed = Source(path)
    return [(one.owner, one.text) for one in Finder.of([parsed]).messages_in(parsed)]


def broken(text: str) -> list[str]:
    return list(RULES.broken_by(Message("caller", "a.py", 1, text)))


@pytest.mark.slow
def test_every_message_of_the_source_keeps_the_rules() -> None:
    found = messages_below()
    assert len(found) > 1000
    assert {one.owner for one in found} == {"caller", "recording", "rig", "numerics", "warning"}
    assert [(str(one), reason) for one in found for reason in RULES.broken_by(one)] == []


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("raise CallerError(f'{name} is {value:g} mm: give more')", ("caller", "{name} is {value} mm: give more")),
        ("raise LostError('no answer' + f' on {port}')", ("rig", "no answer on {port}")),
        ("raise ValueError(f'low {low} is above high')", ("caller", "low {low} is above high")),
        ("raise CallerError('longer' if a else 'shorter by %s' + b)", ("caller", "<longer|shorter by %s{b}>")),
        ("TEXT = 'no time {}'\nraise CallerError(TEXT.format(1))", ("caller", "no time {}")),
        ("def a(b):\n    c = 'a wire' if b else 'no wire'\n    raise CallerError(c)", ("caller", "<a wire|no wire>")),
        ("def text(b):\n    return f'has no {b}'\nraise CallerError(text(1))", ("caller", "has no {b}")),
        ("def lost(it) -> RigError:\n    return RigError(it)\nraise lost('no text')", ("rig", "{place}: no text")),
        ("found.warnings.append('it is far too hot')", ("warning", "it is far too hot")),
        ("Model(warnings=['it is far too hot'])", ("warning", "it is far too hot")),
        ("def hot_warnings():\n    yield f'it is {t} C hot'", ("warning", "it is {t} C hot")),
    ],
)  # fmt: skip
def test_each_way_to_say_something_is_found(source: str, expected: tuple[str, str], tmp_path: Path) -> None:
    assert expected in messages(tmp_path, source)


@pytest.mark.parametrize(
    "source",
    [
        'def hot_warnings():\n    """Return what is hot."""\n    return ()',
        "raise CallerError",
        "x = 'a text of some words'",
    ],
)
def test_what_is_no_message_is_left_out(source: str, tmp_path: Path) -> None:
    assert messages(tmp_path, source) == []


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("{name} is {value}\ngive another", "one line"),
        ("{name} is {value}: give another.", "stop"),
        ("invalid value {value}: give another", "say what is wrong with it"),
        ("please give {name}", "courtesies"),
        ("{name} has failed to open: try again", "what stopped it"),
        ("The {name} is {value}: give another", "small letter"),
        ("it is too hot: drive it lower", "name the value"),
        ("'mode' must be above 'low'", "what was given"),
        ("{name} is {value}", "say what to do"),
        ("{name} is {value}: give another " + "and so on " * 30, "fewer than"),
    ],
)
def test_what_breaks_a_rule_is_found(text: str, reason: str) -> None:
    assert any(reason in one for one in broken(text))


@pytest.mark.parametrize(
    "text",
    [
        "{name} is {value}: give a number above 0",
        "{path}: cannot be written: {problem.strerror}",
        "unknown key '{key}'{nearest_hint(key, known)}",
        "NI-DAQmx is not installed: install it from ni.com, or give the port of a machine that has it (--grpc)",
        "{str(error)}",
        "this rig is closed or has failed and stays off: open it again",
    ],
)
def test_what_keeps_the_rules_is_no_finding(text: str) -> None:
    assert broken(text) == []


def test_reading_messages_leaves_the_trees_of_others_alone(tmp_path: Path) -> None:
    """Python has one ``ast.Load()`` for all trees: a note on it would be copied with every node of any other tree."""
    messages(tmp_path, "raise CallerError(f'{name} is {-value + 1} mm: give more')")
    other = ast.parse("a = -b + c")
    assert not any(hasattr(node, "around") for node in ast.walk(other))
