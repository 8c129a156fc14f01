"""Three sizes of screen: nothing sticks out, and the stop button is in sight, wherever one has scrolled."""

from __future__ import annotations

from typing import Any

import pytest
from tests.extras.live.browser.opened import follow_slider, opened, switch_on
from tests.extras.live.browser.served import Served

# A thumb needs so much (WCAG 2.2, target size, enhanced) [px].
MIN_STOP_PX = 44


def check(page: Any) -> None:
    """Assert that nothing sticks out, and that the stop button is visible at the top and at the bottom of the page."""
    assert page.evaluate("looks.stickingOut()") == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate("looks.cutOff()") == []
    for place in ("0", "document.documentElement.scrollHeight"):
        page.evaluate(f"scrollTo(0, {place})")
        stop = page.evaluate("looks.stop()")
        assert stop["inside"], stop
        assert stop["on_top"], stop
        assert min(stop["width"], stop["height"]) >= MIN_STOP_PX


@pytest.mark.browser
@pytest.mark.parametrize("size", ["phone", "tablet", "screen"])
def test_everything_fits_and_stop_is_visible(size: str, browser: Any, served: Served) -> None:
    touch = {"has_touch": True, "is_mobile": True} if size == "phone" else {}
    served.stop()
    with opened(browser, served.link, size, **touch) as page:
        check(page)  # off
        switch_on(page, served)
        check(page)
        for kind in page.get_by_role("radio").all():
            kind.check()
            check(page)
        for details in page.locator("details:not([open]) > summary").all():
            if details.is_visible():
                details.click()
        check(page)
        follow_slider(page, served)
        check(page)
        page.locator("#stop").click()
        page.wait_for_selector('section.wire[data-phase="stopped"]')
        check(page)
