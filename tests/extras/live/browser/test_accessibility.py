"""Labels, names, roles and contrast by axe-core, in both themes and in every state: nothing serious or critical."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.extras.live.browser.opened import opened, switch_on, wait_for_phase
from tests.extras.live.browser.served import Served, serving, until
from tests.tools import require_oracle

import musclewire as mw

GRAVE = ("serious", "critical")


@pytest.fixture(scope="module")
def axe() -> Any:
    """axe-core."""
    return require_oracle("axe_core_python.sync_playwright").Axe()


@pytest.fixture
def own_server(tmp_path: Path, model: mw.SensingModel) -> Iterator[Served]:
    """A server of its own, since its bench is broken at the end."""
    folder = tmp_path / "session"
    folder.mkdir()
    model.save(folder / "model.json")
    with serving(folder, "--seed", "3") as served:
        yield served


def check(axe: Any, page: Any, state: str, prepare: Callable[[], None] = lambda: None) -> None:
    """Assert that axe finds nothing grave, in both themes; ``prepare`` brings about the state before each.

    axe holds the page for longer than a lease on a small machine: what it sees is the state before, and what was
    running has then ended, as it must.
    """
    for theme in ("light", "dark"):
        prepare()
        page.emulate_media(color_scheme=theme, reduced_motion="reduce")
        result = axe.run(page)
        grave = [
            f"{one['id']}: {one['help']}: {node['html'][:160]} {node.get('failureSummary', '')[:300]}"
            for one in result["violations"]
            if one["impact"] in GRAVE
            for node in one["nodes"]
        ]
        assert not grave, f"{state}, {theme}:\n" + "\n".join(grave)
        assert len(result["passes"]) > 15  # it has really looked


def follow(page: Any, watcher: Any = None) -> None:
    """Have a loop that follows the slider: once more if it has ended meanwhile."""

    def follows() -> bool:
        if watcher is not None and watcher.locator('[data-part="ask"]').inner_text() == "Give it up":
            watcher.locator('[data-part="ask"]').click()
        if page.locator('[data-part="steer"]').is_visible() and page.locator('[data-part="steer"]').is_enabled():
            page.locator('[data-part="steer"]').click(timeout=1000)
        return page.locator('[data-part="slider"]').is_enabled()

    until(follows, "a loop that follows the slider", max_wait_s=240.0, pause_s=0.2)


def ask(page: Any, watcher: Any) -> None:
    """Let a watcher ask whoever moves the slider for control; one who got it meanwhile gives it up first."""
    follow(page, watcher)
    if page.locator('[data-part="asked"]').is_hidden():
        watcher.locator('[data-part="ask"]').click()
        page.locator('[data-part="asked"]').wait_for(state="visible")


def break_bench(served: Served) -> None:
    """Kill the rig's process."""
    pid = served.process.pid
    for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
        if b"musclewire.extras.live._bench" in Path(f"/proc/{child}/cmdline").read_bytes():
            os.kill(int(child), signal.SIGKILL)


@pytest.mark.browser
def test_axe_finds_nothing_grave(axe: Any, browser: Any, own_server: Served) -> None:
    with opened(browser, own_server.link) as page:
        check(axe, page, "off")
        switch_on(page, own_server)
        for details in page.locator("details:not([open]) > summary").all():
            if details.is_visible():
                details.click()
        check(axe, page, "ready")
        for kind in page.get_by_role("radio").all():
            kind.check()
            check(axe, page, f"ready, {kind.input_value()}")
        check(axe, page, "busy", lambda: follow(page))
        with opened(browser, own_server.link, "phone") as watcher:
            check(axe, page, "busy and asked for control", lambda: ask(page, watcher))
            check(axe, watcher, "watching on a phone", lambda: follow(page, watcher))
        page.keyboard.press("Escape")
        wait_for_phase(page, "stopped")
        check(axe, page, "stopped")
        break_bench(own_server)
        wait_for_phase(page, "failed")
        check(axe, page, "failed")
