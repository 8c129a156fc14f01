"""The few volts that the doctor puts out, and the samples it receives.

Nothing above the sense voltage is ever put out. The first levels lie below half of it: there the protection expects no
current yet, so wrong wiring can be examined without a trip. Only if these levels pass is the sense voltage put out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RigError
from musclewire.rigs import Rig
from musclewire.signals import RawSample

Clock = Callable[[], float]
OnProbe = Callable[[RawSample], None]

# Fractions of the sense voltage below the protection's threshold for "driven", which is half of it.
LOW_FRACTIONS = (0.25, 0.45)
# After a step the first readings may be from before it: through a filter, or a frame in transit.
SETTLING_S, SETTLING_SAMPLES = 0.1, 2
MIN_SAMPLES = 20


class VoltageLevel(NamedTuple):
    """Samples of one output voltage, settled ones only; arrays of shape (n_times,).

    ``host_s`` is the host's own clock when each sample arrived.
    """

    commanded_v: float
    time_s: FloatArray
    host_s: FloatArray
    drive_voltage_v: FloatArray
    wire_voltage_v: FloatArray
    shunt_voltage_v: FloatArray


def samples_of(rig: Rig, seconds: float) -> int:
    """Return how many samples a level of this many seconds has: never fewer than statistics need."""
    return max(round(seconds / rig.sample_period_s), MIN_SAMPLES)


class VoltageProbe:
    """Holds voltages on a rig and keeps the samples, also those of a level during which the rig had a fault."""

    def __init__(self, rig: Rig, clock: Clock, on_sample: OnProbe | None) -> None:
        """Take an open rig; ``clock`` returns the host's seconds."""
        self._rig, self._clock, self._on_sample = rig, clock, on_sample
        self.levels: list[VoltageLevel] = []
        self.trouble: RigError | None = None
        self.highest_v = 0.0

    def hold(self, voltage_v: float, seconds: float) -> VoltageLevel | None:
        """Hold a voltage and return its samples; None after a fault of the rig, which is then in ``trouble``.

        Raises CallerError for a voltage above the sense voltage, which must not be put out here.
        """
        if not 0.0 <= voltage_v <= self._rig.sense_voltage_v * (1.0 + 1e-9):
            raise CallerError(
                f"{voltage_v:g} V is outside 0 to the sense voltage, {self._rig.sense_voltage_v:g} V: the doctor "
                "heats nothing, give less"
            )
        self.highest_v = max(self.highest_v, voltage_v)
        rows: list[tuple[float, ...]] = []
        settling = max(round(SETTLING_S / self._rig.sample_period_s), SETTLING_SAMPLES)
        try:
            self._fill(rows, voltage_v, settling + samples_of(self._rig, seconds))
        except RigError as error:
            self.trouble = error
        # Of a level cut short at the very beginning the unsettled samples are better than none.
        kept = rows if self.trouble is not None and not self.levels else rows[settling:]
        if kept:
            columns = np.asarray(kept, dtype=np.float64).T
            self.levels.append(VoltageLevel(voltage_v, *columns))
        return None if self.trouble is not None else self.levels[-1]

    def _fill(self, rows: list[tuple[float, ...]], voltage_v: float, samples: int) -> None:
        """Append this number of samples to rows, as they arrive."""
        for _ in range(samples):
            sample = self._rig.exchange(voltage_v)
            arrived_s = self._clock()
            if self._on_sample is not None:
                self._on_sample(sample)
            rows.append((sample.time_s, arrived_s, *sample[1:4]))
