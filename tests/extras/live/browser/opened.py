"""The live page in a real Chromium by Playwright: how it is opened, and what people do on it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.browser.chromium import SIZES
from tests.extras.live.browser.served import MAX_WAIT_S, Served, until

__all__ = ["Page", "command", "follow_slider", "opened", "phase_of", "switch_on", "wait_for_phase"]

Page = Any  # playwright.sync_api.Page, which is not there everywhere
LOOKS = Path(__file__).with_name("looks.js")


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
