"""One Playwright and one Chromium for all tests in a browser: a process can start only one of the first."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from tests.tools import require_oracle, require_tool

# Debian's Chromium. What a root user's sandbox or a small /dev/shm would break is no subject here.
FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--no-first-run"),
]
SIZES = {"phone": (390, 844), "tablet": (1024, 768), "screen": (1920, 1080), "tutorial": (1440, 1000)}


def chromium_path() -> str:
    """Return the path of Chromium, or skip."""
    names = ("chromium", "chromium-browser", "google-chrome")
    path = next((found for name in names if (found := shutil.which(name))), None)
    return path or require_tool("chromium", "chromium")


@contextmanager
def started(playwright: Any, *flags: str) -> Iterator[Any]:
    """Start Chromium, and end it."""
    chromium = playwright.chromium.launch(executable_path=chromium_path(), args=[*FLAGS, *flags])
    yield chromium
    chromium.close()


@contextmanager
def launched(*flags: str) -> Iterator[Any]:
    """Start Chromium."""
    with require_oracle("playwright.sync_api").sync_playwright() as interface, started(interface, *flags) as chromium:
        yield chromium


@pytest.fixture(scope="session")
def playwright() -> Iterator[Any]:
    """Playwright, with a Chromium to start."""
    chromium_path()
    with require_oracle("playwright.sync_api").sync_playwright() as interface:
        yield interface


@pytest.fixture(scope="session")
def browser(playwright: Any) -> Iterator[Any]:
    """A Chromium."""
    with started(playwright) as chromium:
        yield chromium
