"""The pictures of the tutorial: taken by the tests, and compared by what a reader finds on them, not by pixels.

``MUSCLEWIRE_TAKE_PICTURES=1`` writes them anew, with what is on them; without it, what the page shows must be what the
committed pictures show. Numbers are left out of the comparison: they differ from run to run.
"""

from __future__ import annotations

import io
import json
import os
from typing import Any

from PIL import Image
from tests.places import DOCS

__all__ = ["FOLDER", "LANDMARKS", "Pictures"]

FOLDER = DOCS / "images" / "live_page"
LANDMARKS = FOLDER / "landmarks.json"
SETTLES_S = 10  # a busy machine draws the page's parts one after the other
COLOURS = 96  # a page of text and lines needs no more, and each picture stays near 100 kB


class Pictures:
    """Takes pictures, or compares what is on them."""

    def __init__(self) -> None:
        """Read what is on the committed pictures."""
        self.takes = bool(os.environ.get("MUSCLEWIRE_TAKE_PICTURES"))
        self._shown: dict[str, list[str]] = {} if self.takes else json.loads(LANDMARKS.read_text("utf-8"))
        self.seen: set[str] = set()

    def see(self, page: Any, name: str) -> None:
        """Take a picture of what is in sight, or assert that the committed one shows the same."""
        page.evaluate("scrollTo(0, 0)")  # a click may have scrolled, or not
        shown = self._at_rest(page) if self.takes else self._settled(page, name)
        self.seen.add(name)
        if self.takes:
            self._shown[name] = shown
            FOLDER.mkdir(exist_ok=True)
            picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
            picture.quantize(COLOURS, dither=Image.Dither.NONE).save(FOLDER / f"{name}.png", optimize=True)
            LANDMARKS.write_text(json.dumps(self._shown, indent=1, ensure_ascii=False) + "\n", "utf-8")
            return
        new = "take the pictures again: MUSCLEWIRE_TAKE_PICTURES=1 python -m pytest tests/extras/live/browser -k first"
        gone = [one for one in self._shown[name] if one not in shown]
        added = [one for one in shown if one not in self._shown[name]]
        assert not gone, f"{name}: no longer on the page: {gone}; {new}"
        assert not added, f"{name}: new on the page: {added}; {new}"

    def _at_rest(self, page: Any) -> list[str]:
        """Return what is on the page once nothing has come or gone for a second: the first values change its layout."""
        shown: list[str] = page.evaluate("looks.landmarks()")
        for _ in range(SETTLES_S):
            page.wait_for_timeout(1000.0)
            before, shown = shown, page.evaluate("looks.landmarks()")
            if shown == before:
                break
        return shown

    def _settled(self, page: Any, name: str) -> list[str]:
        """Return what is on the page, as soon as that is what the picture shows, or after a while."""
        shown: list[str] = page.evaluate("looks.landmarks()")
        for _ in range(SETTLES_S * 10):
            if set(shown) == set(self._shown[name]):
                break
            page.wait_for_timeout(100.0)
            shown = page.evaluate("looks.landmarks()")
        return shown
