"""Numba with a cache of this folder's own, named by a hash over its sources: an edit anywhere starts a new one."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba

from musclewire.compiled import cache_root, numba_config

Function = TypeVar("Function", bound=Callable[..., Any])


@cache
def cache_folder() -> str:
    """Return the folder of compiled code for these sources."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    folder = cache_root() / f"grain-wire-{digest.hexdigest()[:16]}"
    folder.mkdir(parents=True, exist_ok=True)
    return str(folder)


def compiled(function: Function) -> Function:
    """Compile a function in strict IEEE 754 arithmetic."""
    before = numba_config.CACHE_DIR
    numba_config.CACHE_DIR = cache_folder()
    try:
        return numba.njit(cache=True, error_model="numpy", nogil=True)(function)
    finally:
        numba_config.CACHE_DIR = before
