"""First use: from ``musclewire serve`` to a wire that follows the slider, clicking what the page itself offers next."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest
from tests.browser.live.opened import opened
from tests.browser.live.served import Rows, Served, serving, until

MAX_S, MAX_CLICKS = 90.0, 6
# The noise of one estimate; and how near the wire must come to where the slider was moved.
MAX_ERROR_PCT = 0.15
MOVES = ("ArrowRight", "ArrowLeft")


def click_next(page: Any) -> str:
    """Click the one button of the guide, and return what is on it."""
    button = page.locator('[data-part="steps"] button.primary:not([disabled])')
    text = str(button.inner_text())
    button.click()
    return text


def strains_pct(rows: Rows, column: str) -> list[float]:
    """Return the values of a column of strains in the rows since the last time [%]."""
    return [100.0 * value for row in rows.new() if (value := row.get(column)) is not None]


def comes_to(served: Served, target_pct: float) -> float:
    """Return the mean of the wire's true strain over the half second in which it has come to a target [%]."""
    rows, seen = served.rows(), []
    state = served.state

    def near() -> float | None:
        for row in rows.new():
            seen.append(100.0 * row["displacement_m"] / state["rig"]["leg_length_m"])  # type: ignore[operator]
        last = seen[-10:]
        mean = sum(last) / max(len(last), 1)
        return mean if len(last) == 10 and abs(mean - target_pct) < MAX_ERROR_PCT else None

    return float(until(near, f"a strain of {target_pct:.2f} %", max_wait_s=30.0))


@pytest.mark.browser
def test_a_newcomer_has_a_wire_that_follows_the_slider(browser: Any, tmp_path: Path) -> None:
    started_s = time.monotonic()
    with serving(tmp_path / "session", "--seed", "3") as served:
        opened_s = time.monotonic()
        with opened(browser, served.url) as page:
            clicked: list[str] = []
            while not is_steering(served):
                until(lambda: guide_waits(page) or is_steering(served), "the guide's next step", max_wait_s=MAX_S)
                if guide_waits(page):
                    clicked.append(click_next(page))
            page.wait_for_selector('[data-part="slider"]:not([disabled]):focus')  # it has the keyboard by itself
            before_pct = float(page.locator('[data-part="slider"]').input_value())
            for _ in range(20):
                page.keyboard.press("ArrowRight")
            target_pct = float(page.locator('[data-part="slider"]').input_value())
            assert target_pct > before_pct
            reached_pct = comes_to(served, target_pct)
            now_s, clicks = time.monotonic(), page.evaluate("looks.clicks")
            print(f"first use: {now_s - opened_s:.1f} s after opening the page, {now_s - started_s:.1f} s after")
            print(f"'musclewire serve', {clicks} clicks ({'; '.join(clicked)}): from {before_pct:.2f} % to")
            print(f"{reached_pct:.2f} % for a target of {target_pct:.2f} %")
            assert clicks <= MAX_CLICKS
            assert now_s - started_s <= MAX_S


def guide_waits(page: Any) -> bool:
    """Return whether the guide offers a step."""
    return bool(page.locator('[data-part="steps"] button.primary:not([disabled])').count())


def is_steering(served: Served) -> bool:
    """Return whether a steered loop runs."""
    doing = served.state["doing"]
    return doing is not None and bool(doing["steering"])
