"""The first heating of a run: at which resistance it turns, against the slow loop that the model was fitted to.

Load and a scale of the resistance move that maximum, B; air, its flow and the stiffness of a spring hardly do.
"""

from __future__ import annotations

from math import hypot
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.judge._loop import JudgedLoop
from musclewire.sensing import SensingModel, find_resistance_extremes, first_maximum, noise_level
from musclewire.signals import MetadataValue, RunFacts

# B counts as moved by more than this many of the standard deviations with which the model states that it repeats.
LIMIT_STDS = 4.0
# A wire was cold if its resistance rises to B by at least this part of what the slow loop's did: a warm one is on its
# way, and may turn anywhere. Under half the load a cold wire's rises by half of it, and of a cold reading at the sense
# voltage the noise is a sixth of it, so the part is no larger.
COLD_RISE = 0.3
# One that still holds austenite begins lower than a cold one by more than this part of the span; a cold one whose
# resistance fell by 2 % does not.
HOT_FRACTION = 0.15
NOT_HEATED = 1.5  # times the sense voltage: up to here a drive does not heat the wire
NOISY = 2.0  # times the sense voltage: up to here little current flows, and a maximum of the resistance is noise
# Readings whose mean is the highest resistance of a loop: less noise than in a single one.
MEAN_SAMPLES = 5
# Why a run's first heating is not compared with that of the model.
NO_LOOP = (
    "this model does not state its slow loop, so that a load or a resistance that has changed since is not noticed at "
    "the start: fit a recording with voltages again"
)
NO_MAXIMUM = (
    "resistance has no maximum in this model's slow loop, so that a load or a resistance that has changed since is not "
    "noticed at the start"
)
NO_COOLING = (
    "this model's slow loop ended before its wire was cold, so that a load or a resistance that changes in mid-run is "
    "not noticed: record one that cools longer"
)


class SeenAtB(NamedTuple):
    """B of a first heating: its row, how far it is above the model's, and the limit, in % of the span from B to C."""

    row: int
    away_pct: float
    limit_pct: float
    which: str = "B"  # or in words another maximum

    @property
    def is_away(self) -> bool:
        """Whether that is more than what repeats."""
        return abs(self.away_pct) > self.limit_pct

    def __str__(self) -> str:
        """Return it in words."""
        side = "above" if self.away_pct > 0.0 else "below"
        return (
            f"{self.which} is {abs(self.away_pct):.1f} % of the span from B to C {side} the model's, and repeats "
            f"within {self.limit_pct:.1f} %"
        )


class KnownB(NamedTuple):
    """What a model's slow loop showed of B, and the drive at which a rig only senses."""

    b_ohm: float
    c_ohm: float
    rise_ohm: float  # from the cold wire to B
    std_ohm: float  # with which B repeats
    highest_ohm: float  # of the whole loop: B's, or that of a wire which turns higher when it cools
    sense_voltage_v: float  # hardly heats

    @classmethod
    def stated_in(cls, facts: RunFacts) -> KnownB | None:
        """Return what a run states of it; None if its model states no B."""
        names = ("model_b_ohm", "model_c_ohm", "model_rise_ohm", "model_b_std_ohm")
        numbers = [facts.number_or_none(name) for name in names]
        if None in numbers:
            return None
        b_ohm, c_ohm, rise_ohm, std_ohm = (float(number or 0.0) for number in numbers)
        highest_ohm = facts.number_or_none("model_highest_ohm") or b_ohm
        sense_voltage_v = facts.number_or_none("limit_sense_voltage_v") or 0.0
        return cls(b_ohm, c_ohm, rise_ohm, std_ohm, highest_ohm, sense_voltage_v)

    @classmethod
    def of_model(cls, model: SensingModel, sense_voltage_v: float) -> KnownB | None:
        """Return what a model's slow loop showed of it, for a rig of a sense voltage [V]; None if it shows no B."""
        return cls.stated_in(RunFacts({**height_of_b(model), "limit_sense_voltage_v": sense_voltage_v}))

    def passed_in(self, resistance_ohm: FloatArray, drive_voltage_v: FloatArray) -> tuple[int, float] | None:
        """Return row and height [ohm] of the first maximum, read with enough current, that a resistance fell from."""
        first = 0
        while (found := first_maximum(resistance_ohm[first:], self.b_ohm - self.c_ohm, self.std_ohm)) is not None:
            row = first + round(found.place)
            if drive_voltage_v[row] > NOISY * self.sense_voltage_v:
                return row, found.resistance_ohm
            first = row + 1
        return None

    def seen_in(self, resistance_ohm: FloatArray, drive_voltage_v: FloatArray) -> SeenAtB | None:
        """Return B of a first heating from resistance and drive, (n_times,) each; None if it did not come from cold."""
        passed = self.passed_in(resistance_ohm, drive_voltage_v)
        if passed is None:
            return None
        at, seen_ohm = passed
        unheated = np.flatnonzero(drive_voltage_v[:at] <= NOT_HEATED * self.sense_voltage_v)
        last = int(unheated[-1]) if unheated.size else 0
        # The reading that follows is of a current that heats, and so of less noise.
        cold_ohm = resistance_ohm[last : last + 2].min()
        span_ohm = self.b_ohm - self.c_ohm
        hot = resistance_ohm[0] < self.b_ohm - self.rise_ohm - HOT_FRACTION * span_ohm
        if hot or seen_ohm - cold_ohm < COLD_RISE * self.rise_ohm:
            return None
        percent = 100.0 / span_ohm
        # The noise of B's reading by its drive, from the rows before; 0 if they are too few.
        noise_ohm = noise_level(resistance_ohm[:at], drive_voltage_v[:at] / drive_voltage_v[at])
        std_ohm = hypot(self.std_ohm, noise_ohm)
        return SeenAtB(at, percent * (seen_ohm - self.b_ohm), percent * LIMIT_STDS * std_ohm)


