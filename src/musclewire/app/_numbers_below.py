"""A progress bar with the numbers of the run in a line below it; loaded only where a terminal shows one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rich.console import RenderableType
from rich.progress import Progress, ProgressColumn
from rich.text import Text

from musclewire.app._live_numbers import LiveNumbers


class ProgressWithNumbers(Progress):
    """A bar, and below it the numbers of the last sample whenever it is drawn."""

    def __init__(self, *columns: ProgressColumn | str, numbers: LiveNumbers | None, **how: Any) -> None:
        """Take the columns of the bar, what has the numbers, and what Progress takes."""
        self._numbers = numbers
        super().__init__(*columns, **how)

    def get_renderables(self) -> Iterable[RenderableType]:
        """Return the bar and, once there is a sample, its numbers."""
        yield from super().get_renderables()
        text = "" if self._numbers is None else self._numbers.text()
        if text:
            yield Text(text)
