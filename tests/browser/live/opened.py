"""The live page in a real Chromium by Playwright: how it is opened, and what people do on it."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from tests.browser.live.served import MAX_WAIT_S, Served, until

__all__ = [
    "FLAGS",
    "SIZES",
    "Page",
    "chromium_path",
    "command",
    "follow_slider",
    "launched",
    "missing",
    "opened",
    "phase_of",
    "require_playwright",
    "started",
    "switch_on",
    "wait_for_phase",
]

# Debian's Chromium. What a root user's sandbox or a small /dev/shm would break is no subject here.
FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--no-first-run"),
]
SIZES = {"phone": (390, 844), "tablet": (1024, 768), "screen": (1920, 1080), "tutorial": (1440, 1000)}
Page = Any  # playwright.sync_api.Page, which is not there everywhere
LOOKS = Path(__file__).with_name("looks.js")


def missing(line: str) -> None:
    """Skip, saying that the test was not run and what it needs; where a browser is required, fail."""
    if os.environ.get("MUSCLEWIRE_REQUIRE_BROWSER"):
        pytest.fail(line, pytrace=False)
    pytest.skip(f"not run: {line}")


def chromium_path() -> str:
    """Return the path of Chromium, or skip."""
    names = ("chromium", "chromium-browser", "google-chrome")
    path = next((found for name in names if (found := shutil.which(name))), None)
    if path is None:
        missing("needs Chromium (apt-get install --no-install-recommends chromium)")
    return str(path)


def require_playwright() -> Any:
    """Return Playwright's synchronous interface, or skip."""
    try:
        from playwright import sync_api
    except ImportError:
        missing("needs Playwright (pip install 'musclewire[test]'); its own browsers are not needed")
    return sync_api


@contextmanager
def started(playwright: Any, *flags: str) -> Iterator[Any]:
    """Start Chromium, and end it."""
    browser = playwright.chromium.launch(executable_path=chromium_path(), args=[*FLAGS, *flags])
    yield browser
    browser.close()


@contextmanager
def launched(*flags: str) -> Iterator[Any]:
    """Start Chromium."""
    with require_playwright().sync_playwright() as playwright, started(playwright, *flags) as browser:
        yield browser


@contextmanager
def opened(browser: Any, url: str, size: str = "screen", **settings: Any) -> Iterator[Page]:
    """Open the page in a context of its own and wait until it shows the bench; no error may come up meanwhile."""
    width, height = SIZES[size]
    context = browser.new_context(viewport={"width": width, "height": height}, **settings)
    context.set_default_timeout(1e3 * MAX_WAIT_S)
    context.add_init_script(path=LOOKS)
    page, errors = context.new_page(), []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(url)
    page.wait_for_selector("section.wire[data-phase]")
    try:
        yield page
    finally:
        context.close()
    assert not errors, errors


def phase_of(page: Page) -> str:
    """Return the phase that the page shows."""
    return str(page.locator("section.wire").get_attribute("data-phase"))


def wait_for_phase(page: Page, phase: str) -> None:
    """Wait until the page shows a phase."""
    page.wait_for_selector(f'section.wire[data-phase="{phase}"]')


def switch_on(page: Page, served: Served) -> None:
    """Bring the bench to rest with a model, by the page's own connection: what is tested comes after."""
    ask = page.locator('[data-part="ask"]')
    if ask.inner_text() == "Give it up":
        ask.click()
    until(lambda: served.holder is None, "nobody in control")
    if served.phase in ("off", "stopped", "failed"):
        command(served, {"do": "switch_on"})
    if served.state["model"] is None:
        command(served, {"do": "load_model", "name": "model.json"})
    wait_for_phase(page, "ready")


def command(served: Served, what: dict[str, Any]) -> None:
    """Send a command over the API, with a lease of its own."""
    lease = served.request("benches/simulated/control", {"name": "a test"})["lease"]
    try:
        served.request("benches/simulated/commands", what, Musclewire_Lease=lease)
    finally:
        served.request("benches/simulated/control", method="DELETE", Musclewire_Lease=lease)


def follow_slider(page: Page, served: Served) -> None:
    """Begin a loop that follows the slider, and wait until the slider can be moved."""
    page.locator('[data-part="steer"]').click()
    page.wait_for_selector('[data-part="slider"]:not([disabled])')
    until(served.is_heating, "a wire that is heated")
