"""One Playwright and one Chromium for all tests in a browser: a process can start only one of the first."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

# Debian's Chromium. What a root user's sandbox or a small /dev/shm would break is no subject here.
FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--no-first-run"),
]
SIZES = {"phone": (390, 844), "tablet": (1024, 768), "screen": (1920, 1080), "tutorial": (1440, 1000)}


def missing(line: str) -> None:
    """Skip, saying that the test was not run and what it needs; where a browser is required, fail."""
    if os.environ.get("MUSCLEWIRE_REQUIRE_BROWSER"):
        pytest.fail(line, pytrace=False)
    pytest.skip(f"not run: {line}")


def chromium_path() -> str:
    """Return the path of Chromium, or skip."""
    names = ("chromium", "chromium-browser", "google-chrome")
    path = next((found for name in names if (found := shutil.which(name))), None)
    if path is None:
        missing("needs Chromium (apt-get install --no-install-recommends chromium)")
    return str(path)


def require_playwright() -> Any:
    """Return Playwright's synchronous interface, or skip."""
    try:
        from playwright import sync_api
    except ImportError:
        missing("needs Playwright (pip install 'musclewire[test]'); its own browsers are not needed")
    return sync_api


@contextmanager
def started(playwright: Any, *flags: str) -> Iterator[Any]:
    """Start Chromium, and end it."""
    chromium = playwright.chromium.launch(executable_path=chromium_path(), args=[*FLAGS, *flags])
    yield chromium
    chromium.close()


@contextmanager
def launched(*flags: str) -> Iterator[Any]:
    """Start Chromium."""
    with require_playwright().sync_playwright() as interface, started(interface, *flags) as chromium:
        yield chromium


@pytest.fixture(scope="session")
def playwright() -> Iterator[Any]:
    """Playwright, with a Chromium to start."""
    chromium_path()
    with require_playwright().sync_playwright() as interface:
        yield interface


@pytest.fixture(scope="session")
def browser(playwright: Any) -> Iterator[Any]:
    """A Chromium."""
    with started(playwright) as chromium:
        yield chromium
