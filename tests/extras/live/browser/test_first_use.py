"""First use: from ``musclewire serve`` to a wire that follows the slider, clicking what the page itself offers next.

The same walk takes the pictures of the tutorial.
"""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from tests.extras.live.browser.opened import opened, wait_for_phase
from tests.extras.live.browser.pictures import FOLDER, Pictures
from tests.extras.live.browser.served import Served, serving, until
from tests.places import DOCS

MAX_S, MAX_CLICKS = 90.0, 6
GRAIN_PCT = 0.011  # a step of the slider
# The pictures that are taken before a button of the guide is pressed.
SEEN_BEFORE = {"Switch on and check the wiring": "1_wire_it_up", "Warm the wire for 1 s": "2_safe_limits"}
# How near the wire must come to where the slider was moved, as the mean over half a second of the true strain.
MAX_ERROR_PCT, MEAN_ROWS, KEYS = 0.15, 10, 60
TUTORIAL = DOCS / "tutorials" / "the_live_page.md"
BUTTON = '[data-part="steps"] button.primary:not([disabled])'
MAX_PICTURE_BYTES = 200_000


def comes_to(served: Served, target_pct: float) -> float:
    """Return the mean of the wire's true strain once it has come to a target [%]."""
    rows, seen = served.rows(), []
    leg_m = served.state["rig"]["leg_length_m"]

    def near() -> float | None:
        seen.extend(100.0 * row["displacement_m"] / leg_m for row in rows.new())  # type: ignore[operator]
        last = seen[-MEAN_ROWS:]
        mean = sum(last) / max(len(last), 1)
        return mean if len(last) == MEAN_ROWS and abs(mean - target_pct) < MAX_ERROR_PCT else None

    return float(until(near, f"a strain of {target_pct:.2f} %", max_wait_s=30.0))


def walk(page: Any, served: Served, pictures: Pictures) -> list[str]:
    """Click the guide's next button until a loop follows the slider; return what was on the buttons."""
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
    return clicked


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
    pictures, started_s = Pictures(), time.monotonic()
    with serving(tmp_path / "session", "--seed", "3") as served:
        opened_s = time.monotonic()
        with opened(browser, served.url, "tutorial", color_scheme="light", reduced_motion="reduce") as page:
            clicked = walk(page, served, pictures)
            page.wait_for_selector('[data-part="slider"]:not([disabled]):focus')  # it has the keyboard by itself
            slider = page.locator('[data-part="slider"]')
            before_pct = float(until(lambda: slider_at_target(page, served), "the slider where the loop began"))
            comes_to(served, before_pct)
            for _ in range(KEYS):
                page.keyboard.press("ArrowRight")
            target_pct = float(slider.input_value())
            assert target_pct - before_pct > 3.0 * MAX_ERROR_PCT
            reached_pct = comes_to(served, target_pct)
            now_s, clicks = time.monotonic(), page.evaluate("looks.clicks")
            print(f"\nfirst use: {now_s - opened_s:.1f} s after opening the page, {now_s - started_s:.1f} s after")
            print(
                f"'musclewire serve', {clicks} clicks ({'; '.join(clicked)}): the slider went from {before_pct:.2f} %"
            )
            print(f"to {target_pct:.2f} %, and the wire to {reached_pct:.2f} %")
            pictures.see(page, "4_follow_the_slider")
            page.keyboard.press("Escape")
            wait_for_phase(page, "stopped")
            page.wait_for_selector('#stop[data-state="off"]')
            pictures.see(page, "5_stopped")
            assert clicks <= MAX_CLICKS
            assert now_s - started_s <= MAX_S
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
