"""The first heating of a run: at which resistance it turns, against the slow loop that the model was fitted to.

Load and a scale of the resistance move that maximum, B; air, its flow and the stiffness of a spring hardly do.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.sensing import first_maximum
from musclewire.signals import Recording

# B counts as moved beyond so many of the standard deviations with which the model says that it repeats.
LIMIT_STDS = 4.0
# A wire was cold if its resistance rises to B by at least this part of what the slow loop's did: a warm one is on its
# way, and may turn anywhere. A cold reading at the sense voltage has much noise, so the part is no larger.
COLD_RISE = 0.5
# One that still holds austenite begins lower than a cold one by more than this part of the span; a cold one whose
# resistance fell by 2 % does not.
HOT_FRACTION = 0.15
# A drive of up to this many times the sense voltage does not heat.
NOT_HEATED = 1.5


class SeenAtB(NamedTuple):
    """B of a first heating: its row, how far it is above the model's, and the limit, in % of the span from B to C."""

    row: int
    away_pct: float
    limit_pct: float

    @property
    def is_away(self) -> bool:
        """Whether that is more than what repeats."""
        return abs(self.away_pct) > self.limit_pct

    def __str__(self) -> str:
        """Return it in words."""
        side = "above" if self.away_pct > 0.0 else "below"
        return (
            f"B is {abs(self.away_pct):.1f} % of the span from B to C {side} the model's, and repeats within "
            f"{self.limit_pct:.1f} %"
        )


def seen_at_b(recording: Recording) -> SeenAtB | None:
    """Return B of a run's first heating; None if its model states none, or the wire did not come from cold."""
    facts = recording.facts
    names = ("model_b_ohm", "model_c_ohm", "model_rise_ohm", "model_b_std_ohm")
    numbers = [facts.number_or_none(name) for name in names]
    if None in numbers or "wire_resistance_ohm" not in recording:
        return None
    b_ohm, c_ohm, rise_ohm, std_ohm = (float(number or 0.0) for number in numbers)
    rows = np.flatnonzero(recording["wire_resistance_ohm"] > 0.0)
    resistance_ohm = recording["wire_resistance_ohm"][rows]
    found = first_maximum(resistance_ohm, b_ohm - c_ohm, std_ohm)
    if found is None:
        return None
    at = round(found.place)
    unheated_v = NOT_HEATED * (facts.number_or_none("limit_sense_voltage_v") or 0.0)
    unheated = np.flatnonzero(recording["drive_voltage_v"][rows[:at]] <= unheated_v)
    coldest = int(unheated[-1]) if unheated.size else 0
    span_ohm = b_ohm - c_ohm
    hot = resistance_ohm[0] < b_ohm - rise_ohm - HOT_FRACTION * span_ohm
    if hot or found.resistance_ohm - resistance_ohm[coldest] < COLD_RISE * rise_ohm:
        return None
    percent = 100.0 / span_ohm
    return SeenAtB(int(rows[at]), percent * (found.resistance_ohm - b_ohm), percent * LIMIT_STDS * std_ohm)


def not_compared(recording: Recording) -> str:
    """Return in words that a run's first heating has not been compared with its model's; "" if it has, or need not."""
    if recording.facts.number_or_none("model_b_ohm") is None or seen_at_b(recording) is not None:
        return ""
    return (
        "the wire did not pass B from cold, so that it is not known whether load and resistance are still those of the "
        "model: start with a wire that has cooled"
    )
