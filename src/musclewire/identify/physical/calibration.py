"""A calibration: every parameter of a wire with its uncertainty, and how well the observations are met.

It holds the result and what follows from it. :mod:`calibrate` finds it; :mod:`calibrated_wire` writes it as a wire
file, :mod:`calibration_report` as a page, :mod:`calibration_figures` draws it, and :mod:`advice` simulates the
experiments to make next.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.identify.physical.calibration_text import not_followed, notebook_table, summary
from musclewire.identify.physical.candidates import WireValues
from musclewire.identify.physical.observations import ChannelComparison, compare
from musclewire.identify.physical.posterior import PosteriorProblem
from musclewire.identify.physical.search import SearchResult, Settings
from musclewire.identify.physical.uncertainty import ParameterEstimate
from musclewire.parameters.parameter_groups import Alloy, Bench, Wire
from musclewire.parameters.priors import PriorSet

__all__ = ["Calibration", "CalibrationInputs"]


CORRELATED = 0.9


@dataclass(frozen=True)
class CalibrationInputs:
    """What a calibration starts from: names of the recordings, the wire to start from, priors, effort.

    ``notes`` say how the recordings were understood and what had to be assumed.
    """

    sources: tuple[str, ...]
    wire: str
    priors: PriorSet
    settings: Settings
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Calibration:
    """What a calibration found: every parameter with its uncertainty, and how well the observations are met.

    Parameters
    ----------
    alloy
        The alloy, with the numbers found.
    wire
        The wire, with the numbers found.
    bench
        The bench, with the numbers found.
    estimates
        Every parameter that was searched, with its uncertainty.
    correlation
        Correlation of the estimates, (n, n), in their order.
    problem
        What was minimised: observations and priors.
    search_result
        Where the search ended.
    excess_variance
        By which factor the variance of the residuals exceeds what was stated, 1 or more; it widens the intervals.
    wall_s
        Time that the calibration took [s].
    inputs
        What it started from.
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
        """The numbers of the wire found."""
        return self.problem.candidates.wire_values(self.search_result.coordinates)

    @property
    def identifiable(self) -> list[ParameterEstimate]:
        """Parameters whose interval the data narrowed to half the prior's or less."""
        return [item for item in self.estimates if item.identifiable]

    @property
    def not_identifiable(self) -> list[ParameterEstimate]:
        """Parameters that are still mostly what was believed before."""
        return [item for item in self.estimates if not item.identifiable]

    @property
    def rmse(self) -> float:
        """Root mean square of the observations' residuals, in units of their stated uncertainty."""
        observed = self.search_result.residuals[: -len(self.estimates)]
        return float(np.sqrt(np.mean(observed**2)))

    def comparisons(self) -> list[tuple[str, ChannelComparison]]:
        """Return every channel of every observation beside the wire found, with the observation's title."""
        return list(self._compared)

    @cached_property
    def _compared(self) -> list[tuple[str, ChannelComparison]]:
        return [(item.title, pair) for item in self.problem.observations for pair in compare(item, self.values)]

    @property
    def not_followed(self) -> list[tuple[str, ChannelComparison]]:
        """Channels that the wire found is further off than three times their stated uncertainty (rms)."""
        return not_followed(self.comparisons())

    @property
    def holds(self) -> bool:
        """Whether the model follows every channel to within three times its stated uncertainty (rms)."""
        return not self.not_followed

    @property
    def not_searched(self) -> list[str]:
        """Parameters with a prior that these recordings cannot touch; they keep the starting wire's value."""
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
        """Return what was found, and how well, in lines for a person."""
        return summary(self.inputs.notes, self.comparisons(), self.estimates)

    def _repr_html_(self) -> str:
        """Return the table of parameters for a notebook."""
        return notebook_table(self.comparisons(), self.estimates)

    def as_dict(self) -> dict[str, object]:
        """Return plain values for JSON, as INTERFACE has them."""
        return {
            "parameters": {item.name: item.as_dict() for item in self.estimates},
            "not_identifiable": [item.name for item in self.not_identifiable],
            "rmse": self.rmse,
            "holds": self.holds,
            "channels": [
                {
                    "recording": title,
                    "channel": pair.channel.name,
                    "unit": pair.channel.unit,
                    "rms": pair.rms,
                    "rms_in_uncertainties": pair.normalised_rms,
                }
                for title, pair in self.comparisons()
            ],
            "correlated": [{"parameters": [one, other], "r": r} for one, other, r in self.correlated],
            "not_searched": self.not_searched,
            "notes": list(self.inputs.notes),
            "excess_variance": self.excess_variance,
            "simulations": self.search_result.simulations,
            "descent_costs": list(self.search_result.costs),
            "wall_s": self.wall_s,
            "seed": self.inputs.settings.seed,
        }
