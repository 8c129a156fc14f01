"""Each promise about a stop on the page of safety names a test that there is."""

from __future__ import annotations

import re
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[3]


def test_every_promise_names_a_test_of_the_live_room() -> None:
    page = (CHECKOUT / "docs/explanation/safety.md").read_text("utf-8")
    rows = page.partition("| Promise |")[2].partition("\n\n")[0].splitlines()[2:]
    tests = "".join(path.read_text("utf-8") for path in (CHECKOUT / "tests/extras/live").rglob("test_*.py"))
    assert len(rows) >= 6
    for row in rows:
        named = re.findall(r"`(test_\w+)`", row)
        assert named, row
        for name in named:
            assert f"def {name}(" in tests, name
