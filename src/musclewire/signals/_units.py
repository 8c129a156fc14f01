"""Units exist only at the edges: file headers, configuration files, the command line. pint is used only here.

Inside the package every number is SI. This module turns a header's unit ("mm", "degC", "%") into a factor and
an offset, and a configuration string ("588.6 N/m") into a number.
"""

from __future__ import annotations

import functools
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError, nearest_hint
from musclewire.signals._columns import COLUMNS

if TYPE_CHECKING:
    import pint
    from pydantic import BeforeValidator


@dataclass(frozen=True)
class UnitConversion:
    """``value_si = factor * value + offset``."""

    factor: float
    offset: float = 0.0

    def apply(self, values: ArrayLike) -> FloatArray:
        """Convert values of any shape to SI."""
        converted = np.asarray(values, dtype=np.float64) * self.factor
        return converted + self.offset if self.offset else converted


class _UnitError(ValueError):
    """The text is no unit, or a unit of another quantity. It is reported as the caller's or the recording's error."""


def conversion_to_si(unit_text: str, column: str, where: str) -> UnitConversion:
    """Return the conversion to SI of numbers for ``column``, given in a unit as found in a header: "mm", "°C", "".

    Raises RecordingError if the unit is unknown or of another quantity.
    """
    unit_si = COLUMNS[column].unit
    try:
        return _conversion(unit_text, unit_si)
    except _UnitError as problem:
        needs = f", {column} needs {_dimension(unit_si)}" if problem.args[1:] else ""
        raise RecordingError(f"{where}: {problem.args[0]}{needs}") from None


# The sensitivity of a sensor, or its scale: "2 V/mm", "0.5 mm/V"; "0.05 mm" for each count.
_SCALE = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\s\d/][^\s/]*)\s*(?:/\s*(\S+))?")


def scale_to_si(text: str, column: str, own_unit: str | None, where: str) -> UnitConversion | None:
    """Return the conversion by a sensor's sensitivity ("2 V/mm") or scale ("0.5 mm/V", "0.05 mm"), else None.

    Raises RecordingError if it fits neither ``column`` nor the numbers, in their ``own_unit`` if that is stated.
    """
    match = _SCALE.fullmatch(text.strip())
    if match is None:
        return None
    number, above, below = float(match[1]), match[2], match[3]
    is_sensitivity = below is not None and measures(below, column)
    if not number or not (is_sensitivity or measures(above, column)):
        unit_si = COLUMNS[column].unit
        raise RecordingError(
            f"{where}: '{text}' is no scale for {column}; write {unit_si} per unit of the sensor, or its inverse"
        )
    ours, theirs = (below, above) if is_sensitivity else (above, below)
    try:
        to_theirs = _conversion(own_unit, _spelling(theirs, "")).factor if own_unit and theirs else 1.0
        factor = _conversion(ours, COLUMNS[column].unit).factor * to_theirs
    except _UnitError as problem:
        raise RecordingError(f"{where}: '{text}' does not fit its numbers in {own_unit}: {problem.args[0]}") from None
    return UnitConversion(factor / number if is_sensitivity else factor * number)


def measures(unit_text: str, column: str) -> bool:
    """Return whether ``unit_text`` is a unit in which ``column`` can be given."""
    try:
        _conversion(unit_text, COLUMNS[column].unit)
    except _UnitError:
        return False
    return True


def is_unit(text: str) -> bool:
    """Return whether a text is a unit of any quantity, in any usual spelling."""
    try:
        _parsed(_spelling(text, ""), text)
    except _UnitError:
        return False
    return True


@functools.cache
def scale_between(unit_text: str, other_text: str) -> float | None:
    """Return what makes a number in a unit one in another; None if no factor does, as of degrees with other zeros."""
    from pint.errors import PintError

    try:
        unit, other = (_parsed(_spelling(text, ""), text) for text in (unit_text, other_text))
        zero, one = (float(_registry().Quantity(each, unit).to(other).magnitude) for each in (0.0, 1.0))
    except (_UnitError, PintError):
        return None
    return None if zero else one


