"""Every page says in its first paragraph for whom it is; the check that holds them to it finds those that do not."""

from __future__ import annotations

from pathlib import Path

from checks.first_paragraphs import silent_pages


def test_every_page_says_for_whom_it_is() -> None:
    assert list(silent_pages()) == []


def test_a_page_that_begins_with_a_picture_or_without_a_reader_is_found(tmp_path: Path) -> None:
    (tmp_path / "picture.md").write_text("# A page\n\n![a wire](wire.png)\n\nFor makers.\n")
    (tmp_path / "subject.md").write_text("# A page\n\nA wire is thin.\n")
    (tmp_path / "reader.md").write_text("# A page\n\n<!-- Written by a\nprogram -->\n\nFor makers: a wire.\n")
    assert list(silent_pages(tmp_path)) == ["picture.md", "subject.md"]
