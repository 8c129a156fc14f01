"""The seed of random numbers, checked before anything draws from it."""

from __future__ import annotations

from operator import index

from musclewire.errors import CallerError


def require_seed(seed: object, name: str = "seed") -> int:
    """Return a seed as NumPy takes it. Raises CallerError unless it is a whole number of 0 or more."""
    try:
        whole = index(seed)  # type: ignore[arg-type]
    except TypeError:
        near = round(abs(seed)) if isinstance(seed, float) and abs(seed) < 2**63 else 1
    else:
        if whole >= 0:
            return whole
        near = -whole
    raise CallerError(f"{name} is {seed!r}: it must be a whole number of 0 or more, as {near}")