_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")


def parse_quantity(text: str, unit_si: str) -> float:
    """Return a number with its unit, as "588.6 N/m", in ``unit_si``, of pint; "" takes "5 %" and "0.05" for the same.

    Raises CallerError for other text, without a unit or with that of another quantity, and an amount that no bench has.
    """
    match = _QUANTITY.fullmatch(text)
    example = f"'0.5 {unit_si}'" if unit_si else "'0.5' or '50 %'"
    if match is None or not np.isfinite(float(match[1])):
        raise CallerError(f"'{text}' is not a number with a unit; write it like {example}")
    if unit_si and not match[2]:
        raise CallerError(f"'{text}' has no unit; write it with one, as {example}")
    try:
        value = float(_conversion(match[2], unit_si).apply(float(match[1])))
    except _UnitError as problem:
        needs = f"; {_dimension(unit_si)} is needed, like {example}" if problem.args[1:] else ""
        raise CallerError(f"'{text}': {problem.args[0]}{needs}") from None
    if abs(value) > largest_in(unit_si):
        raise CallerError(f"'{text}' {out_of_range_message(unit_si)}")
    return value


def quantity_with_suffix(text: str) -> tuple[float, str] | None:
    """Return "1.0 ohm" as ``(1.0, "_ohm")``, in SI with the ending of its name; None without such an ending."""
    match = _QUANTITY.fullmatch(text)
    if match is None or not match[2]:
        return None
    for _, unit_si, suffix in _DIMENSIONS:
        try:
            conversion = _conversion(match[2], unit_si)
        except _UnitError:
            continue
        return (float(conversion.apply(float(match[1]))), suffix) if suffix is not None else None
    return None


# More in SI no bench with a wire has: a slip of the pen or of the unit, which would compute nonsense or never end.
_LARGEST = {
    "s": 1e8,  # three years
    "m": 1e3,  # all wire of a spool
    "N": 1e6,  # the weight of 100 t
    "V": 1e6,  # a test of power lines
    "A": 1e6,  # more than a lightning
    "ohm": 1e9,  # an open circuit
    "Pa": 1e12,  # as stiff as diamond
    "K": 1e9,  # hotter than the sun
    "N/m": 1e9,  # stiffer than any frame
    "Hz": 1e9,  # faster than any converter of a bench
    "kg": 1e6,  # 1000 t
    "W": 1e9,  # a power station
    "J": 1e9,  # a power station's in a second
    "m/s": 1e5,  # faster than sound in any solid
    "": 1e9,  # of anything
}


def largest_in(unit_si: str) -> float:
    """Return the largest amount, in SI, that may be meant by a quantity in a unit; infinite where nothing is known."""
    return _LARGEST.get(unit_si, float("inf"))


def out_of_range_message(unit_si: str) -> str:
    """Return what is wrong with a number beyond ``largest_in`` of a unit."""
    return f"is beyond what any bench has ({largest_in(unit_si):g} {unit_si}".rstrip() + "): correct it or its unit"


# The quantity in words, its SI unit, and the ending of our names for it (None: there are no such names).
_DIMENSIONS: tuple[tuple[str, str, str | None], ...] = (
    ("a dimensionless number", "", ""),
    ("a time", "s", "_s"),
    ("a length", "m", "_m"),
    ("a force", "N", "_n"),
    ("a voltage", "V", "_v"),
    ("a current", "A", "_a"),
    ("a resistance", "ohm", "_ohm"),
    ("a stress", "Pa", "_pa"),
    ("a temperature", "K", "_k"),
    ("a stiffness", "N/m", "_n_per_m"),
    ("a frequency", "Hz", "_hz"),
    ("a mass (a force would be gf or kgf)", "kg", "_kg"),
    ("a conductance", "S", None),
    ("a power", "W", "_w"),
    ("an energy", "J", "_j"),
    ("a charge (Celsius would be degC)", "C", None),
    ("a capacitance", "F", None),
    ("a speed", "m/s", "_m_per_s"),
    ("an area", "m**2", "_m2"),
)

