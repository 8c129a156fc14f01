"""From recordings to the physical parameters of a wire, with uncertainty."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from musclewire.compiled import kernel_source_hash
from musclewire.errors import CallerError, MusclewireError
from musclewire.identify.physical.bench import checked_settings
from musclewire.identify.physical.candidates import Candidates, WireValues
from musclewire.identify.physical.journal import Journal
from musclewire.identify.physical.observations import Comparison, Observation, compare, residuals_of
from musclewire.identify.physical.search import Found, OnProgress, OnStep, Settings, search
from musclewire.identify.physical.sources import Start, observations_of, start_of, told_by
from musclewire.identify.physical.uncertainty import Estimate, covariance, estimates, excess_variance
from musclewire.parameters.library import bench_known_with, load_alloy, load_wire
from musclewire.parameters.priors import PriorSet, load_priors
from musclewire.parameters.schema import Alloy, Bench, Parameter, Wire
from musclewire.signals.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from musclewire.identify.physical.advice import Advice

__all__ = ["Calibration", "Fit", "calibrate", "observations_of"]

FloatArray = NDArray[np.float64]
Group = TypeVar("Group", Alloy, Wire, Bench)

# A channel that is further off than this many of its stated uncertainties is not followed by the model.
FOLLOWED_WITHIN = 3.0
CORRELATED = 0.9


class Fit:
    """Observations and what was known before, as one vector of residuals: a maximum a posteriori fit."""

    def __init__(self, candidates: Candidates, observations: Sequence[Observation]) -> None:
        """Take what is unknown and what was observed."""
        self.candidates = candidates
        self.observations = tuple(observations)

    @property
    def low(self) -> FloatArray:
        """Lower bounds in coordinates, (n,)."""
        return self.candidates.low

    @property
    def high(self) -> FloatArray:
        """Upper bounds in coordinates, (n,)."""
        return self.candidates.high

    def refined(self) -> Fit:
        """Return the same fit, simulated with all digits."""
        return Fit(self.candidates, [item.refined() for item in self.observations])

    def observed_residuals(self, coordinates: FloatArray) -> FloatArray:
        """Return residuals of the observations alone, (m,)."""
        values = self.candidates.wire_values(coordinates)
        return np.concatenate([residuals_of(item, values) for item in self.observations])

    def residuals(self, coordinates: FloatArray) -> FloatArray:
        """Return residuals of the observations, then those of the prior: the coordinates themselves, (m + n,)."""
        return np.concatenate([self.observed_residuals(coordinates), coordinates])


@dataclass(frozen=True)
class Asked:
    """What a calibration was asked for: names of the recordings, the wire to start from, priors, effort.

    ``notes`` say how the recordings were understood and what had to be assumed.
    """

    sources: tuple[str, ...]
    wire: str
    priors: PriorSet
    settings: Settings
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Calibration:
    """What a calibration found: every parameter with its uncertainty, and how well the observations are met."""

    alloy: Alloy
    wire: Wire
    bench: Bench
    estimates: tuple[Estimate, ...]
    correlation: FloatArray
    fit: Fit
    found: Found
    excess_variance: float
    wall_s: float
    asked: Asked

    @property
    def values(self) -> WireValues:
        """The numbers of the wire found."""
        return self.fit.candidates.wire_values(self.found.coordinates)

    @property
    def identifiable(self) -> list[Estimate]:
        """Parameters whose interval the data narrowed to half the prior's or less."""
        return [item for item in self.estimates if item.identifiable]

    @property
    def not_identifiable(self) -> list[Estimate]:
        """Parameters that are still mostly what was believed before."""
        return [item for item in self.estimates if not item.identifiable]

    @property
    def rmse(self) -> float:
        """Root mean square of the observations' residuals, in units of their stated uncertainty."""
        observed = self.found.residuals[: -len(self.estimates)]
        return float(np.sqrt(np.mean(observed**2)))

    def comparisons(self) -> list[tuple[str, Comparison]]:
        """Return every channel of every observation beside the wire found, with the observation's title."""
        return list(self._compared)

    @cached_property
    def _compared(self) -> list[tuple[str, Comparison]]:
        return [(item.title, pair) for item in self.fit.observations for pair in compare(item, self.values)]

    @property
    def not_followed(self) -> list[tuple[str, Comparison]]:
        """Channels that the wire found is further off than three times their stated uncertainty (rms)."""
        return [(title, pair) for title, pair in self.comparisons() if pair.normalised_rms > FOLLOWED_WITHIN]

    @property
    def holds(self) -> bool:
        """Whether the model follows every channel to within three times its stated uncertainty (rms)."""
        return not self.not_followed

    @property
    def not_searched(self) -> list[str]:
        """Parameters with a prior that these recordings cannot touch; they keep the starting wire's value."""
        return [name for name in self.asked.priors.parameters if name not in self.fit.candidates.names]

    @property
    def correlated(self) -> list[tuple[str, str, float]]:
        """Pairs of parameters that the recordings tell together rather than apart (|r| > 0.9), strongest first."""
        names = self.fit.candidates.names
        rows, columns = np.nonzero(np.triu(np.abs(self.correlation) > CORRELATED, 1))
        pairs = [
            (names[row], names[column], float(self.correlation[row, column]))
            for row, column in zip(rows, columns, strict=True)
        ]
        return sorted(pairs, key=lambda pair: -abs(pair[2]))

    @cached_property
    def advice(self) -> tuple[Advice, ...]:
        """What to measure next: experiments with the parameters each would tell, the most telling first."""
        from musclewire.identify.physical.advice import advise

        return advise(self)

    def save(self, path: str | Path, name: str | None = None) -> None:
        """Write the wire found as a wire file (.toml), whole or not at all; ``name`` is the file's without one.

        Raises CallerError for another suffix or a folder that cannot be written to.
        """
        from musclewire.identify.physical.saving import save_wire

        save_wire(self, Path(path), name)

    def report(self, path: str | Path) -> None:
        """Write the report page (.html), whole or not at all. Raises CallerError as :meth:`save`."""
        from musclewire.identify.physical.report import write_report

        write_report(self, Path(path))

    def plot(self) -> Axes:
        """Draw what was measured beside what was fitted, residuals below; return the axes of the first channel."""
        from musclewire.identify.physical.pictures import channel_axes

        return channel_axes(self)

    def __str__(self) -> str:
        """Say what was found, and how well, in lines for a person."""
        from musclewire.identify.physical.words import summary

        return summary(self)

    def _repr_html_(self) -> str:
        """Show the table of parameters in a notebook."""
        from musclewire.identify.physical.words import notebook_table

        return notebook_table(self)

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
            "notes": list(self.asked.notes),
            "excess_variance": self.excess_variance,
            "simulations": self.found.simulations,
            "descent_costs": list(self.found.costs),
            "wall_s": self.wall_s,
            "seed": self.asked.settings.seed,
        }


