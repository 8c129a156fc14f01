"""JSON as it comes from outside, of limited size and depth, and as it goes out: with null for what is not finite."""

from __future__ import annotations

from typing import Any

from pydantic_core import to_json

from musclewire.errors import CallerError
from musclewire.small_files import json_of

# A drawn path of 10 000 points with all their digits takes 400 kB.
MAX_BYTES = 512 * 1024


def read_json(text: str | bytes) -> Any:
    """Return what a JSON text says. CallerError for one that is too large or too deep, or has NaN or an infinity."""
    if len(text) > MAX_BYTES:
        raise CallerError(f"a message of {len(text)} bytes; at most {MAX_BYTES} are read")
    return json_of(text, "message")


def compact(value: Any) -> str:
    """Return a value as a short JSON text, with null for NaN and infinities: what is unknown."""
    return to_json(value, inf_nan_mode="null").decode()
