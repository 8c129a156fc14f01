"""The keyboard alone: every action of the page is reached, visibly, and does what it does for a pointer.

Which actions there are is asked of the page itself, so that a new one is not forgotten.
"""

from __future__ import annotations

from typing import Any

import pytest
from tests.extras.live.browser.opened import opened, wait_for_phase
from tests.extras.live.browser.served import Served, until

# Elements that hear a pointer and that no keyboard reaches.
POINTER_EVENTS = {"click", "mousedown", "mouseup", "pointerdown", "pointerup", "touchstart", "touchend", "dblclick"}
# uPlot's own layers hear the pointer for its cursor, which is no action.
WITHOUT_KEYBOARD = """function () {
  if (this.closest(".uplot") || this.matches("a[href], button, input, select, summary, form, [tabindex]")) return "";
  return this.cloneNode(false).outerHTML;
}"""
MAX_TABS = 200


def actions(page: Any) -> dict[str, str]:
    """Return the actions of the page, by their number, with their names."""
    return dict(page.evaluate("looks.actions()"))


def tab_through(page: Any) -> list[str]:
    """Return the actions in the order of Tab; each must show that it has the keyboard."""
    page.evaluate("looks.fromTheTop()")
    reached: list[str] = []
    for _ in range(MAX_TABS):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement === document.body"):
            break
        now = page.evaluate("looks.focused()")
        if now["action"] in reached:
            break
        if now["action"] is not None:
            reached.append(now["action"])
        assert now["differs"], f"nothing shows that this has the keyboard: {now['name']}"
        assert now["inside"], f"this has the keyboard and is out of sight: {now['name']}"
    return reached


def check_reach(page: Any) -> None:
    """Assert that Tab reaches every action."""
    there = actions(page)
    reached = tab_through(page)
    missed = {name for number, name in there.items() if number not in reached}
    assert not missed, f"not reached by Tab: {missed}"
    assert len(there) > 5


def pointer_only(page: Any) -> list[str]:
    """Return the elements that listen to a pointer, and that neither are nor hold what has the keyboard's focus."""
    session = page.context.new_cdp_session(page)
    session.send("DOM.enable")
    session.send("Runtime.enable")
    everything = session.send("Runtime.evaluate", {"expression": "[...document.querySelectorAll('body *')]"})
    list_of_all = {"objectId": everything["result"]["objectId"], "ownProperties": True}
    properties = session.send("Runtime.getProperties", list_of_all)
    found = []
    for one in properties["result"]:
        if not one["name"].isdigit():
            continue
        node = one["value"]["objectId"]
        heard = {
            each["type"] for each in session.send("DOMDebugger.getEventListeners", {"objectId": node})["listeners"]
        }
        if heard & POINTER_EVENTS:
            asked = {"objectId": node, "functionDeclaration": WITHOUT_KEYBOARD, "returnByValue": True}
            text = session.send("Runtime.callFunctionOn", asked)["result"]["value"]
            found += [text] if text else []
    return found


@pytest.mark.browser
def test_tab_reaches_every_action_in_every_state(page: Any, served: Served, browser: Any) -> None:
    check_reach(page)
    for details in page.locator("details:not([open]) > summary").all():
        if details.is_visible():
            details.press("Enter")
    check_reach(page)
    for kind in page.get_by_role("radio").all():
        kind.check()
        check_reach(page)
    by_keyboard(page, '[data-part="steer"]', "Enter")
    page.wait_for_selector('[data-part="slider"]:not([disabled])')
    check_reach(page)
    with opened(browser, served.link) as watcher:
        check_reach(watcher)
        by_keyboard(watcher, '[data-part="ask"]', "Space")
        page.locator('[data-part="asked"]').wait_for(state="visible")
        check_reach(page)
        by_keyboard(page, '[data-part="give"]', "Enter")
        watcher.wait_for_selector('[data-part="slider"]:not([disabled])')
    served.stop()
    wait_for_phase(page, "stopped")
    check_reach(page)


def by_keyboard(page: Any, selector: str, key: str) -> None:
    """Go to an element by Tab and press a key."""
    wanted = page.locator(selector)
    wanted.wait_for(state="visible")
    page.evaluate("looks.fromTheTop()")
    for _ in range(MAX_TABS):
        page.keyboard.press("Tab")
        if wanted.evaluate("one => one === document.activeElement"):
            page.keyboard.press(key)
            return
    raise AssertionError(f"Tab does not reach {selector}")


@pytest.mark.browser
def test_nothing_hears_a_pointer_alone(page: Any) -> None:
    """A canvas on which one draws has a table of points next to it; everything else must have the keyboard's focus."""
    page.get_by_role("radio", name="Drawn path").check()
    only = pointer_only(page)
    assert all("canvas" in one and "table below" in one for one in only), only  # its label names the other way
    assert len(only) == 1


@pytest.mark.browser
def test_a_wire_is_moved_by_the_keyboard_alone(page: Any, served: Served) -> None:
    by_keyboard(page, '[data-part="steer"]', "Enter")
    page.wait_for_selector('[data-part="slider"]:not([disabled])')
    slider = page.locator('[data-part="slider"]')
    until(lambda: slider.evaluate("one => one === document.activeElement"), "the slider has the keyboard")
    rows, before = served.rows(), float(slider.input_value())
    page.keyboard.press("PageUp")
    page.keyboard.press("ArrowRight")
    target_pct = float(slider.input_value())
    assert target_pct > before
    until(
        lambda: any(abs(100.0 * row["target_strain"] - target_pct) < 1e-6 for row in rows.new()),
        "the target of the rows",
    )
    by_keyboard(page, '[data-part="end"]', "Enter")
    wait_for_phase(page, "ready")
    assert not served.is_heating()


@pytest.mark.browser
def test_a_run_is_chosen_written_and_started_by_the_keyboard(page: Any, served: Served) -> None:
    page.get_by_role("radio", name="Slider").check()
    by_keyboard(page, 'input[type="radio"]:checked', "ArrowRight")
    page.keyboard.press("ArrowRight")
    until(lambda: page.get_by_role("radio", name="Sine").is_checked(), "the sine is chosen")
    by_keyboard(page, 'input[name="period_s"]', "ControlOrMeta+a")
    page.keyboard.type("8")
    page.keyboard.press("Enter")
    wait_for_phase(page, "busy")
    state = served.state
    assert state["doing"]["experiment"] == "control"
    assert state["doing"]["duration_s"] < 60.0  # three cycles of 8 s after the approach
    by_keyboard(page, '[data-part="end"]', "Space")
    wait_for_phase(page, "ready")


@pytest.mark.browser
def test_a_path_is_written_by_the_keyboard(page: Any, served: Served) -> None:
    page.get_by_role("radio", name="Drawn path").check()
    page.locator("details", has_text="Points as a table").locator("summary").press("Enter")
    rows_before = page.locator(".points tbody tr").count()
    by_keyboard(page, "details .quiet:has-text('Add a point')", "Enter")
    assert page.locator(".points tbody tr").count() == rows_before + 1
    page.locator('[data-part="run-form"] button[type="submit"]').press("Enter")
    wait_for_phase(page, "busy")
    served.stop()
