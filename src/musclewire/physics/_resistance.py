"""Electrical resistance as measured in a circuit (Eq. 1)."""

from __future__ import annotations

from math import inf
from typing import NamedTuple, TypeVar, cast, overload

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError

# The minimum current [A] of a valid reading: well above the offsets of usual converters.
MINIMUM_CURRENT_A = 1e-3
# Resistivity and thermal strain are stated at this temperature.
REFERENCE_TEMPERATURE_K = 293.15
# By it elastic strain thins a wire: the vendor's figure for NiTi.
ELASTIC_POISSON_RATIO = 0.33

Voltage = TypeVar("Voltage", float, FloatArray)


class ResistanceReading(NamedTuple):
    """One resistance of a wire, and whether it is valid."""

    resistance_ohm: float  # 0.0 if it is not valid
    valid: bool  # whether a usable current flowed


class ArrayReading(NamedTuple):
    """Many resistances of a wire, and which of them are valid.

    Parameters
    ----------
    resistance_ohm
        Resistances [ohm], shape (n_times,) or (n_times, n_wires); 0.0 where not valid.
    valid
        Which readings have a usable current, of the same shape.
    """

    resistance_ohm: FloatArray
    valid: npt.NDArray[np.bool_]


NO_READING = ResistanceReading(0.0, False)


def series_resistance_ohm(wire_voltage_v: Voltage, shunt_voltage_v: Voltage, shunt_resistance_ohm: float) -> Voltage:
    """Return the resistance [ohm] of a wire in series with a shunt: Eq. 1, R_SMA = V_SMA / V_R * R.

    The division comes first, here and in the C library (``MW_SERIES_RESISTANCE`` in ``mw_real.h``): then both round
    alike. The caller checks that there is a current. The function is not compiled: a call from Python into compiled
    code takes longer than the two operations.

    Parameters
    ----------
    wire_voltage_v
        V_SMA [V], the voltage across the wire; a number or an array of any shape.
    shunt_voltage_v
        V_R [V], the voltage across the shunt, of the same shape and not 0.
    shunt_resistance_ohm
        R [ohm], the shunt's resistance.

    Returns
    -------
    The resistance [ohm], of the shape of the voltages.

    References
    ----------
    Lan and Fan 2010, Eq. 1.

    Examples
    --------
    >>> series_resistance_ohm(2.0, 0.125, 1.0)
    16.0
    """
    return wire_voltage_v / shunt_voltage_v * shunt_resistance_ohm


@overload
def wire_resistance(
    wire_voltage_v: float,
    shunt_voltage_v: float,
    shunt_resistance_ohm: float,
    minimum_current_a: float = ...,
) -> ResistanceReading: ...
@overload
def wire_resistance(
    wire_voltage_v: FloatArray,
    shunt_voltage_v: FloatArray,
    shunt_resistance_ohm: float,
    minimum_current_a: float = ...,
) -> ArrayReading: ...
def wire_resistance(
    wire_voltage_v: float | FloatArray,
    shunt_voltage_v: float | FloatArray,
    shunt_resistance_ohm: float,
    minimum_current_a: float = MINIMUM_CURRENT_A,
) -> ResistanceReading | ArrayReading:
    """Return the resistance of a wire in series with a shunt (Eq. 1), if there is a current.

    Without current there is no resistance: if the current is below ``minimum_current_a``, a voltage is not finite or
    the two voltages have opposite signs (swapped leads), the reading is 0.0 ohm and not valid.

    Parameters
    ----------
    wire_voltage_v
        V_SMA, voltage across the wire [V]: a number, or an array of shape (n_times,) or (n_times, n_wires).
    shunt_voltage_v
        V_R, voltage across the shunt [V], of the same shape.
    shunt_resistance_ohm
        R, resistance of the shunt [ohm].
    minimum_current_a
        Minimum current [A] of a valid reading; the default is well above the offsets of usual converters.

    Returns
    -------
    One reading, or one of arrays in the shape of the voltages.

    Raises
    ------
    CallerError
        If shunt resistance or minimum current is not positive, or the shapes differ.

    References
    ----------
    Lan and Fan 2010, Eq. 1: R_SMA = (V_SMA / V_R) R.
    """
    if not (0.0 < shunt_resistance_ohm < inf and 0.0 < minimum_current_a < inf):
        raise CallerError(
            f"shunt resistance {shunt_resistance_ohm} ohm and minimum current {minimum_current_a} A: "
            "both must be positive and finite"
        )
    if isinstance(wire_voltage_v, float) and isinstance(shunt_voltage_v, float):
        if not abs(shunt_voltage_v) >= minimum_current_a * shunt_resistance_ohm:
            return NO_READING
        resistance = series_resistance_ohm(wire_voltage_v, shunt_voltage_v, shunt_resistance_ohm)
        return ResistanceReading(resistance, True) if 0.0 < resistance < inf else NO_READING
    min_voltage_v = minimum_current_a * shunt_resistance_ohm
    return _reading(wire_voltage_v, shunt_voltage_v, min_voltage_v, shunt_resistance_ohm)


@overload
def wire_resistance_from_current(
    wire_voltage_v: float, wire_current_a: float, minimum_current_a: float = ...
) -> ResistanceReading: ...
@overload
def wire_resistance_from_current(
    wire_voltage_v: FloatArray, wire_current_a: FloatArray, minimum_current_a: float = ...
) -> ArrayReading: ...
def wire_resistance_from_current(
    wire_voltage_v: float | FloatArray, wire_current_a: float | FloatArray, minimum_current_a: float = MINIMUM_CURRENT_A
) -> ResistanceReading | ArrayReading:
    """Return the resistance from the wire's voltage and its measured current (Eq. 1 with V_R / R already divided).

    Parameters
    ----------
    wire_voltage_v
        Voltage across the wire [V], a number or an array as in :func:`wire_resistance`.
    wire_current_a
        Current through it [A], of the same shape.
    minimum_current_a
        Minimum current [A] of a valid reading; the default is well above the offsets of usual converters.

    Returns
    -------
    One reading, or one of arrays in the shape of the voltages.

    Raises
    ------
    CallerError
        If the minimum current is not positive, or the shapes differ.
    """
    # A shunt of one ohm carries one volt per ampere.
    return wire_resistance(wire_voltage_v, wire_current_a, 1.0, minimum_current_a)  # type: ignore[arg-type]


def _reading(
    wire_voltage_v: npt.ArrayLike, shunt_voltage_v: npt.ArrayLike, min_voltage_v: float, shunt_ohm: float
) -> ResistanceReading | ArrayReading:
    """Return the readings of arrays by Eq. 1; plain integers and 0-d arrays give a single reading."""
    wire = np.asarray(wire_voltage_v, dtype=np.float64)
    shunt = np.asarray(shunt_voltage_v, dtype=np.float64)
    if wire.shape != shunt.shape and wire.ndim and shunt.ndim:
        raise CallerError(
            f"wire voltages have shape {wire.shape} and shunt voltages or currents {shunt.shape}: "
            "give both the same shape, time first"
        )
    carries = np.abs(shunt) >= min_voltage_v
    # Readings without current are divided by 1, which avoids a warning; np.where discards the result.
    with np.errstate(over="ignore", invalid="ignore"):
        ratio = series_resistance_ohm(wire, np.where(carries, shunt, 1.0), shunt_ohm)
    valid = carries & (ratio > 0.0) & np.isfinite(ratio)
    resistance = np.where(valid, ratio, 0.0)
    if resistance.ndim == 0:
        return ResistanceReading(float(resistance), bool(valid))
    return ArrayReading(cast(FloatArray, resistance), valid)
