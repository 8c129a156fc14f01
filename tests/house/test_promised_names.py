"""What is promised to users is one short list."""

from __future__ import annotations

import musclewire as mw

MOST = 150


def test_no_more_names_are_promised_than_somebody_can_read_through() -> None:
    assert len(dir(mw)) <= MOST
