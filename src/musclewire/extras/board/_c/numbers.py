"""Numbers as C literals: every digit is kept, in single precision as in double, or the export is refused."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from decimal import Decimal

import numpy as np

from musclewire.errors import CallerError, argument

MIN_NORMAL = float(np.finfo(np.float32).tiny)
DROPPED_BITS = (1 << 29) - 1  # the bits of a double that single precision drops
HALF_WAY = 1 << 28  # these bits of a double half-way between two numbers of single precision


def literal(value: float) -> str:
    """Return a finite number as a C literal that reads back as the same double, and as its nearest single.

    The shortest text that gives the double back is not the double itself. Where the double lies half-way between two
    singles that difference would decide the rounding, so in that case all its digits are written.
    """
    number = float(value)
    if not math.isfinite(number):
        raise CallerError(f"{number} cannot be written as a C number: give a finite one")
    bits = struct.unpack("<Q", struct.pack("<d", number))[0]
    if bits & DROPPED_BITS == HALF_WAY:
        text = format(Decimal(number), "f")
        return text if "." in text else f"{text}.0"
    return repr(number)


def check_single(name: str, value: float) -> None:
    """Raise CallerError, naming the number, if single precision cannot hold it to its 24 bits."""
    with np.errstate(over="ignore", under="ignore"):
        single = float(np.float32(value))
    if not math.isfinite(single):
        raise CallerError(
            f"{name} is {value!r}, more than single precision holds (3.4e38): check its unit, or export with "
            + argument("double", True)
        )
    if value != 0.0 and abs(single) < MIN_NORMAL:
        raise CallerError(
            f"{name} is {value!r}, less than single precision holds (1.2e-38): check its unit, or export with "
            + argument("double", True)
        )


def rows(texts: Iterable[str], width: int = 100) -> list[str]:
    """Return comma-separated texts in lines of at most ``width`` characters."""
    lines: list[str] = []
    line = ""
    for text in texts:
        if line and len(line) + len(text) + 2 > width:
            lines.append(line.rstrip())
            line = ""
        line += f"{text}, "
    return [*lines, line.rstrip()] if line else lines
