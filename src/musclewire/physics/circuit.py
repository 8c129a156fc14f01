"""The measuring circuit: a wire in series with a shunt (Lan and Fan 2010, Fig. 2)."""

from __future__ import annotations

from typing import TypeVar

from musclewire.arrays import FloatArray

__all__ = ["series_resistance_ohm"]

Voltage = TypeVar("Voltage", float, FloatArray)


def series_resistance_ohm(wire_voltage_v: Voltage, shunt_voltage_v: Voltage, shunt_resistance_ohm: float) -> Voltage:
    """Return the resistance [ohm] of a wire in series with a shunt: Eq. 1, R_SMA = V_SMA / V_R * R.

    The division comes first, here and in the C library (``MW_SERIES_RESISTANCE`` in ``mw_real.h``): then both round
    alike. Whether there is a current at all is for the caller to say. Not compiled: a call from Python into compiled
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
