"""Numbers of a rig file: in SI, or as text with a unit."""

from __future__ import annotations

from typing import Any

from pydantic import BeforeValidator

from musclewire.errors import CallerError
from musclewire.signals.units import parse_quantity

__all__ = ["measured_in"]

ABSOLUTE = ("degC", "degF", "°C", "°F", "celsius", "fahrenheit")


def measured_in(unit: str, *, difference: bool = False) -> BeforeValidator:
    """Return a validator that takes a number in SI or text with a unit.

    For a ``difference`` of temperatures, degrees Celsius and Fahrenheit are refused, because their zero is arbitrary.
    """

    def in_si(given: Any) -> Any:
        if not isinstance(given, str):
            return given
        if difference and given.rstrip().endswith(ABSOLUTE):
            raise ValueError(f"'{given}': a difference of temperatures is needed, like '3 K'")
        try:
            return parse_quantity(given, unit)
        except CallerError as error:
            raise ValueError(str(error)) from None

    in_si.unit = unit  # type: ignore[attr-defined]  # for messages on limits (parameters/validation.py)
    return BeforeValidator(in_si)
