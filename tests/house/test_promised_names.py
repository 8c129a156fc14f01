"""What is promised to users is one short list."""

from __future__ import annotations

import musclewire as mw
from musclewire.manifest import parts

MOST = 150


def test_no_more_names_are_promised_than_somebody_can_read_through() -> None:
    assert len(dir(mw)) <= MOST


def test_names_of_extras_are_promised_beside_those_of_the_core_and_none_takes_its_place() -> None:
    of_extras = [name for part in parts().values() for name in part.get("names", ())]
    assert set(of_extras) <= set(dir(mw))
    assert len(dir(mw)) - len(of_extras) == len(set(dir(mw)) - set(of_extras))
