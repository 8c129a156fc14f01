"""The check of words finds what an engineer of the field would stumble on, and nothing that is right."""

from __future__ import annotations

from pathlib import Path

import pytest
from checks.words import findings_in


@pytest.mark.parametrize(
    ("suffix", "text", "words"),
    [
        (".md", "The run begins anew.", ["anew"]),
        (".md", "Noise is told apart from contact. Heating and cooling cannot be told reliably apart.", []),
        (".md", "`beside` is a name, and [beside](x.md) is a link's text.", ["beside"]),
        (".py", "LEAST_VOLTAGE_V = 1.0\n", ["LEAST_"]),
        (".py", '"""The wire gives way."""\n', ["gives way"]),
        (".py", 'key = "beside"\n', []),
        (".js", "/** Begins anew. */\n", ["anew"]),
    ],
)
def test_words_in_sentences_and_names(suffix: str, text: str, words: list[str], tmp_path: Path) -> None:
    path = tmp_path / f"page{suffix}"
    path.write_text(text, "utf-8")
    assert [finding.split("'")[1] for finding in findings_in(path)] == words


def test_a_finding_names_place_word_and_remedy(tmp_path: Path) -> None:
    path = tmp_path / "page.md"
    path.write_text("One.\n\n```\na block\n```\n\nTwo\nbegins anew.\n", "utf-8")
    assert list(findings_in(path)) == [f"{path}:8: 'anew': again"]
