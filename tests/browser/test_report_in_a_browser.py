"""The report opened by a real Chromium with the network cut off: every figure is there and has size."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

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


@pytest.mark.browser
@pytest.mark.parametrize("width", [1100, 420])
def test_the_report_shows_its_figures_in_a_real_browser(width: int, tmp_path: Path) -> None:
    if CHROMIUM is None:
        if os.environ.get("MUSCLEWIRE_REQUIRE_BROWSER"):
            pytest.fail("no Chromium: apt-get install --no-install-recommends chromium")
        pytest.skip("not run: needs Chromium (apt-get install --no-install-recommends chromium)")
    folder = tmp_path / "demo"
    subprocess.run(
        [sys.executable, "-m", "musclewire", "demo", "--json", "--out", str(folder)],
        check=True, capture_output=True, timeout=300,
    )  # fmt: skip
    page = folder / "measured.html"
    page.write_text((folder / "report.html").read_text("utf-8").replace("</body>", MEASURE), "utf-8")
    profile = f"--user-data-dir={tmp_path / 'profile'}"
    shown = subprocess.run(
        [CHROMIUM, *FLAGS, profile, f"--window-size={width},2000", "--dump-dom", page.as_uri()],
        check=True, capture_output=True, text=True, timeout=120,
    ).stdout  # fmt: skip
    found = re.search(r"<title>figures (\d+) width (\d+) rows (\d+)</title>", shown)
    assert found is not None
    figures, page_width, rows = (int(text) for text in found.groups())
    assert figures == 5
    assert page_width <= max(width, 500)  # headless Chromium goes no narrower than 500; nothing sticks out sideways
    assert rows > 11 + 8
