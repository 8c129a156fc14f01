"""Both pages opened by a real Chromium with the network cut off: every figure is there and has size."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from musclewire.app.report.paper_figures import FIGURES

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = [
    *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--host-resolver-rules=MAP * ~NOTFOUND"),
]
# The page itself runs no script; this one, added to a copy, measures what the browser made of it.
MEASURE = """<script>
const size = [...document.querySelectorAll("svg")].map(s => s.getBoundingClientRect());
document.title = "figures " + size.filter(b => b.width > 250 && b.height > 150).length
  + " width " + document.documentElement.scrollWidth + " rows " + document.querySelectorAll("tbody tr").length;
</script></body>"""


class Measured(NamedTuple):
    """How many figures have size, how wide the page is, how many rows its tables have."""

    figures: int
    width: int
    rows: int


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both pages, as the commands write them."""
    if CHROMIUM is None:
        if os.environ.get("MUSCLEWIRE_REQUIRE_BROWSER"):
            pytest.fail("no Chromium: apt-get install --no-install-recommends chromium")
        pytest.skip("not run: needs Chromium (apt-get install --no-install-recommends chromium)")
    path = tmp_path_factory.mktemp("pages")
    for command in (("demo",), ("reproduce", "--seeds", "3")):
        done = subprocess.run(
            [sys.executable, "-m", "musclewire", *command, "--json", "--out", str(path)],
            check=False, capture_output=True, text=True, timeout=600,
        )  # fmt: skip
        assert done.returncode in {0, 1}, done.stderr  # 1 where a row of the paper fails; the page is there
    return path


def measured(page: Path, width: int, profile: Path) -> Measured:
    """Open a copy of a page at a width and read what the browser made of it."""
    copy = page.with_name(f"measured-{page.name}")
    copy.write_text(page.read_text("utf-8").replace("</body>", MEASURE), "utf-8")
    shown = subprocess.run(
        [str(CHROMIUM), *FLAGS, f"--user-data-dir={profile}", f"--window-size={width},2000", "--dump-dom",
         copy.as_uri()],
        check=True, capture_output=True, text=True, timeout=120,
    ).stdout  # fmt: skip
    found = re.search(r"<title>figures (\d+) width (\d+) rows (\d+)</title>", shown)
    assert found is not None
    return Measured(*(int(text) for text in found.groups()))


@pytest.mark.browser
@pytest.mark.parametrize(("page", "figures", "rows"), [("report.html", 5, 20), ("reproduce.html", len(FIGURES), 150)])
@pytest.mark.parametrize("width", [1100, 420])
def test_a_page_shows_its_figures_in_a_real_browser(
    page: str, figures: int, rows: int, width: int, folder: Path, tmp_path: Path
) -> None:
    seen = measured(folder / page, width, tmp_path / "profile")
    assert seen.figures == figures
    assert seen.width <= max(width, 500)  # headless Chromium goes no narrower than 500; nothing sticks out sideways
    assert seen.rows >= rows
