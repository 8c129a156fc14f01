"""One Playwright and one Chromium for all tests in a browser: a process can start only one of the first."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from tests.browser.live.opened import chromium_path, require_playwright, started


@pytest.fixture(scope="session")
def playwright() -> Iterator[Any]:
    """Playwright, with a Chromium to start."""
    chromium_path()
    with require_playwright().sync_playwright() as playwright:
        yield playwright


@pytest.fixture(scope="session")
def browser(playwright: Any) -> Iterator[Any]:
    """A Chromium."""
    with started(playwright) as browser:
        yield browser
