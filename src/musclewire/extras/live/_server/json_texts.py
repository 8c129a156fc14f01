"""JSON as it comes from outside: of limited size, of limited depth, and with finite numbers only."""

from __future__ import annotations

import json
import math
from typing import Any, NoReturn

from musclewire.errors import CallerError

__all__ = ["MAX_BYTES", "compact", "compact_finite", "read_json"]

# A drawn path of 10 000 points with all their digits takes 400 kB.
MAX_BYTES = 512 * 1024


def read_json(text: str | bytes) -> Any:
    """Return what a JSON text says. CallerError for one that is too large or too deep, or has NaN or an infinity."""
    if len(text) > MAX_BYTES:
        raise CallerError(f"a message of {len(text)} bytes; at most {MAX_BYTES} are read")
    try:
        return json.loads(text, parse_constant=refuse_constant)
    except RecursionError:
        raise CallerError("not JSON that can be read: nested too deeply, send it flatter") from None
    except ValueError as error:  # also what is no UTF-8, and numbers of thousands of digits
        raise CallerError(f"not JSON that can be read: {str(error)[:200]}") from None


def refuse_constant(name: str) -> NoReturn:
    """Refuse NaN and infinities, which JSON does not have and Python reads all the same."""
    raise ValueError(f"{name} is not a number of JSON: send a finite one, or null")


def compact(value: Any) -> str:
    """Return a value as a short JSON text. ValueError for NaN and infinities: those that may occur are null before."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False)


def compact_finite(value: Any) -> str:
    """Return a value as a short JSON text, with null for NaN and infinities: what is unknown."""
    try:
        return compact(value)
    except ValueError:
        return compact(finite(value))


def finite(value: Any) -> Any:
    """Return a value of JSON with None for every number that is not finite."""
    if isinstance(value, dict):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