def calibrate(
    recordings: Mapping[str, Recording] | Recording | Sequence[Recording],
    *,
    wire: str = "paper-100um",
    priors: str | PriorSet = "niti-wire",
    bench: Mapping[str, float | str] | None = None,
    settings: Settings | None = None,
    journal_path: Path | None = None,
    on_progress: OnProgress | None = None,
    on_step: OnStep | None = None,
) -> Calibration:
    """Find the physical parameters of a wire from recordings of it, with uncertainty.

    Parameters
    ----------
    recordings: one or more, of any mix: driven by a voltage from cold (loops, steps), isobars (wire_temperature_k,
        reference_strain, stress_pa), or cooling without voltages (time_s with wire_temperature_k, strain or force)
    wire: the wire to start from, by name or wire file; gives what is not searched for (diameter, density, limits)
    priors: what is known before, by name or TOML file; bounds and priors from the literature by default
    bench: numbers of the bench that the recordings do not state, by name, in SI or as text with a unit; diameter_m and
        start_temperature_k too
    settings: seed and effort of the search
    journal_path: where an interrupted search leaves off and goes on; removed when done
    on_progress: called after each descent with stage, number, total and the best cost so far
    on_step: called several times a second; what it raises ends the search

    Raises
    ------
    RecordingError: a recording that cannot constrain anything
    CallerError: unknown names, a bench that is not known, a journal of another search
    NumericsError: no candidate can be simulated
    """
    started = time.monotonic()
    chosen = settings or Settings()
    named = named_recordings(recordings)
    given = {key: item.value for key, item in bench_known_with(wire).items()} | checked_settings(bench or {})
    start, notes = start_of(named, wire, given)
    observations, more_notes = observations_of(named, given | {"diameter_m": start.wire.diameter_m.value})
    prior_set = priors if isinstance(priors, PriorSet) else load_priors(priors)
    fit = Fit(Candidates(prior_set, *start, only=told_by(prior_set, observations)), observations)
    journal = None
    if journal_path is not None:
        journal = Journal(journal_path, fingerprint(named, prior_set, chosen, wire, given))
    try:
        found = search(fit, chosen, journal=journal, on_progress=on_progress, on_step=on_step)
    except MusclewireError:
        if journal is not None:
            journal.remove()  # there is nothing to go on with
        raise
    asked = Asked(tuple(named), wire, prior_set, chosen, (*notes, *more_notes))
    calibration = summed_up(fit, found, start, asked, started)
    if journal is not None:
        journal.remove()
    return calibration


