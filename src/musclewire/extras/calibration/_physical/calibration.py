"""A calibration: every parameter of a wire with its uncertainty, and the residuals of the observations.

It holds the result and what follows from it, as text and as a wire file. :mod:`calibrate` finds it,
:mod:`calibration_report` draws it and writes its page, and :mod:`advice` simulates the experiments to make next.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, joined
from musclewire.extras.calibration._physical.bench import SETTABLE
from musclewire.extras.calibration._physical.candidates import WireValues
from musclewire.extras.calibration._physical.isobaric import IsobaricObservation
from musclewire.extras.calibration._physical.observations import ChannelComparison, compare
from musclewire.extras.calibration._physical.posterior import ParameterEstimate, PosteriorProblem
from musclewire.extras.calibration._physical.search import SearchResult, SearchSettings
from musclewire.pages import notebook_table
from musclewire.parameters import Alloy, Bench, Parameter, PriorSet, Wire, is_wire_file, wire_file_text
from musclewire.signals import write_text_whole

# The model does not follow a channel whose residuals exceed this multiple of its stated uncertainty.
FOLLOWED_WITHIN = 3.0
# Parameters whose correlation exceeds this are identified together rather than apart.
CORRELATED = 0.9
# Numbers of a bench that belong to the recording's rig and not to the wire's bench.
NOT_KEPT = ("sample_period_s",)


def channel_line(title: str, pair: ChannelComparison) -> str:
    """Return the residuals of a channel, in its unit and over its uncertainty."""
    percent = pair.channel.unit == "1"
    off = f"{100.0 * pair.rms:.3g} %" if percent else f"{pair.rms:.3g} {pair.channel.unit}"
    return f"{title}: {pair.channel.name} {off} rms, {pair.normalised_rms:.2f} of its uncertainty"


def standing(item: ParameterEstimate) -> str:
    """Return the standing of a parameter's value: "" if the recordings identify it."""
    return "at a bound" if item.at_bound else "" if item.identifiable else "mostly prior"


def number(value: float) -> str:
    """Return a number with four digits."""
    return f"{value:.4g}"


@dataclass(frozen=True)
class CalibrationInputs:
    """Inputs of a calibration: names of the recordings, the wire to start from, priors, effort."""

    sources: tuple[str, ...]
    wire: str
    priors: PriorSet
    settings: SearchSettings
    notes: tuple[str, ...]  # how the recordings were understood and which assumptions were made


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
        return [(title, pair) for title, pair in self._compared if pair.normalised_rms > FOLLOWED_WITHIN]

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

    @property
    def verdict(self) -> str:
        """Whether the fit holds, and how many parameters the recordings identify."""
        identified = f"{len(self.identifiable)} of {len(self.estimates)} parameters identifiable from the recordings"
        if self.holds:
            return f"the fit holds; {identified}"
        title, worst = max(self.not_followed, key=lambda pair: pair[1].normalised_rms)
        return (
            f"the fit does not hold: {worst.channel.name} of {title} is {worst.normalised_rms:.1f} of its "
            f"uncertainties off (rms), {FOLLOWED_WITHIN:g} are allowed; {identified}"
        )

    def __str__(self) -> str:
        """Return result and residuals as lines of text."""
        lines = [*self.inputs.notes, "", *(channel_line(title, pair) for title, pair in self._compared), ""]
        lines.append(f"{'parameter':<32}{'value':>12} {'+-':>10}  {'unit':<11}")
        for item in self.estimates:
            line = f"{item.name:<32}{number(item.value):>12} {number(item.std):>10}  {item.unit:<11} {standing(item)}"
            lines.append(line.rstrip())
        return joined("\n", [*lines, "", self.verdict])

    def _repr_html_(self) -> str:
        """Return the table of parameters for a notebook."""
        rows = [(item.name, number(item.value), number(item.std), item.unit, standing(item)) for item in self.estimates]
        return notebook_table(f"Calibration ({self.verdict})", ("parameter", "value", "±", "unit", ""), rows)


def save_wire(calibration: Calibration, path: str | Path, name: str | None = None) -> None:
    """Write the fitted wire, its alloy and the known numbers of the bench as one wire file, whole or not at all.

    Parameters
    ----------
    calibration
        The calibration.
    path
        File to write; it ends in .toml, and an existing one is replaced.
    name
        Name of the wire; the file's without its suffix if it is None.

    Raises
    ------
    CallerError
        If the path has another suffix, or its folder cannot be written to.
    """
    path = Path(path)
    if not is_wire_file(path.name):
        raise CallerError(f"{path}: a wire is a .toml file, end its name so")
    text = wire_file_text(
        name or path.stem, description(calibration), calibration.wire, calibration.alloy, known_bench(calibration)
    )
    write_text_whole(path, text)


def description(calibration: Calibration) -> str:
    """Return a sentence that states how a wire was fitted."""
    identifiable, whole = len(calibration.identifiable), len(calibration.estimates)
    verdict = "" if calibration.holds else "; the fit does not hold: the model does not follow every channel"
    return (
        f"Fitted to {', '.join(calibration.inputs.sources)}, started from {calibration.inputs.wire} with the priors "
        f"{calibration.inputs.priors.name}: {identifiable} of {whole} parameters identifiable from the recordings, "
        f"residuals {calibration.rmse:.2f} of their uncertainty{verdict}"
    )


def known_bench(calibration: Calibration) -> dict[str, Parameter]:
    """Return the fitted numbers of the bench, then those on which all recordings of a drive or of cooling agree."""
    found = {key: item for key, item in calibration.bench.items() if key in calibration.problem.candidates.names}
    stated = [
        item.bench  # type: ignore[attr-defined]
        for item in calibration.problem.observations
        if not isinstance(item, IsobaricObservation)
    ]
    source = f"stated with {', '.join(calibration.inputs.sources)}, or fitted to force and displacement"
    for key in stated[0] if stated else ():
        alike = len({bench.get(key) for bench in stated}) == 1
        if alike and key in Bench.model_fields and key not in found and key not in NOT_KEPT:
            found[key] = Parameter(value=stated[0][key], unit=SETTABLE[key], kind="measured", source=source)
    return found
