"""Two people at one bench: one controls, the other watches, asks, is refused, asks again and is given control."""

from __future__ import annotations

from typing import Any

import pytest
from tests.extras.live.browser.opened import follow_slider, opened
from tests.extras.live.browser.served import Served, until


def text_of(page: Any, part: str) -> str:
    """Return the text of a part of the page."""
    return str(page.locator(f'[data-part="{part}"]').inner_text())


@pytest.mark.browser
def test_control_is_asked_for_and_given(page: Any, served: Served, browser: Any) -> None:
    follow_slider(page, served)
    with opened(browser, served.link) as watcher:
        me = served.holder
        until(lambda: me in text_of(watcher, "holder"), "the holder's name on the watcher's page")
        assert watcher.locator('[data-part="slider"]').is_disabled()
        assert watcher.locator('[data-part="end"]').is_disabled()
        ask = watcher.locator('[data-part="ask"]')
        ask.click()
        asked = page.locator('[data-part="asked"]')
        asked.wait_for(state="visible")
        assert served.holder == me  # asking takes nothing away
        page.locator('[data-part="keep"]').click()
        asked.wait_for(state="hidden")
        assert served.holder == me
        ask.click()
        asked.wait_for(state="visible")
        page.locator('[data-part="give"]').click()
        watcher.wait_for_selector('[data-part="slider"]:not([disabled])')
        assert served.phase == "busy"  # what runs goes on in other hands
        page.wait_for_selector('[data-part="slider"][disabled]')
        until(lambda: served.holder not in (None, me), "another holder")
        watcher.locator('[data-part="slider"]').press("ArrowRight")
        moved_to = watcher.locator('[data-part="slider"]').input_value()
        shown = page.locator('[data-part="slider"]')
        until(lambda: abs(float(shown.input_value()) - float(moved_to)) < 1e-6, "the watcher's slider moves along")
