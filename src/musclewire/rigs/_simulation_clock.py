"""The clock of a simulated rig: none, the computer's, or the computer's made faster or slower."""

from __future__ import annotations

from musclewire.errors import CallerError
from musclewire.rigs._device import Metadata
from musclewire.rigs._pacing import SamplePacer

MINIMUM_SPEED = 0.01  # times real time: a slower wire is watched better in its recording
MAXIMUM_SPEED = 1000.0  # times real time: no machine computes a faster one


class SimulationClock:
    """What paces a simulated rig, at a speed that may change; only at real time is a late host reported."""

    def __init__(self, sample_period_s: float) -> None:
        """Pace in real time from the first sample on."""
        self._sample_period_s = sample_period_s
        self._pacer = SamplePacer(sample_period_s)
        self._speed, self._changes = 1.0, 0
        self._late_reported = False

    @property
    def speed(self) -> float:
        """Simulated seconds in a second."""
        return self._speed

    @property
    def changes(self) -> int:
        """How often the speed has been changed."""
        return self._changes

    def set_speed(self, factor: float) -> None:
        """Run so many times as fast as real time from now on. Raises CallerError for an impossible factor."""
        if not MINIMUM_SPEED <= factor <= MAXIMUM_SPEED:
            raise CallerError(
                f"clock speed {factor:g} is outside {MINIMUM_SPEED:g} to {MAXIMUM_SPEED:g}: 1 is real time, 10 ten "
                "times as fast"
            )
        speed = float(factor)
        if speed != self._speed:
            self._speed, self._changes = speed, self._changes + 1
            self._pacer.change_period(self._sample_period_s / speed)

    def report_late_s(self) -> float:
        """Return how late the host comes for the next sample [s], once; 0 if it is in time or was reported late."""
        late_s = 0.0 if self._late_reported or self._speed != 1.0 else self._pacer.late_s()
        self._late_reported = late_s > 0.0
        return late_s

    def wait(self) -> None:
        """Wait until the next sample is due."""
        self._pacer.wait()

    def rest(self) -> None:
        """Expect no sample until the next wait."""
        self._pacer.rest()

    def end(self) -> None:
        """Let nobody wait any longer; from any thread."""
        self._pacer.end()

    def metadata(self) -> Metadata:
        """Return the metadata of a recording that describe this clock."""
        return {"clock_speed": self._speed}
