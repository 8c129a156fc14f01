"""From recordings to the physical parameters of a wire, with uncertainty."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from musclewire.errors import CallerError
from musclewire.identify.physical.candidates import Candidates, WireValues
from musclewire.identify.physical.driven import observe_drive
from musclewire.identify.physical.isobaric import isobars_in, observe_isobars
from musclewire.identify.physical.journal import Journal
from musclewire.identify.physical.observations import Comparison, Observation, compare, residuals_of
from musclewire.identify.physical.search import Found, OnProgress, Settings, search
from musclewire.identify.physical.uncertainty import Estimate, covariance, estimates, excess_variance
from musclewire.parameters.library import load_alloy, load_bench, load_wire
from musclewire.parameters.priors import PriorSet, load_priors
from musclewire.parameters.schema import Alloy, Bench, Parameter, Wire
from musclewire.signals.recording import Recording

__all__ = ["Calibration", "Fit", "calibrate", "observations_of"]

FloatArray = NDArray[np.float64]
Group = TypeVar("Group", Alloy, Wire, Bench)

ISOBAR_COLUMNS = ("wire_temperature_k", "reference_strain", "stress_pa")


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
    settings: Settings
    sources: tuple[str, ...]

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
        return [(item.title, pair) for item in self.fit.observations for pair in compare(item, self.values)]

    def as_dict(self) -> dict[str, object]:
        """Return plain values for JSON, as INTERFACE has them."""
        return {
            "parameters": {item.name: item.as_dict() for item in self.estimates},
            "not_identifiable": [item.name for item in self.not_identifiable],
            "rmse": self.rmse,
            "channels": [
                {"recording": title, "channel": pair.channel.name, "unit": pair.channel.unit, "rms": pair.rms}
                for title, pair in self.comparisons()
            ],
            "excess_variance": self.excess_variance,
            "simulations": self.found.simulations,
            "descent_costs": list(self.found.costs),
            "wall_s": self.wall_s,
            "seed": self.settings.seed,
        }


def observations_of(recordings: Mapping[str, Recording], bench: Mapping[str, float] | None = None) -> list[Observation]:
    """Return recordings, by name, as observations; all isobars among them become one, with one zero of strain.

    Raises RecordingError for one that cannot constrain anything.
    """
    found: list[Observation] = []
    isobars = []
    for name, recording in recordings.items():
        if set(ISOBAR_COLUMNS) <= set(recording.names):
            isobars += isobars_in(recording, name)
        else:
            found.append(observe_drive(recording, bench or {}, name))
    if isobars:
        found.append(observe_isobars(isobars, "isobars"))
    return found


def calibrate(
    recordings: Mapping[str, Recording] | Recording | Sequence[Recording],
    *,
    wire: str = "paper-100um",
    priors: str | PriorSet = "niti-wire",
    bench: Mapping[str, float] | None = None,
    settings: Settings | None = None,
    journal_path: Path | None = None,
    on_progress: OnProgress | None = None,
) -> Calibration:
    """Find the physical parameters of a wire from recordings of it, with uncertainty.

    Parameters
    ----------
    recordings: one or more, of any mix: driven by a voltage (loops, steps, cooling), or isobars (wire_temperature_k,
        reference_strain, stress_pa)
    wire: the wire to start from; gives what is not searched for (diameter, density, limits)
    priors: what is known before, by name or TOML file; bounds and priors from the literature by default
    bench: numbers of the bench that the recordings do not state, by name in SI
    settings: seed and effort of the search
    journal_path: where an interrupted search leaves off and goes on; removed when done

    Raises
    ------
    RecordingError: a recording that cannot constrain anything
    CallerError: unknown names, a bench that is not known, a journal of another search
    NumericsError: no candidate can be simulated
    """
    started = time.monotonic()
    chosen = settings or Settings()
    named = named_recordings(recordings)
    observations = observations_of(named, bench)
    start_wire = load_wire(wire)
    start = (load_alloy(start_wire.alloy), start_wire, load_bench("paper"))
    prior_set = priors if isinstance(priors, PriorSet) else load_priors(priors)
    fit = Fit(Candidates(prior_set, *start, only=told_by(prior_set, observations)), observations)
    journal = None
    if journal_path is not None:
        journal = Journal(journal_path, fingerprint(named, prior_set, chosen, wire, bench))
    found = search(fit, chosen, journal=journal, on_progress=on_progress)
    if journal is not None:
        journal.remove()
    return summed_up(fit, found, start, tuple(named), chosen, started)


def summed_up(
    fit: Fit,
    found: Found,
    start: tuple[Alloy, Wire, Bench],
    sources: tuple[str, ...],
    settings: Settings,
    started: float,
) -> Calibration:
    """Return a calibration from where a search ended."""
    unknowns = len(fit.candidates)
    observed, derivative = found.residuals[:-unknowns], found.jacobian[:-unknowns]
    excess = excess_variance(observed, unknowns)
    spread = covariance(derivative, excess)
    deviation = np.sqrt(np.diag(spread))
    items = tuple(estimates(fit.candidates, found.coordinates, deviation))
    source = f"fitted by musclewire calibrate to {', '.join(sources)}"
    return Calibration(
        alloy=with_estimates(start[0], items, source),
        wire=with_estimates(start[1], items, source),
        bench=with_estimates(start[2], items, source),
        estimates=items,
        correlation=np.asarray(spread / np.outer(deviation, deviation)),
        fit=fit.refined(),
        found=found,
        excess_variance=excess,
        wall_s=time.monotonic() - started,
        settings=settings,
        sources=sources,
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


def told_by(priors: PriorSet, observations: Sequence[Observation]) -> list[str]:
    """Return the parameters that could matter to these observations at all.

    Isobars know neither heat nor electricity, and a bench without a guide has no friction to find.
    """
    driven = any(not item.title.startswith("isobars") for item in observations)
    electrical_or_thermal = ("resistivity", "specific_heat", "latent_heat", "convection", "guide_friction")
    return [name for name in priors.parameters if driven or not any(word in name for word in electrical_or_thermal)]


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
    bench: Mapping[str, float] | None,
) -> str:
    """Return a short hash of all that decides how a search runs."""
    digest = hashlib.sha256()
    for name, recording in recordings.items():
        digest.update(name.encode())
        for column, values in recording.columns.items():
            digest.update(column.encode())
            digest.update(values.tobytes())
    settled = replace(settings, threads=None)
    digest.update(repr((priors.model_dump(), settled, wire, sorted((bench or {}).items()))).encode())
    return digest.hexdigest()[:16]
