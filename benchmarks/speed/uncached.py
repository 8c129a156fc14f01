"""Compiles as the package does, but keeps nothing on disk.

The package's cache is named by its own sources only: machine code of a file outside it could be that of other lines.
"""

from __future__ import annotations

from typing import Any

import numba

__all__ = ["compiled"]


def compiled(function: Any) -> Any:
    """Return a function that is compiled on its first call, in strict IEEE 754 arithmetic."""
    return numba.njit(error_model="numpy", nogil=True)(function)
