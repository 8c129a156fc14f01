"""What can be known of a wire's stroke without an instrument: marks on a ruler, an end stop, and their errors."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite, sqrt

from musclewire.errors import CallerError

# Two readings may lie in the wrong order by chance, by at most this many standard deviations of their difference.
PLAUSIBLE = 3.0


@dataclass(frozen=True)
class Marks:
    """Positions of the connector read off a ruler, cold and at the hottest, or an end stop that it runs against.

    All are along the direction of the contraction. Both marks are of the recording that is fitted: cold before it, hot
    at the largest contraction in it.

    Parameters
    ----------
    cold_m, hot_m
        Positions of the cold and of the hottest wire [m], contraction positive; None if they were not read. Only their
        difference counts.
    end_stop_m
        Displacement from the cold position at which the connector meets a rigid stop [m]; None without one.
    reading_std_m
        Standard deviation of one reading, or of the stop's position [m]. The default of 0.5 mm is half a division of a
        ruler.
    leg_length_std_m
        Standard deviation of the stated length of one leg [m]; the default is the same half a division.

    Raises
    ------
    CallerError
        If only one mark is given, the hot one is below the cold one by more than their errors, the stop is not beyond
        the cold position, or an error is not above 0.
    """

    cold_m: float | None = None
    hot_m: float | None = None
    end_stop_m: float | None = None
    reading_std_m: float = 0.5e-3
    leg_length_std_m: float = 0.5e-3

    def __post_init__(self) -> None:
        """Check the marks."""
        if (self.cold_m is None) != (self.hot_m is None):
            raise CallerError("one mark shows nothing: give both, the cold wire's and the hot one's")
        if self.end_stop_m is not None and not 0.0 < self.end_stop_m < inf:
            raise CallerError(
                f"the end stop is at {1e3 * self.end_stop_m:.4g} mm from the cold wire: it must be beyond"
            )
        for name, value in (("reading_std_m", self.reading_std_m), ("leg_length_std_m", self.leg_length_std_m)):
            if not (isfinite(value) and value > 0.0):
                raise CallerError(f"{name} is {value}: no ruler is exact, give a standard deviation above 0")
        if self.stroke_m is not None and not -PLAUSIBLE * self.stroke_std_m < self.stroke_m < inf:
            raise CallerError(
                f"the hot mark is {1e3 * self.stroke_m:.4g} mm from the cold one: a wire contracts as it is heated, so "
                "that it must be further along the contraction"
            )

    @property
    def stroke_m(self) -> float | None:
        """Displacement between both marks [m]; None without them."""
        return None if self.cold_m is None or self.hot_m is None else self.hot_m - self.cold_m

    @property
    def stroke_std_m(self) -> float:
        """Standard deviation of the displacement between two marks [m]."""
        return sqrt(2.0) * self.reading_std_m
