"""The pages of the site that are written from the code whenever it is built, and are in no commit.

Of some pages a commit has what is written by hand, and the site adds tables: options of commands, messages of the
firmware, what rows of the paper say.

    python docs/site/written_pages.py          lists their names
    python docs/site/written_pages.py NAME     prints one, as reference/protection

A committed page links to the heading that docs/reference/generated.md has for each; layout.py leads it to the page.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "images"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "firmware"))
import circuits_page
import columns_page
import command_line_page
import faults_page
import live_api_page
import paper_map_page
import parameter_page
import protection_page
import protocol
import python_page
import rig_keys_page
import simulated_numbers_page
import toml_keys_page
import wire_row_page

PAGES: dict[str, Callable[[], str]] = {
    "reference/circuits": circuits_page.page,
    "reference/columns": columns_page.page,
    "reference/command_line": command_line_page.page,
    "reference/faults": faults_page.page,
    "reference/firmware_protocol": protocol.page,
    "reference/rig_files": rig_keys_page.page,
    "reference/live_api": live_api_page.page,
    "reference/paper_map": paper_map_page.page,
    "reference/parameters": parameter_page.page,
    "reference/protection": protection_page.page,
    "reference/python": python_page.page,
    "reference/simulated_numbers": simulated_numbers_page.page,
    "reference/toml_files": toml_keys_page.page,
    "reference/wire_row": wire_row_page.page,
}


def written(name: str) -> str:
    """Return a page by its name."""
    return PAGES[name]()


def all_written() -> dict[str, str]:
    """Return every page by its name; they are written side by side, since some simulate wires."""
    with ProcessPoolExecutor() as pool:
        return dict(zip(PAGES, pool.map(written, PAGES), strict=True))


def main() -> int:
    """Print a page, or the names of all; return 2 for a name that is none."""
    if len(sys.argv) != 2 or sys.argv[1] not in PAGES:
        print(*PAGES, sep="\n")
        return 0 if len(sys.argv) == 1 else 2
    print(written(sys.argv[1]), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
