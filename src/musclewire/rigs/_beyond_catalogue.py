"""Numbers that no wire of the catalogue has or survives: refused unless the user confirms them.

A factor of a thousand between metre and millimetre, or a limit that protects nothing, is a slip of the pen far more
often than a wire. The bounds are the catalogue's own figures with a wide margin.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

from musclewire.errors import CallerError, argument
from musclewire.parameters import load_catalogue

# Between the catalogue's least or largest figure and what is refused.
MARGIN = 4.0
# The catalogue has no lengths: wire comes from spools. Clamps cool a wire of a few millimetres over its whole length; a
# wire of 10 m, which covers springs and coils wound of it, needs some hundred volts even if it is thick.
LENGTHS_M = (0.002, 10.0)
# Vendors' tables print 300 C as the temperature of annealing (the alloy's file, annealing_temperature): a wire that has
# been there has lost its shape.
ANNEALED_K = 573.15
# Set by --beyond-catalogue for the command's own process and those that it starts: a page's rig, a study's workers.
CONFIRMED = "MUSCLEWIRE_BEYOND_CATALOGUE"
WAY_OUT = (
    "if it is meant so, give "
    + argument("beyond_catalogue", True)
    + ", or write beyond_catalogue = true in the rig file"
)


@contextmanager
def beyond_catalogue(confirmed: bool) -> Iterator[None]:
    """Take what no wire of the catalogue has for meant, in this process and in those that it starts."""
    before = os.environ.get(CONFIRMED)
    if confirmed:
        os.environ[CONFIRMED] = "1"
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(CONFIRMED, None)
        else:
            os.environ[CONFIRMED] = before


def confirmed_beyond() -> bool:
    """Return whether the user has confirmed for this process what no wire of the catalogue has."""
    return os.environ.get(CONFIRMED) == "1"


class StatedCircuit(NamedTuple):
    """A wire's circuit, and the numbers that a rig file or a call states, SI, by key."""

    wire_length_m: float
    shunt_ohm: float
    stated: Mapping[str, float | None]  # None or missing for what is left to wire and bench


def refuse_beyond_catalogue(circuit: StatedCircuit, limits: Mapping[str, float], where: str = "") -> None:
    """Raise CallerError for a number that no wire of the catalogue has or survives; ``limits`` are the stated ones."""
    given = {**circuit.stated, **limits}
    for name, (low, high, unit, why) in ranges_of(circuit).items():
        value = given.get(name)
        if value is not None and not low <= value <= high:
            raise CallerError(
                f"{where + ': ' if where else ''}{name} {value:.6g} {unit} is outside {low:.3g} to {high:.3g} {unit} "
                f"({why}): no wire of the catalogue has or survives it; {in_millimetres(name, value)}" + WAY_OUT
            )


def in_millimetres(name: str, value: float) -> str:
    """Return a length that is out of range as it would be in mm, if it was meant so; "" otherwise."""
    low_m, high_m = LENGTHS_M
    return (
        f'for {value:g} mm write "{value:g} mm"; ' if name == "wire_length" and low_m <= 1e-3 * value <= high_m else ""
    )


def ranges_of(circuit: StatedCircuit) -> dict[str, tuple[float, float, str, str]]:
    """Return the least and largest value of each number that is judged, its unit, and where they are from."""
    rows, length_m = load_catalogue().row, circuit.wire_length_m
    diameters_m = [row.diameter_m for row in rows]
    ohms = [row.resistance_ohm_per_m.value * length_m for row in rows]
    one_second_v = max(row.current_a * (ohm + circuit.shunt_ohm) for row, ohm in zip(rows, ohms, strict=True))
    one_second_w = max(row.current_a**2 * ohm for row, ohm in zip(rows, ohms, strict=True))
    largest_a = max(row.current_a for row in rows)
    times = f"{MARGIN:g} times"
    voltage = (0.0, MARGIN * one_second_v, "V", f"{times} what any size needs for one second at this length")
    window = (min(ohms) / MARGIN, MARGIN * max(ohms), "ohm", f"{times} beyond the sizes of this length")
    return {
        "wire_length": (*LENGTHS_M, "m", "springs and coils included"),
        "diameter_m": (min(diameters_m) / MARGIN, MARGIN * max(diameters_m), "m", f"{times} beyond the sizes"),
        "maximum_voltage": voltage,
        "drive_amplitude": voltage,
        "maximum_current_a": (0.0, MARGIN * largest_a, "A", f"{times} the largest current of any size"),
        "maximum_power_w": (0.0, MARGIN * one_second_w, "W", f"{times} the largest power of any size"),
        "maximum_temperature_k": (0.0, ANNEALED_K, "K", "at 300 C a wire is annealed"),
        "resistance_low_ohm": window,
        "resistance_high_ohm": window,
    }
