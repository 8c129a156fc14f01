"""From recordings to the physical parameters of a wire, with uncertainty."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from musclewire.compiled import kernel_source_hash
from musclewire.errors import CallerError, MusclewireError
from musclewire.extras.calibration._physical.bench import checked_settings
from musclewire.extras.calibration._physical.calibration import Calibration, CalibrationInputs
from musclewire.extras.calibration._physical.candidates import CandidateParameters
from musclewire.extras.calibration._physical.posterior import (
    ParameterEstimate,
    PosteriorProblem,
    covariance,
    estimates,
    excess_variance,
    widened_covariance,
)
from musclewire.extras.calibration._physical.recording_kinds import (
    StartingPoint,
    observable_parameters,
    observations_of,
    start_of,
)
from musclewire.extras.calibration._physical.search import (
    OnProgress,
    OnStep,
    SearchJournal,
    SearchResult,
    SearchSettings,
    search,
)
from musclewire.parameters import (
    Alloy,
    Bench,
    Parameter,
    PriorSet,
    Wire,
    bench_known_with,
    load_alloy,
    load_priors,
    load_wire,
)
from musclewire.signals import Recording

Group = TypeVar("Group", Alloy, Wire, Bench)


def calibrate(
    recordings: Mapping[str, Recording] | Recording | Sequence[Recording],
    *,
    wire: str = "paper-100um",
    priors: str | PriorSet = "niti-wire",
    bench: Mapping[str, float | str] | None = None,
    settings: SearchSettings | None = None,
    journal_path: Path | None = None,
    on_progress: OnProgress | None = None,
    on_step: OnStep | None = None,
) -> Calibration:
    """Find the physical parameters of a wire from recordings of it, with uncertainty.

    Parameters
    ----------
    recordings
        One or more, of any mix, by name or without: driven by a voltage from cold (loops, steps), isobars
        (wire_temperature_k, reference_strain, stress_pa), or cooling without voltages (time_s with wire_temperature_k,
        strain or force).
    wire
        The wire to start from, by name or wire file; it gives the numbers that are not searched for: diameter, density,
        limits.
    priors
        Priors, by name, TOML file or loaded; the default has bounds and priors from the literature.
    bench
        Numbers of the bench that the recordings do not state, by name, in SI or as text with a unit; also diameter_m
        and start_temperature_k. None if the recordings state all.
    settings
        Seed and effort of the search; None for the settings of a wire with some thirty unknowns.
    journal_path
        File from which an interrupted search continues; removed when the search is complete. None keeps no file.
    on_progress
        Called after each descent with stage, number, total and the best cost until then.
    on_step
        Called several times a second; an exception that it raises ends the search.

    Returns
    -------
    Every parameter with its uncertainty, and the residuals of the observations.

    Raises
    ------
    RecordingError
        If a recording cannot constrain anything.
    CallerError
        For unknown names, an incomplete bench, or a journal of another search.
    NumericsError
        If no candidate can be simulated.
    """
    started = time.monotonic()
    chosen = settings or SearchSettings()
    named = named_recordings(recordings)
    given = {key: item.value for key, item in bench_known_with(wire).items()} | checked_settings(bench or {})
    start, notes = start_of(named, wire, given)
    if start.alloy.grain_quantiles is not None:
        notes.append(f"kept: the grains' quantiles of {wire}, in place of skew, tail and early grains")
    observations, more_notes = observations_of(named, given | {"diameter_m": start.wire.diameter_m.value})
    prior_set = priors if isinstance(priors, PriorSet) else load_priors(priors)
    problem = PosteriorProblem(
        CandidateParameters(prior_set, *start, only=observable_parameters(prior_set, observations)), observations
    )
    journal = None
    if journal_path is not None:
        journal = SearchJournal(journal_path, fingerprint(named, prior_set, chosen, wire, given))
    try:
        result = search(problem, chosen, journal=journal, on_progress=on_progress, on_step=on_step)
    except MusclewireError:
        if journal is not None:
            journal.remove()  # there is nothing to continue from
        raise
    inputs = CalibrationInputs(tuple(named), wire, prior_set, chosen, (*notes, *more_notes))
    calibration = calibration_of(problem, result, start, inputs, started)
    if journal is not None:
        journal.remove()
    return calibration


def calibration_of(
    problem: PosteriorProblem, result: SearchResult, start: StartingPoint, inputs: CalibrationInputs, started: float
) -> Calibration:
    """Return the calibration that follows from the result of a search."""
    unknowns = len(problem.candidates)
    observed, derivative = result.residuals[:-unknowns], result.jacobian[:-unknowns]
    excess = excess_variance(observed, unknowns)
    stretches = [channel.measured.size for item in problem.observations for channel in item.channels]
    laplace = covariance(derivative, excess)
    spread = widened_covariance(laplace, derivative, observed, result.coordinates, stretches, result.best_ends)
    deviation = np.sqrt(np.diag(spread))
    items = tuple(estimates(problem.candidates, result.coordinates, deviation))
    source = f"fitted by musclewire calibrate to {', '.join(inputs.sources)}"
    return Calibration(
        alloy=with_estimates(start.alloy, items, source),
        wire=with_estimates(start.wire, items, source),
        bench=with_estimates(start.bench, items, source),
        estimates=items,
        correlation=np.asarray(spread / np.outer(deviation, deviation)),
        problem=problem.refined(),
        search_result=result,
        excess_variance=excess,
        wall_s=time.monotonic() - started,
        inputs=inputs,
    )


def with_estimates(group: Group, items: Sequence[ParameterEstimate], source: str) -> Group:
    """Return an alloy, wire or bench with its fitted numbers; those that the data do not identify are "assumed"."""
    kind = type(group).__name__.lower()
    changed = {}
    for item in items:
        if item.group != kind:
            continue
        changed[item.name] = Parameter(
            value=item.value,
            unit=item.unit,
            kind="fitted" if item.identifiable else "assumed",
            source=source if item.identifiable else "prior and recordings; not identifiable from the recordings",
            note=f"95 % interval {item.interval[0]:.4g} to {item.interval[1]:.4g}",
        )
    return group.model_copy(update=changed)


def named_recordings(recordings: Mapping[str, Recording] | Recording | Sequence[Recording]) -> dict[str, Recording]:
    """Return recordings by name. Raises CallerError without any recording."""
    if isinstance(recordings, Recording):
        return {"recording": recordings}
    if isinstance(recordings, Mapping):
        found = dict(recordings)
    else:
        found = {f"recording {number}": item for number, item in enumerate(recordings, 1)}
    if not found:
        raise CallerError("there is no recording to calibrate from: give one or more")
    return found


def fingerprint(
    recordings: Mapping[str, Recording],
    priors: PriorSet,
    settings: SearchSettings,
    wire: str,
    bench: Mapping[str, float],
) -> str:
    """Return a short hash of all inputs that determine a search, the simulator included."""
    digest = hashlib.sha256(kernel_source_hash().encode())
    for name, recording in recordings.items():
        digest.update(name.encode())
        digest.update(repr(sorted(recording.metadata.items())).encode())
        for column, values in recording.columns.items():
            digest.update(column.encode())
            digest.update(values.tobytes())
    without_threads = replace(settings, threads=None)
    start = load_wire(wire)
    around = (start.model_dump(), load_alloy(start.alloy).model_dump())
    digest.update(repr((priors.model_dump(), without_threads, around, sorted(bench.items()))).encode())
    return digest.hexdigest()[:16]
