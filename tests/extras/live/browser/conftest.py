"""One server and one model for all tests of the live page that do not need their own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.extras.live.browser.opened import opened, switch_on
from tests.extras.live.browser.served import Served, serving

import musclewire as mw


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> None:
    """Add to a failure what the bench said last: why a run has ended stands there alone."""
    served = getattr(item, "funcargs", {}).get("served")
    if served is None or call.excinfo is None or call.excinfo.errisinstance(pytest.skip.Exception):
        return
    try:
        call.excinfo.value.add_note(served.said())
    except OSError as trouble:
        call.excinfo.value.add_note(f"The bench does not answer: {trouble}")


@pytest.fixture(scope="session")
def model() -> mw.SensingModel:
    """The model of the simulated wire."""
    with mw.open_rig("simulated", seed=3) as rig:
        return mw.fit(mw.characterize(rig))


@pytest.fixture(scope="session")
def served(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server whose session has a model in its folder. It needs a browser, so without one nothing is started."""
    request.getfixturevalue("browser")
    model = request.getfixturevalue("model")
    folder: Path = tmp_path_factory.mktemp("live") / "session"
    folder.mkdir()
    model.save(folder / "model.json")
    with serving(folder, "--seed", "3") as served:
        yield served


@pytest.fixture
def page(browser: Any, served: Served) -> Iterator[Any]:
    """The page, with the bench at rest and a model taken."""
    with opened(browser, served.link) as page:
        switch_on(page, served)
        yield page
    served.stop()
