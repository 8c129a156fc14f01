"""What a cell of a text file holds: a number and how it is written, one with its unit, or a mark that it is none."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable
from dataclasses import dataclass, field

# Words for "no number" in lower case: blank, not available, overload of a meter, nothing, infinite.
_NO_NUMBER = frozenset({
    "", "nan", "+nan", "-nan", "1.#qnan", "n/a", "#n/a", "na", "n.a.", "null", "none", "nil", "#value!", "#div/0!",
    "#num!", "#ref!", "missing", "no data", "nodata", "invalid", "ol", "o.l.", "o.l", "over", "overload", "ovld",
    "overflow", "ovrflw", "∞", "+∞", "-∞",
})  # fmt: skip
# And signs alone, as loggers print them: ---, +++++++, *****, ?, ....
_SIGNS = re.compile(r"[-+*?.–—#]+|[+-]?(?:inf(?:inity)?|1\.#(?:inf|ind)\w*|\d(?:\.\d+)?e\+?[3-9]\d\d)", re.IGNORECASE)

_SPACES = " \u00a0\u202f\u2009'’"
_NUMERIC = re.compile(
    rf"[+\-−]?[ ]*(?:\d{{1,3}}(?:[{_SPACES}]\d{{3}})+(?:[.,]\d*)?|\d(?:[\d.,]*\d)?\.?|[.,]\d+)(?:[eEdD][+\-−]?\d+)?",
    re.IGNORECASE,
)
# Groups of three digits, with a sign between them, and then a decimal sign: only this shows thousands for certain.
_POINT_THOUSANDS = re.compile(r"[+\-]?\d{1,3}(?:\.\d{3})+,\d+|[+\-]?\d{1,3}(?:\.\d{3}){2,}")
_COMMA_THOUSANDS = re.compile(r"[+\-]?\d{1,3}(?:,\d{3})+\.\d+|[+\-]?\d{1,3}(?:,\d{3}){2,}")
_SPACE_THOUSANDS = re.compile(rf"[+\-]?\d{{1,3}}(?:[{_SPACES}]\d{{3}})+(?:[.,]\d+)?")
# A point that is no sign between thousands.
_POINT = re.compile(r"\d{4,}\.|\.(?!\d{3}(?!\d))|(?<!\d)0*\.")
_GROUPS = {sign: re.compile(rf"[+\-]?\d{{1,3}}(?:[{re.escape(sign)}]\d{{3}})+(?!\d)") for sign in (".", ",", _SPACES)}
_QUANTITY = re.compile(rf"({_NUMERIC.pattern})\s*([^\W\d_][^\s\d]{{0,9}}|[%°Ω][^\s\d]{{0,4}})", re.IGNORECASE)


@functools.lru_cache(maxsize=1024)
def is_missing(cell: str) -> bool:
    """Return whether a cell says that there is no number, or that it is beyond what the instrument can show."""
    text = cell.strip().lower()
    return text in _NO_NUMBER or _SIGNS.fullmatch(text) is not None


def number_and_unit(cell: str) -> tuple[str, str] | None:
    """Return the two parts of a cell like "0.33 V"; whether the second one is a unit, others know."""
    match = _QUANTITY.fullmatch(cell.strip())
    return None if match is None or looks_numeric(cell) else (match[1], match[2])


def looks_numeric(cell: str) -> bool:
    """Return whether a cell may be a number in some style."""
    return _NUMERIC.fullmatch(cell.strip()) is not None


@dataclass(frozen=True)
class NumberStyle:
    """The signs in the numbers of a column."""

    decimal: str = "."
    thousands: str = ""  # all signs that may be between them
    is_open: bool = field(default=False, compare=False)  # no number shows the decimal sign
    # The style among columns with decimal points, if the commas may as well be between thousands.
    grouped: NumberStyle | None = field(default=None, compare=False)

    def __str__(self) -> str:
        """Return the style in words, "" if it is plain."""
        words = ["decimal comma"] if self.decimal == "," else []
        return ", ".join([*words, "signs between thousands"] if self.thousands else words)

    def number(self, cell: str) -> float:
        """Return a cell as a number. Raises ValueError if it is none."""
        text = cell.strip().replace("−", "-")
        if "_" in text:
            raise ValueError(f"{cell} is not a number")
        if text[:1] in "+-":
            text = text[:1] + text[1:].lstrip()
        if self.thousands and _GROUPS[self.thousands].match(text):
            text = text.translate(dict.fromkeys(map(ord, self.thousands)))
        if self.decimal == ",":
            if "." in text:
                raise ValueError(f"{cell} has a point among decimal commas; write commas only")
            text = text.replace(",", ".")
        try:
            return float(text)
        except ValueError:
            # Fortran writes 1.0D-3.
            return float(text.replace("D", "E").replace("d", "e"))


def style_of(cells: Iterable[str]) -> NumberStyle:
    """Return the style of the numbers among some cells: of both signs in one number the last is the decimal sign."""
    numbers = [cell.strip() for cell in cells if looks_numeric(cell)]
    if any(_POINT_THOUSANDS.fullmatch(cell) for cell in numbers):
        return NumberStyle(",", ".")
    if any(_COMMA_THOUSANDS.fullmatch(cell) for cell in numbers):
        return NumberStyle(".", ",")
    commas, points = (sum(sign in cell for cell in numbers) for sign in ",.")
    # A mark of none may have a point among decimal commas, as 1.#INF or 9.9E+37 have.
    decimal = "," if commas > 9 * points else "."
    thousands = _SPACES if any(_SPACE_THOUSANDS.fullmatch(cell) for cell in numbers) else ""
    is_open = not (commas or thousands) and not any(_POINT.search(cell) for cell in numbers)
    grouped = None
    if decimal == "," and all(_GROUPS[","].fullmatch(cell) for cell in numbers if "," in cell):
        # Thousands begin with no zero, and smaller numbers have no comma; where all have one, that is not known.
        small = [cell for cell in numbers if "," not in cell]
        sure = bool(small) and not any(cell.lstrip("+-").startswith("0,") for cell in numbers)
        grouped = NumberStyle(".", "," if sure else "")
    return NumberStyle(decimal, thousands, is_open, grouped)
