"""Check that the first paragraph of every page of the documentation says for whom the page is.

    python checks/first_paragraphs.py

A page is a Markdown file under docs/; single decisions are left out, whose list says it for all of them. The first that
follows the title is a paragraph, no picture, code, list or table, and begins with "For" and the reader.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
DECISION = re.compile(r"explanation/decisions/\d")
COMMENT = re.compile(r"<!--.*?-->\s*", re.S)
PAGE = re.compile(r"# [^\n]+\n\n(For \w[^\n]*)")


def silent_pages(docs: Path = DOCS) -> Iterator[str]:
    """Yield the pages whose first paragraph does not say for whom they are."""
    for page in sorted(docs.rglob("*.md")):
        path = page.relative_to(docs).as_posix()
        if not DECISION.match(path) and not PAGE.match(COMMENT.sub("", page.read_text("utf-8"))):
            yield path


def main() -> int:
    """Print the pages that do not say for whom they are; exit code 1 if there is one."""
    silent = list(silent_pages())
    for path in silent:
        print(f"docs/{path}: begin the first paragraph with For and the reader, as: For makers with an Arduino: ...")
    print(f"{len(silent)} pages do not say for whom they are")
    return 1 if silent else 0


if __name__ == "__main__":
    sys.exit(main())
