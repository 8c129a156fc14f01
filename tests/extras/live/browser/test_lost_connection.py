"""Whoever has control is lost, in every way we could think of: the run ends and the wire is at its sense voltage."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.browser.chromium import started
from tests.extras.live.browser.cable import cable_to
from tests.extras.live.browser.long_lease import LONGER_BY_S
from tests.extras.live.browser.opened import follow_slider, opened, switch_on
from tests.extras.live.browser.served import Served, serving, until

import musclewire as mw

# With a user's lease; the bar, 1 s, is that of benchmarks/live_page.py --stop.
MAX_SAFE_S = 3.0
# Where only the lease ends a run, and it is the longer one of tests.
MAX_SAFE_LATE_S = MAX_SAFE_S + LONGER_BY_S
FREEZE = "setTimeout(() => { const end = performance.now() + 6000; while (performance.now() < end); }, 0)"


def close_tab(page: Any) -> None:
    page.close()


def leave_page(page: Any) -> None:
    page.goto("about:blank")


def freeze(page: Any) -> None:
    page.evaluate(FREEZE)


LOSSES = [(close_tab, MAX_SAFE_S), (leave_page, MAX_SAFE_S), (freeze, MAX_SAFE_LATE_S)]


def ends_safely(served: Served, lose: Callable[[], None], max_safe_s: float) -> dict[str, Any]:
    """Lose whoever has control; the run must end, and its rows be kept."""
    recorded = {one["name"] for one in served.state["recordings"]}
    began_s = time.monotonic()
    lose()
    took_s = served.until_safe(began_s, max_safe_s)
    print(f"safe {took_s:.2f} s after the loss")
    until(lambda: served.holder is None, "nobody in control", max_wait_s=MAX_SAFE_S)
    state = served.until_phase("ready", "stopped", max_wait_s=MAX_SAFE_S)
    assert {one["name"] for one in state["recordings"]} - recorded
    return state


@pytest.mark.browser
@pytest.mark.parametrize(("loss", "max_safe_s"), LOSSES)
def test_a_page_that_is_gone_ends_its_run(loss: Any, max_safe_s: float, served: Served, browser: Any) -> None:
    with opened(browser, served.link) as page:
        switch_on(page, served)
        follow_slider(page, served)
        ends_safely(served, lambda: loss(page), max_safe_s)
    served.stop()


@pytest.mark.browser
def test_a_cable_that_is_pulled_ends_the_run_by_the_lease_that_users_have(
    model: mw.SensingModel, browser: Any, tmp_path: Path
) -> None:
    folder = tmp_path / "session"
    folder.mkdir()
    model.save(folder / "model.json")
    with (
        serving(folder, "--seed", "3", program=("-m", "musclewire")) as served,
        cable_to(served.link) as cable,
        opened(browser, cable.link) as page,
    ):
        switch_on(page, served)
        follow_slider(page, served)
        ends_safely(served, cable.pull, MAX_SAFE_S)
        page.wait_for_selector('#connection[data-state="lost"]')  # and the page says so: what it shows is old
        assert "CONNECTION LOST" in page.locator("#lost").inner_text()


@pytest.fixture
def renderers(playwright: Any) -> Iterator[tuple[Any, Callable[[int], None]]]:
    """A browser of its own, and a way to send a signal to all processes that draw its pages."""
    with started(playwright) as browser:
        session = browser.new_browser_cdp_session()

        def send(number: int) -> None:
            for one in session.send("SystemInfo.getProcessInfo")["processInfo"]:
                if one["type"] == "renderer":
                    os.kill(int(one["id"]), number)

        yield browser, send


@pytest.mark.browser
def test_a_browser_that_is_held_ends_the_run(served: Served, renderers: Any) -> None:
    browser, send = renderers
    with opened(browser, served.link) as page:
        switch_on(page, served)
        follow_slider(page, served)
        try:
            ends_safely(served, lambda: send(signal.SIGSTOP), MAX_SAFE_LATE_S)
        finally:
            send(signal.SIGCONT)
        page.wait_for_selector('#connection[data-state="open"]')  # it wakes, and has no control any more
        until(lambda: page.locator('[data-part="slider"]').is_disabled(), "a slider that nobody can move")
    served.stop()
