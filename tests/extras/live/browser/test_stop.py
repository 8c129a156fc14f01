"""Stop: by the button, by Escape wherever the keyboard is, by who only watches, over whichever way still works."""

from __future__ import annotations

import time
from typing import Any

import pytest
from tests.extras.live.browser.opened import follow_slider, opened, wait_for_phase
from tests.extras.live.browser.served import Served

# The bars, 150 ms from the click and 20 ms in the rig, are those of benchmarks/live_page.py --stop.
MAX_STOP_S = 2.0


def by_click(page: Any) -> None:
    page.locator("#stop").click()


def by_space(page: Any) -> None:
    page.locator("#stop").focus()
    page.keyboard.press("Space")


def by_escape(page: Any) -> None:
    page.keyboard.press("Escape")


def by_escape_in_a_field(page: Any) -> None:
    page.locator('[data-part="slider-number"]').focus()
    page.keyboard.press("Escape")


def by_escape_in_a_list(page: Any) -> None:
    page.locator('[data-part="window"]').focus()
    page.keyboard.press("Escape")


@pytest.mark.browser
@pytest.mark.parametrize("way", [by_click, by_space, by_escape, by_escape_in_a_field, by_escape_in_a_list])
def test_a_stop_switches_the_drive_off(way: Any, page: Any, served: Served) -> None:
    follow_slider(page, served)
    began_s = time.monotonic()
    way(page)
    state = served.until_phase("stopped", max_wait_s=MAX_STOP_S)
    print(f"stopped {time.monotonic() - began_s:.3f} s after the press")
    assert "stopped by" in state["why"]
    wait_for_phase(page, "stopped")
    assert "DRIVE OFF" in page.locator("#stop").inner_text()
    assert state["why"].lower() in page.locator('[data-part="verdict"]').inner_text().lower()


@pytest.mark.browser
def test_who_only_watches_may_stop(page: Any, served: Served, browser: Any) -> None:
    follow_slider(page, served)
    with opened(browser, served.link) as watcher:
        assert watcher.locator('[data-part="slider"]').is_disabled()
        watcher.locator("#stop").click()
        state = served.until_phase("stopped", max_wait_s=MAX_STOP_S)
        assert "viewer" in state["why"]
    wait_for_phase(page, "stopped")


@pytest.mark.browser
def test_a_stop_ends_what_was_to_come_after(page: Any, served: Served) -> None:
    """The slow loop is followed by a fit; after a stop meanwhile nothing begins by itself."""
    page.get_by_role("radio", name="Slow loop").check()
    page.get_by_role("button", name="Record the loop and fit").click()
    wait_for_phase(page, "busy")
    page.keyboard.press("Escape")
    served.until_phase("stopped", max_wait_s=MAX_STOP_S)
    time.sleep(1.5)  # the page waits for a bench that is ready again for 0.7 s
    assert served.phase == "stopped"


@pytest.mark.browser
def test_a_stop_without_a_server_says_that_it_is_not_confirmed(page: Any) -> None:
    page.context.set_offline(True)
    page.route("**/stop", lambda route: route.abort())
    page.evaluate("WebSocket.prototype.send = () => {}")  # the line is cut, and nobody has noticed yet
    page.keyboard.press("Escape")
    page.wait_for_selector('#stop[data-state="unconfirmed"]')
    assert "NOT CONFIRMED" in page.locator("#stop").inner_text()
