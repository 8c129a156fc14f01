"""Every report in a real Chromium with the network cut off: on a phone and a screen, in the light and in the dark."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from tests.browser.chromium import SIZES
from tests.browser.report_subject import ReportSubject
from tests.subjects import subjects_of

SUBJECTS: list[ReportSubject] = subjects_of("browser", "*_reports.py", "SUBJECTS")
# Sizes of the figures that are shown, and what sticks out sideways of the page without being in a frame that scrolls.
SHOWN = """() => [...document.querySelectorAll("svg")].map(s => s.getBoundingClientRect())
  .filter(b => b.width > 250 && b.height > 150).length"""
STICKING_OUT = """() => [...document.body.querySelectorAll("*")]
  .filter(e => !e.closest(".scroll") && !e.closest("svg") && e.getBoundingClientRect().right > innerWidth + 1)
  .map(e => e.outerHTML.slice(0, 120))"""
# The worst contrast of text with what is behind it (WCAG 2.2): text in a figure is left to the figure.
WORST_CONTRAST = """() => {
  const channels = text => text.match(/[\\d.]+/g).map(Number);
  const luminance = ([r, g, b]) => [r, g, b].map(v => v / 255)
    .map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const ground = e => { for (; e; e = e.parentElement) {
    const c = channels(getComputedStyle(e).backgroundColor);
    if (c.length === 3 || c[3] > 0.5) return c;
  } return [255, 255, 255]; };
  let worst = [99, ""];
  for (const e of document.body.querySelectorAll("*")) {
    if (e.closest("svg") || ![...e.childNodes].some(n => n.nodeType === 3 && n.data.trim())) continue;
    const pair = [luminance(channels(getComputedStyle(e).color)), luminance(ground(e))].sort((a, b) => b - a);
    const ratio = (pair[0] + 0.05) / (pair[1] + 0.05);
    if (ratio < worst[0]) worst = [ratio, e.outerHTML.slice(0, 120)];
  }
  return worst;
}"""


@pytest.fixture(scope="module", params=[pytest.param(subject, id=subject.name) for subject in SUBJECTS])
def report(
    request: pytest.FixtureRequest, browser: Any, tmp_path_factory: pytest.TempPathFactory
) -> tuple[ReportSubject, Path]:
    """A report, as its command writes it."""
    assert browser.is_connected()  # asked for first: without a browser nothing is computed
    subject: ReportSubject = request.param
    folder = tmp_path_factory.mktemp(subject.name)
    for name, text in subject.files.items():
        (folder / name).write_text(text, "utf-8")
    for command in subject.commands:
        done = subprocess.run(
            [sys.executable, "-m", "musclewire", *command],
            check=False, capture_output=True, text=True, timeout=600, cwd=folder,
        )  # fmt: skip
        assert done.returncode in {0, 1}, done.stderr  # 1 where a row of the paper fails; the page is there
    return subject, next(folder.rglob("re*.html"))


@contextmanager
def opened(browser: Any, path: Path, size: str, scheme: str) -> Iterator[Any]:
    """Open a page that may ask for nothing else."""
    width, height = SIZES[size]
    touch = {"has_touch": True, "is_mobile": True} if size == "phone" else {}
    context = browser.new_context(
        viewport={"width": width, "height": height}, color_scheme=scheme, offline=True, **touch
    )
    page = context.new_page()
    page.goto(path.as_uri())
    yield page
    context.close()


@pytest.mark.browser
@pytest.mark.parametrize("size", ["phone", "screen"])
def test_no_report_scrolls_sideways(report: tuple[ReportSubject, Path], size: str, browser: Any) -> None:
    with opened(browser, report[1], size, "light") as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= SIZES[size][0]
        assert page.evaluate(STICKING_OUT) == []


@pytest.mark.browser
@pytest.mark.parametrize("size", ["phone", "screen"])
def test_every_figure_is_there_and_has_size(report: tuple[ReportSubject, Path], size: str, browser: Any) -> None:
    subject, path = report
    with opened(browser, path, size, "light") as page:
        assert page.evaluate(SHOWN) >= subject.figures


@pytest.mark.browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_is_told_from_its_ground(report: tuple[ReportSubject, Path], scheme: str, browser: Any) -> None:
    with opened(browser, report[1], "phone", scheme) as page:
        ratio, where = page.evaluate(WORST_CONTRAST)
        assert ratio >= 4.5, where  # WCAG 2.2, success criterion 1.4.3
        ground = page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert ground == {"light": "rgb(244, 245, 247)", "dark": "rgb(16, 16, 16)"}[scheme]
        turned = page.evaluate("getComputedStyle(document.querySelector('svg')).filter")
        assert (turned == "none") == (scheme == "light")
