"""Count the words on a maker's way to a wire of their own: README, the door, and the pages that it links in bold.

    python checks/words_on_the_way.py

Everything between two spaces counts, commands and tables too. Exit code 1 if there are more than ``MOST``.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
README, DOOR = ROOT / "README.md", ROOT / "docs/start/maker.md"
MOST = 3000
BOLD_LINK = re.compile(r"\*\*\[[^\]]+\]\(([^)#]+\.md)[^)]*\)\*\*")


def pages_on_the_way() -> list[Path]:
    """Return the pages in the order in which they are read."""
    linked = BOLD_LINK.findall(DOOR.read_text("utf-8"))
    return [README, DOOR, *((DOOR.parent / link).resolve() for link in dict.fromkeys(linked))]


def words_by_page() -> dict[str, int]:
    """Return how many words each page on the way has."""
    return {page.relative_to(ROOT).as_posix(): len(page.read_text("utf-8").split()) for page in pages_on_the_way()}


def main() -> int:
    """Print the count of each page and their sum."""
    counts = words_by_page()
    for page, count in counts.items():
        print(f"{count:6} {page}")
    together = sum(counts.values())
    print(f"{together:6} together, at most {MOST}")
    return int(together > MOST)


if __name__ == "__main__":
    sys.exit(main())