def summed_up(fit: Fit, found: Found, start: Start, asked: Asked, started: float) -> Calibration:
    """Return a calibration from where a search ended."""
    unknowns = len(fit.candidates)
    observed, derivative = found.residuals[:-unknowns], found.jacobian[:-unknowns]
    excess = excess_variance(observed, unknowns)
    spread = covariance(derivative, excess)
    deviation = np.sqrt(np.diag(spread))
    items = tuple(estimates(fit.candidates, found.coordinates, deviation))
    source = f"fitted by musclewire calibrate to {', '.join(asked.sources)}"
    return Calibration(
        alloy=with_estimates(start.alloy, items, source),
        wire=with_estimates(start.wire, items, source),
        bench=with_estimates(start.bench, items, source),
        estimates=items,
        correlation=np.asarray(spread / np.outer(deviation, deviation)),
        fit=fit.refined(),
        found=found,
        excess_variance=excess,
        wall_s=time.monotonic() - started,
        asked=asked,
    )


def with_estimates(group: Group, items: Sequence[Estimate], source: str) -> Group:
    """Return an alloy, wire or bench with what was found of it; what the data do not tell is marked assumed."""
    kind = type(group).__name__.lower()
    changed = {}
    for item in items:
        if item.group != kind:
            continue
        told = item.identifiable
        changed[item.name] = Parameter(
            value=item.value,
            unit=item.unit,
            kind="fitted" if told else "assumed",
            source=source if told else "prior; the recordings do not tell it",
            note=f"95 % interval {item.interval[0]:.4g} to {item.interval[1]:.4g}",
        )
    return group.model_copy(update=changed)


def named_recordings(recordings: Mapping[str, Recording] | Recording | Sequence[Recording]) -> dict[str, Recording]:
    """Return recordings by name. Raises CallerError where there is none."""
    if isinstance(recordings, Recording):
        return {"recording": recordings}
    if isinstance(recordings, Mapping):
        found = dict(recordings)
    else:
        found = {f"recording {number}": item for number, item in enumerate(recordings, 1)}
    if not found:
        raise CallerError("there is no recording to calibrate from")
    return found


def fingerprint(
    recordings: Mapping[str, Recording],
    priors: PriorSet,
    settings: Settings,
    wire: str,
    bench: Mapping[str, float],
) -> str:
    """Return a short hash of all that decides how a search runs, the simulator included."""
    digest = hashlib.sha256(kernel_source_hash().encode())
    for name, recording in recordings.items():
        digest.update(name.encode())
        digest.update(repr(sorted(recording.metadata.items())).encode())
        for column, values in recording.columns.items():
            digest.update(column.encode())
            digest.update(values.tobytes())
    settled = replace(settings, threads=None)
    start = load_wire(wire)
    around = (start.model_dump(), load_alloy(start.alloy).model_dump())
    digest.update(repr((priors.model_dump(), settled, around, sorted(bench.items()))).encode())
    return digest.hexdigest()[:16]
