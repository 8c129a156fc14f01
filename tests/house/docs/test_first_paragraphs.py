"""Every page says in its first paragraph for whom it is: "For" and the reader, before any picture, code or table."""

from __future__ import annotations

import re

from tests.places import CHECKOUT

DOCS = CHECKOUT / "docs"
DECISION = re.compile(r"explanation/decisions/\d")  # their list says it for all of them
COMMENT = re.compile(r"<!--.*?-->\s*", re.S)
BEGINNING = re.compile(r"# [^\n]+\n\n(For \w[^\n]*)")


def test_every_page_says_for_whom_it_is() -> None:
    pages = [page for page in sorted(DOCS.rglob("*.md")) if not DECISION.match(page.relative_to(DOCS).as_posix())]
    silent = [page.name for page in pages if not BEGINNING.match(COMMENT.sub("", page.read_text("utf-8")))]
    assert silent == [], "begin the first paragraph with For and the reader, as: For makers with an Arduino: ..."
