"""Studies that tests begin with."""

from __future__ import annotations

from typing import Any


def study_of(**changes: Any) -> dict[str, Any]:
    """Return a small study of one slow sine over two pretensions, with some keys changed."""
    return {
        "format": "musclewire-study",
        "version": 1,
        "name": "test",
        "run": {"kind": "characterize", "cycles": 1, "period": "20 s", "keep": ["stroke"]},
        "parameters": {"pretension": {"values": ["1.5 N", "1.9 N"]}},
        **changes,
    }
