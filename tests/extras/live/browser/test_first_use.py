"""First use: from ``musclewire serve`` to a wire that follows the slider, clicking what the page itself offers next.

The same walk takes the pictures of the tutorial.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from tests.extras.live.browser.opened import opened, wait_for_phase
from tests.extras.live.browser.pictures import FOLDER, Pictures
from tests.extras.live.browser.served import Served, serving, until
from tests.places import DOCS

MAX_CLICKS = 6
GRAIN_PCT = 0.011  # a step of the slider
# The pictures that are taken before a button of the guide is pressed.
SEEN_BEFORE = {"Switch on and check the wiring": "1_wire_it_up", "Warm the wire for 1 s": "2_safe_limits"}
# How near the wire must come to where the slider was moved, as the mean over half a second of the true strain.
MAX_ERROR_PCT, MEAN_ROWS, KEYS = 0.15, 10, 60
TUTORIAL = DOCS / "tutorials" / "the_live_page.md"
BUTTON = '[data-part="steps"] button.primary:not([disabled])'
MAX_PICTURE_BYTES = 200_000


def comes_to(served: Served, target_pct: float) -> None:
    """Wait until the mean of the wire's true strain has come to a target [%]."""
    rows, seen = served.rows(), []
    leg_m = served.state["rig"]["leg_length_m"]

    def near() -> bool:
        seen.extend(100.0 * row["displacement_m"] / leg_m for row in rows.new())  # type: ignore[operator]
        last = seen[-MEAN_ROWS:]
        return len(last) == MEAN_ROWS and abs(sum(last) / MEAN_ROWS - target_pct) < MAX_ERROR_PCT

    until(near, f"a strain of {target_pct:.2f} %")


def walk(page: Any, served: Served, pictures: Pictures) -> None:
    """Click the guide's next button until a loop follows the slider."""
    clicked: list[str] = []
    while not is_steering(served):
        if page.locator(BUTTON).count():
            clicked.append(str(page.locator(BUTTON).inner_text()))
            if clicked[-1] in SEEN_BEFORE:
                pictures.see(page, SEEN_BEFORE[clicked[-1]])
            page.locator(BUTTON).click()
        elif "slow loop" in "".join(clicked[-1:]) and "3_slow_loop" not in pictures.seen and served.phase == "busy":
            page.wait_for_timeout(1500.0)
            pictures.see(page, "3_slow_loop")
        assert len(clicked) <= MAX_CLICKS, (clicked, served.state["messages"])
        page.wait_for_timeout(50.0)


def slider_at_target(page: Any, served: Served) -> float | None:
    """Return where the slider is once that is the target of the newest row [%]."""
    at_pct = float(page.locator('[data-part="slider"]').input_value())
    target_pct = 100.0 * served.rows().wait()[-1]["target_strain"]
    return at_pct if abs(at_pct - target_pct) < GRAIN_PCT else None


def is_steering(served: Served) -> bool:
    """Return whether a steered loop runs."""
    doing = served.state["doing"]
    return doing is not None and bool(doing["steering"])


@pytest.mark.browser
def test_a_newcomer_has_a_wire_that_follows_the_slider(browser: Any, tmp_path: Path) -> None:
    pictures = Pictures()
    with (
        serving(tmp_path / "session", "--seed", "3") as served,
        opened(browser, served.link, "tutorial", color_scheme="light", reduced_motion="reduce") as page,
    ):
        walk(page, served, pictures)
        page.wait_for_selector('[data-part="slider"]:not([disabled]):focus')  # it has the keyboard by itself
        slider = page.locator('[data-part="slider"]')
        before_pct = float(until(lambda: slider_at_target(page, served), "the slider where the loop began"))
        comes_to(served, before_pct)
        for _ in range(KEYS):
            page.keyboard.press("ArrowRight")
        target_pct = float(slider.input_value())
        assert target_pct - before_pct > 3.0 * MAX_ERROR_PCT
        comes_to(served, target_pct)
        pictures.see(page, "4_follow_the_slider")
        page.keyboard.press("Escape")
        wait_for_phase(page, "stopped")
        page.wait_for_selector('#stop[data-state="off"]')
        pictures.see(page, "5_stopped")
        assert page.evaluate("looks.clicks") <= MAX_CLICKS
    assert pictures.seen == pictures_of_the_tutorial()


def pictures_of_the_tutorial() -> set[str]:
    """Return the names of the live page's pictures in the tutorial."""
    return set(re.findall(r"\(\.\./images/live_page/(\w+)\.png\)", TUTORIAL.read_text("utf-8")))


def test_the_pictures_of_the_tutorial_are_there_and_small() -> None:
    assert pictures_of_the_tutorial() == {path.stem for path in FOLDER.glob("*.png")}
    for path in FOLDER.glob("*.png"):
        assert path.stat().st_size <= MAX_PICTURE_BYTES
        with Image.open(path) as picture:
            assert picture.size == (1440, 1000)