# Offered as "did you mean" for an unknown unit.
_COMMON = (
    *("s", "ms", "min", "V", "mV", "A", "mA", "ohm", "mohm", "kohm", "%", "m", "mm", "um"),
    *("N", "mN", "gf", "kgf", "Pa", "kPa", "MPa", "K", "degC", "degF"),
)

# Symbol: its name in words, compared without regard to case, with or without a plural s. Symbols themselves are
# never compared so: mV and MV differ by a thousand million. (An mPa of stress is always an MPa.)
_SPELLINGS = {
    "V": "volt voltdc vdc",
    "mV": "millivolt",
    "A": "ampere amp ampdc adc",
    "mA": "milliampere milliamp",
    "mohm": "milliohm",
    "kohm": "kiloohm",
    "s": "second sec",
    "ms": "millisecond msec milli",
    "us": "microsecond usec micro",
    "min": "minute min",
    "h": "hour",
    "m": "meter metre",
    "mm": "millimeter millimetre mm",
    "um": "micrometer micrometre micron",
    "N": "newton",
    "mN": "millinewton",
    "kN": "kn",
    "gf": "gramforce grf",
    "kgf": "kilogramforce",
    "g": "gram",
    "Pa": "pascal",
    "kPa": "kpa kilopascal",
    "MPa": "mpa megapascal",
    "K": "kelvin",
    "degC": "celsius centigrade",
    "degF": "fahrenheit",
    "percent": "percent pct",
    "ppm": "microstrain ustrain",
    "": "strain ratio fraction none dimensionless unitless",
}
_SPELT_OUT = {word: symbol for symbol, words in _SPELLINGS.items() for word in words.split()}

# Characters that look like those that pint accepts: Ohm sign, Kelvin sign, Greek mu, products, degree signs.
_LOOK_ALIKES = str.maketrans({
    "\u2126": "Ω", "\u212a": "K", "\u03bc": "\u00b5", "·": "*", "⋅": "*", "×": "*", "º": "°", "˚": "°",
    "℃": "°C", "℉": "°F", "−": "-",
})  # fmt: skip

_DEGREES = re.compile(r"(?:deg(?:ree)?s?\.?|°)[\s_]*([cfk])(?:elsius|ahrenheit|elvin)?", re.IGNORECASE)
_OHMS = re.compile(r"([kKmMuµG]?)(?:ohms?|Ω)", re.IGNORECASE)

# pint evaluates its input, so that only products of short words with one-digit powers may reach it.
_FACTOR = r"[A-Za-zµ%°_Ω]{1,20}(?:(?:\^|\*\*)-?\d|⁻?[¹²³])?"
_SHAPE = re.compile(rf"(?:1/)?{_FACTOR}(?:[*/ ]{_FACTOR}){{0,3}}")


@functools.cache
def _conversion(unit_text: str, unit_si: str) -> UnitConversion:
    """Return the conversion; _UnitError(message) for no unit, _UnitError(message, True) for the wrong one."""
    spelling = _spelling(unit_text, unit_si)
    if spelling == unit_si:
        return UnitConversion(1.0)
    unit = _parsed(spelling, unit_text)
    if not _same_dimension(unit, unit_si):
        raise _UnitError(f"{unit_text or 'a number without a unit'} is {_dimension(spelling)}", True)
    quantity = _registry().Quantity
    offset = float(quantity(0.0, unit).to(unit_si).magnitude)
    if offset and unit_si != "K":
        # Decibels and similar units have an offset, and no quantity here is measured in them.
        raise _unknown(unit_text)
    # A degree Celsius is 1 K wide wherever the scale begins: the width itself has no rounding of a difference.
    step = f"delta_{unit}" if offset else unit
    return UnitConversion(float(quantity(1.0, step).to(unit_si).magnitude), offset)


