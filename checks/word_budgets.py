"""Count the words that a reader meets on the way from README to an end, and fail where a way is longer than its budget.

    python checks/word_budgets.py

Counted is what a page shows: headings, sentences, tables, code, captions of links; not the addresses of links,
comments, marks of Markdown, nor the text that stands in for a picture. A page counts whole, even where a reader may
stop earlier. On the way to one's own board are README, the maker's page, and every page that it links in bold.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
README, MAKER, LOOP = "README.md", "docs/start/maker.md", "docs/tutorials/the_basic_loop.md"
BOLD_LINK = re.compile(r"\*\*\[[^\]]*\]\(([^)#\s]+)[^)]*\)\*\*")
HIDDEN = (
    (re.compile(r"<!--.*?-->", re.S), ""),
    (re.compile(r"^```.*$", re.M), ""),
    (re.compile(r"!\[[^\]]*\]\([^)]*\)"), ""),
    (re.compile(r"\[([^\]]*)\]\([^)]*\)"), r"\1"),
    (re.compile(r"^\|[-:| ]+\|$", re.M), ""),
)


def words(text: str) -> int:
    """Return how many words a page shows: what stands between blanks and has a letter or a digit."""
    for pattern, instead in HIDDEN:
        text = pattern.sub(instead, text)
    return sum(any(character.isalnum() for character in word) for word in text.split())


def bold_links(page: Path) -> list[str]:
    """Return the pages that a page links in bold, in their order, as paths within the repository."""
    found = [(page.parent / target).resolve() for target in BOLD_LINK.findall(page.read_text("utf-8"))]
    return list(dict.fromkeys(path.relative_to(ROOT).as_posix() for path in found))


def ways() -> dict[str, tuple[int, list[str]]]:
    """Return each way by its end: the budget in words, and its pages."""
    return {
        "a controlled simulated wire": (900, [README, LOOP]),
        "one's own board": (5000, [README, MAKER, *bold_links(ROOT / MAKER)]),
    }


def main() -> int:
    """Print the words of each page of each way; exit code 1 if one is over its budget."""
    over = 0
    for end, (budget, pages) in ways().items():
        counts = {page: words((ROOT / page).read_text("utf-8")) for page in pages}
        total = sum(counts.values())
        over += total > budget
        print(f"{total:5d} words of at most {budget} from README to {end}{': TOO MANY' if total > budget else ''}")
        for page, count in counts.items():
            print(f"      {count:5d}  {page}")
    return int(over > 0)


if __name__ == "__main__":
    sys.exit(main())