def height_of_b(model: SensingModel) -> dict[str, MetadataValue]:
    """Return the height of B in a model's slow loop, which a run's first heating is compared with, or why it is not."""
    resistance_ohm = np.array([row[2] for row in model.slow_loop])
    try:
        seen = find_resistance_extremes(resistance_ohm)
    except RecordingError:
        return {"b_not_compared": NO_LOOP}
    if not seen.saw_b:
        return {"b_not_compared": NO_MAXIMUM}
    means_ohm = np.convolve(resistance_ohm, np.full(MEAN_SAMPLES, 1.0 / MEAN_SAMPLES), "valid")
    # B repeats by the drift that a trained wire has, and the noise of a reading.
    std_ohm = hypot(model.drift_resistance_ohm, model.resistance_noise_ohm)
    cooling_ohm = means_ohm[means_ohm.argmin() :]
    cold_from_ohm = model.cold_resistance_ohm - HOT_FRACTION * (model.resistance_max_ohm - model.resistance_min_ohm)
    still_rose = cooling_ohm.max() == cooling_ohm[-1] > cooling_ohm[-1 - cooling_ohm.size // 10] + std_ohm
    # A cooling that ended warm, or while the resistance rose, has not shown its highest.
    shows_it = cooling_ohm.max() > cold_from_ohm and not still_rose
    return {
        "model_b_ohm": model.resistance_max_ohm,
        "model_c_ohm": model.resistance_min_ohm,
        "model_highest_ohm": max(model.resistance_max_ohm, float(means_ohm.max())),
        "model_rise_ohm": model.resistance_max_ohm - model.cold_resistance_ohm,
        "model_b_std_ohm": std_ohm,
        **({"model_cooling_ohm": float(cooling_ohm.max())} if shows_it else {"cooling_not_compared": NO_COOLING}),
    }


def seen_at_b(loop: JudgedLoop) -> SeenAtB | None:
    """Return B of a run's first heating; None if its model states none, or the wire did not come from cold."""
    known = KnownB.stated_in(loop.facts)
    if known is None or "wire_resistance_ohm" not in loop.recording:
        return None
    resistance_ohm = loop.recording["wire_resistance_ohm"]
    rows = np.flatnonzero(resistance_ohm > 0.0)
    seen = known.seen_in(resistance_ohm[rows], loop.drive_voltage_v[rows])
    return None if seen is None else seen._replace(row=int(rows[seen.row]))


def not_compared(loop: JudgedLoop) -> str:
    """Return in words that a run's first heating has not been compared with its model's; "" if it has, or need not."""
    if loop.facts.number_or_none("model_b_ohm") is None or loop.once(seen_at_b) is not None:
        return ""
    return (
        "the wire did not pass B from cold, so that it is not known whether load and resistance are still those of the "
        "model: start with a wire that has cooled"
    )
