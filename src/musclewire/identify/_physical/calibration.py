"""A calibration: every parameter of a wire with its uncertainty, and the residuals of the observations.

It holds the result and what follows from it. :mod:`calibrate` finds it; :mod:`calibrated_wire` writes it as a wire
file, :mod:`calibration_report` as a page, :mod:`calibration_figures` draws it, and :mod:`advice` simulates the
experiments to make next.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.identify._physical.calibration_text import not_followed, number, standing, summary, verdict
from musclewire.identify._physical.candidates import WireValues
from musclewire.identify._physical.observations import ChannelComparison, compare
from musclewire.identify._physical.posterior import PosteriorProblem
from musclewire.identify._physical.search import SearchResult, SearchSettings
from musclewire.identify._physical.uncertainty import ParameterEstimate
from musclewire.pages import notebook_table
from musclewire.parameters import Alloy, Bench, PriorSet, Wire

CORRELATED = 0.9


@dataclass(frozen=True)
class CalibrationInputs:
    """Inputs of a calibration: names of the recordings, the wire to start from, priors, effort.

    ``notes`` state how the recordings were understood and which assumptions were made.
    """

    sources: tuple[str, ...]
    wire: str
    priors: PriorSet
    settings: SearchSettings
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Calibration:
    """Result of a calibration: every parameter with its uncertainty, and the residuals of the observations.

    Parameters
    ----------
    alloy
        The alloy with its fitted numbers.
    wire
        The wire with its fitted numbers.
    bench
        The bench with its fitted numbers.
    estimates
        Every fitted parameter with its uncertainty.
    correlation
        Correlation of the estimates, (n, n), in their order.
    problem
        The least-squares problem: observations and priors.
    search_result
        Result of the search.
    excess_variance
        Variance of the residuals over that of their stated uncertainty, 1 or more; it widens the intervals.
    wall_s
        Duration of the calibration [s].
    inputs
        Inputs of the calibration.
    """

    alloy: Alloy
    wire: Wire
    bench: Bench
    estimates: tuple[ParameterEstimate, ...]
    correlation: FloatArray
    problem: PosteriorProblem
    search_result: SearchResult
    excess_variance: float
    wall_s: float
    inputs: CalibrationInputs

    @property
    def values(self) -> WireValues:
        """The numbers of the fitted wire."""
        return self.problem.candidates.wire_values(self.search_result.coordinates)

    @property
    def identifiable(self) -> list[ParameterEstimate]:
        """Parameters whose interval the data narrowed to half the prior's or less."""
        return [item for item in self.estimates if item.identifiable]

    @property
    def not_identifiable(self) -> list[ParameterEstimate]:
        """Parameters whose interval is still mostly the prior's."""
        return [item for item in self.estimates if not item.identifiable]

    @property
    def rmse(self) -> float:
        """Root mean square of the observations' residuals, in units of their stated uncertainty."""
        observed = self.search_result.residuals[: -len(self.estimates)]
        return float(np.sqrt(np.mean(observed**2)))

    def comparisons(self) -> list[tuple[str, ChannelComparison]]:
        """Return every channel of every observation with its fit, and the observation's title."""
        return list(self._compared)

    @cached_property
    def _compared(self) -> list[tuple[str, ChannelComparison]]:
        return [(item.title, pair) for item in self.problem.observations for pair in compare(item, self.values)]

    @property
    def not_followed(self) -> list[tuple[str, ChannelComparison]]:
        """Channels whose residuals exceed three times their stated uncertainty (rms)."""
        return not_followed(self.comparisons())

    @property
    def holds(self) -> bool:
        """Whether the model follows every channel to within three times its stated uncertainty (rms)."""
        return not self.not_followed

    @property
    def not_searched(self) -> list[str]:
        """Parameters with a prior on which these recordings do not depend; they keep the starting wire's value."""
        return [name for name in self.inputs.priors.parameters if name not in self.problem.candidates.names]

    @property
    def correlated(self) -> list[tuple[str, str, float]]:
        """Pairs of parameters that the recordings identify together rather than apart (|r| > 0.9), strongest first."""
        names = self.problem.candidates.names
        rows, columns = np.nonzero(np.triu(np.abs(self.correlation) > CORRELATED, 1))
        pairs = [
            (names[row], names[column], float(self.correlation[row, column]))
            for row, column in zip(rows, columns, strict=True)
        ]
        return sorted(pairs, key=lambda pair: -abs(pair[2]))

    def __str__(self) -> str:
        """Return result and residuals as lines of text."""
        return summary(self.inputs.notes, self.comparisons(), self.estimates)

    def _repr_html_(self) -> str:
        """Return the table of parameters for a notebook."""
        rows = [(item.name, number(item.value), number(item.std), item.unit, standing(item)) for item in self.estimates]
        title = f"Calibration ({verdict(self.comparisons(), self.estimates)})"
        return notebook_table(title, ("parameter", "value", "±", "unit", ""), rows)
