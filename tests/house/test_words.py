"""The check of words finds what an engineer of the field would stumble on, and nothing that is right."""

from __future__ import annotations

from pathlib import Path

import pytest
from checks.words import PLACES, files_below, findings_in, main, read_list, waiting_place

WORDS = read_list()


def found(tmp_path: Path, text: str, suffix: str = ".md") -> list[str]:
    path = tmp_path / f"page{suffix}"
    path.write_text(text, "utf-8")
    return [finding.text for finding in findings_in(path, WORDS)]


def test_nothing_is_found_outside_of_the_rooms_that_are_being_rewritten() -> None:
    findings = [one for path in files_below(PLACES) for one in findings_in(path, WORDS)]
    assert [str(one) for one in findings if waiting_place(one, WORDS) is None] == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("The run begins anew.", ["anew"]),
        ("Two lines\nand 14 cm in all, both legs.", ["in all"]),
        ("It is the same in all commands.", []),
        ("A share of the strain; legs that share the force.", ["A share"]),
        ("Which parameters are told?", ["told"]),
        ("Noise is told apart from contact. Heating and cooling cannot be told reliably apart.", []),
        ("`beside` is a name, and [beside](x.md) is a link's text.", ["beside"]),
        ("```\nanew\n```\n\n    shall\n", []),
        ("Raises CallerError where it is empty.", ["Raises CallerError where"]),
        ("A place where the wire is hot.", []),
    ],
)
def test_sentences(text: str, words: list[str], tmp_path: Path) -> None:
    assert found(tmp_path, text) == words


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("LEAST_VOLTAGE_V = 1.0\n", ["LEAST_"]),
        ("MIN_VOLTAGE_V = 1.0\n", []),
        ("def weigh(share_of_b: float) -> float:\n    return share_of_b\n", ["share_"]),
        ("valid_share = 1.0\n", []),
        ('"""The wire gives way."""\n', ["gives way"]),
        ('key = "beside"\n', []),
        ("# what stands in the table\n", ["stands in"]),
    ],
)
def test_sources(source: str, words: list[str], tmp_path: Path) -> None:
    assert found(tmp_path, source, ".py") == words


def test_a_page_is_read_and_files_of_others_are_not(tmp_path: Path) -> None:
    (tmp_path / "vendor").mkdir()
    for name in ("page.js", "vendor/theirs.js"):
        (tmp_path / name).write_text("/** Begins anew. */\n", "utf-8")
    assert [path.name for path in files_below([tmp_path])] == ["page.js"]


def test_a_finding_names_place_word_and_remedy(tmp_path: Path) -> None:
    path = tmp_path / "page.md"
    path.write_text("One.\n\nTwo\nbegins anew.\n", "utf-8")
    (finding,) = findings_in(path, WORDS)
    assert str(finding) == f"{path}:4: 'anew': again"


def test_the_check_ends_with_exit_code_1_if_it_finds_something(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.md"
    page.write_text("One begins anew.\n", "utf-8")
    assert main([str(page)]) == 1
    page.write_text("One begins again.\n", "utf-8")
    assert main([str(page)]) == 0
    assert "'anew': again" in capsys.readouterr().out
