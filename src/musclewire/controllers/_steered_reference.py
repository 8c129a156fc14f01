"""A target that is moved while the loop runs: by a slider, a joystick, another program."""

from __future__ import annotations

import math

from musclewire.controllers._references import HeldTargets
from musclewire.errors import CallerError


class SteeredReference(HeldTargets):
    """A target that another thread may move at any time; the loop follows from its next sample on.

    It keeps each target with the time from which the loop followed it: a run is judged by the targets of its own time.

    Parameters
    ----------
    start
        The first target: strain as a fraction, displacement [m] or force [N].
    lowest, highest
        Range of targets, in the same unit: that of the model.
    longest_s
        Time [s] after which the run ends by itself; an hour, so that no forgotten loop heats a wire for good.

    Raises
    ------
    CallerError
        For numbers that are not finite, a range without length, and a start outside of it.

    Examples
    --------
    >>> import musclewire as mw
    >>> reference = mw.SteeredReference(0.015, lowest=0.005, highest=0.035)
    >>> reference.target_at(1.0)
    0.015
    >>> reference.steer(0.02)
    >>> reference.target_at(2.0), reference.target_at(1.0)
    (0.02, 0.015)
    """

    def __init__(self, start: float, *, lowest: float, highest: float, longest_s: float = 3600.0) -> None:
        """Hold the first target."""
        if not (math.isfinite(lowest) and math.isfinite(highest) and lowest < highest):
            raise CallerError(f"a steered target needs a range that rises, not {lowest} to {highest}")
        if not (math.isfinite(longest_s) and longest_s > 0.0):
            raise CallerError(f"longest_s is {longest_s} and must be above zero")
        self.lowest, self.highest, self._longest_s = lowest, highest, longest_s
        self._wanted = self._checked(start)
        self._starts_s, self._held = [0.0], [self._wanted]
        # How far the loop has come; a target that is asked for again is the one that held then.
        self._front_s = 0.0

    @property
    def duration_s(self) -> float:
        """Time after which the run ends by itself [s]."""
        return self._longest_s

    @property
    def target(self) -> float:
        """The target that was asked for last."""
        return self._wanted

    def steer(self, target: float) -> None:
        """Move the target; any thread may.

        Parameters
        ----------
        target
            Strain as a fraction, displacement [m] or force [N].

        Raises
        ------
        CallerError
            For a target that is not finite or outside the range.
        """
        self._wanted = self._checked(target)

    def target_at(self, time_s: float) -> float:
        """Return the target at a time; at a time later than any before, the one that was asked for last.

        Parameters
        ----------
        time_s
            Time since the reference began [s].

        Returns
        -------
        The target.

        Raises
        ------
        CallerError
            For a time that is not finite.
        """
        if time_s > self._front_s and math.isfinite(time_s):
            self._front_s, wanted = time_s, self._wanted
            if wanted != self._held[-1]:
                self._held.append(wanted)
                self._starts_s.append(time_s)
        return super().target_at(time_s)

    def _checked(self, target: float) -> float:
        """Return a target. Raises CallerError outside the range."""
        if not (math.isfinite(target) and self.lowest <= target <= self.highest):
            raise CallerError(
                f"the target {target:g} is outside {self.lowest:g} to {self.highest:g}: choose one inside"
            )
        return float(target)
