"""A finger's wire beyond its vendor's stress, or stretched by less than its alloy's data cover, is warned of."""

from __future__ import annotations

from math import pi

from musclewire_design._finger.finger_study import WireToPull, warnings_of_wire
from musclewire_design._finger.wire import WireOnFinger


def found(pretension_n: float, stress_pa: float) -> list[str]:
    """Return the warnings of a wire of 0.1 mm at a pretension and with a stress at the end of its stroke."""
    wire = WireToPull("paper-100um", 0.14, pretension_n, 386.2)
    force_n = stress_pa * 2.0 * pi / 4.0 * 1e-8
    return warnings_of_wire(wire, WireOnFinger(1e-3, 0.03, 5e-3, 1.0, force_n, stress_pa, 0.0))


def test_within_the_alloys_data_nothing_is_said() -> None:
    assert found(1.0, 150e6) == []


def test_the_vendors_stress_and_the_lowest_covered_stress_are_named() -> None:
    low, high = found(0.3, 150e6), found(1.0, 200e6)
    assert "19 MPa (0.30 N) only, below the 45 MPa" in low[0]
    assert "200 MPa (3.14 N), above the vendor's 172 MPa (2.70 N)" in high[0]