def _spelling(unit_text: str, unit_si: str) -> str:
    """Return a unit as people spell it in a spelling that pint accepts."""
    text = unit_text.strip().translate(_LOOK_ALIKES)
    if text in {"-", "1", "–"}:
        return ""
    if text in {"µε", "µstrain", "ue"}:
        return "ppm"
    # "Temp (C)" is Celsius: a temperature in coulombs makes no sense.
    if unit_si == "K" and text in {"C", "F", "c", "f"}:
        return f"deg{text.upper()}"
    if degrees := _DEGREES.fullmatch(text):
        return {"C": "degC", "F": "degF", "K": "K"}[degrees[1].upper()]
    if ohms := _OHMS.fullmatch(text):
        return {"K": "k"}.get(ohms[1], ohms[1]) + "ohm"
    word = text.lower().replace("-", "").replace(" ", "")
    return _SPELT_OUT.get(word, _SPELT_OUT.get(word.removesuffix("s"), text))


def _parsed(spelling: str, unit_text: str) -> pint.Unit:
    try:
        if not spelling or _SHAPE.fullmatch(spelling):
            return _registry().Unit(spelling)
    # pint raises AssertionError, ValueError, tokenizer errors and its own; all say that this is no unit.
    except Exception:
        pass
    raise _unknown(unit_text)


def _unknown(unit_text: str) -> _UnitError:
    """Return the error of what is no unit; a header may have line breaks, and a message has one line."""
    shown = " ".join(unit_text.split())
    return _UnitError(f"unknown unit '{shown}'{nearest_hint(shown, _COMMON)}")


def _same_dimension(unit: pint.Unit, unit_si: str) -> bool:
    # pint calls an angle dimensionless; a strain in degrees is a mistake nevertheless.
    same = bool(unit.dimensionality == _registry().Unit(unit_si).dimensionality)
    return same and _is_angle(unit) == (unit_si == "rad")


def _is_angle(unit: pint.Unit) -> bool:
    return unit.dimensionless and "radian" in str(_registry().get_base_units(unit)[1])


def _dimension(spelling: str) -> str:
    unit = _registry().Unit(spelling)
    if _is_angle(unit):
        return "an angle"
    for words, unit_si, _ in _DIMENSIONS:
        if _same_dimension(unit, unit_si):
            return words
    return f"a quantity in {unit:~}"


@functools.cache
def _registry() -> pint.UnitRegistry[Any]:
    import pint

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry()
    return registry


# Units with a zero of their own, which differences of temperatures cannot have.
ABSOLUTE = ("degC", "degF", "°C", "°F", "celsius", "fahrenheit")


def measured_in(unit: str, *, difference: bool = False) -> BeforeValidator:
    """Return a validator that takes a number in SI or text with a unit.

    Parameters
    ----------
    unit
        The SI unit.
    difference
        Whether it is a difference of temperatures: degrees Celsius and Fahrenheit are refused, because their zero is
        arbitrary.

    Returns
    -------
    The validator, for a field of a pydantic model.

    Raises
    ------
    ValueError
        By the validator, for text that is no such quantity, and for an amount that no bench has.
    """
    from pydantic import BeforeValidator  # here, so that recordings are read without it

    def in_si(given: Any) -> Any:
        if isinstance(given, bool):
            raise ValueError(f"{str(given).lower()} is no number: give one in {unit or '1'}, or text with a unit")
        if isinstance(given, (int, float)) and abs(given) > largest_in(unit) and given == given:
            raise ValueError(f"{given:g} {out_of_range_message(unit)}")
        if not isinstance(given, str):
            return given
        if difference and given.rstrip().endswith(ABSOLUTE):
            raise ValueError(f"'{given}': a difference of temperatures is needed, like '3 K'")
        try:
            return parse_quantity(given, unit)
        except CallerError as error:
            raise ValueError(str(error)) from None

    in_si.unit = unit  # type: ignore[attr-defined]  # for messages on limits (parameters/_validation.py)
    return BeforeValidator(in_si)
