"""The command that finds a wire's physical parameters from recordings: calibrate."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app import (
    MAX_COUNT,
    OVERWRITE,
    REPORT,
    SEED,
    SET,
    THREADS,
    WIRE,
    FigureOptions,
    ReadingOptions,
    Result,
    StoppedCommand,
    mapping,
    option,
    own_help,
    require_free,
    step_bar,
    stop_if_asked,
    stops_between_samples,
    warn,
)
from musclewire.errors import CallerError, MusclewireError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from musclewire.extras.calibration._answer import CalibrateAnswer
    from musclewire.extras.calibration._physical.advice import ExperimentAdvice
    from musclewire.extras.calibration._physical.calibration import Calibration
    from musclewire.extras.calibration._physical.search import SearchSettings
    from musclewire.signals import Recording

PRIORS = option("--priors", help="Priors of the parameters, by name or TOML file.")
EFFORT = option("--effort", help="How long to search: quick, normal or thorough.")
STARTS = option("--starts", help="Descents from the prior; by default depends on --effort.", min=1, max=MAX_COUNT)
JUMPS = option("--jumps", help="Descents from near the best; by default depends on --effort.", min=0, max=MAX_COUNT)

JOURNAL_SUFFIX = ".search"
OWN_FORMAT = (".h5", ".hdf5")


@dataclass(frozen=True)
class StartOptions:
    """What is known before: the wire to start from, the priors, and numbers of the bench."""

    wire: Annotated[str, WIRE] = "paper-100um"
    priors: Annotated[str, PRIORS] = "niti-wire"
    set: Annotated[list[str] | None, SET] = None


@dataclass(frozen=True)
class SearchOptions:
    """How long and from where the search goes."""

    seed: Annotated[int, SEED] = 1
    effort: Annotated[str, EFFORT] = "normal"
    starts: Annotated[int | None, STARTS] = None
    jumps: Annotated[int | None, JUMPS] = None
    threads: Annotated[int | None, THREADS] = None

    def settings(self) -> SearchSettings:
        """Return the settings of the effort with what the user chose otherwise."""
        from musclewire.extras.calibration._physical.search import settings_of_effort

        chosen = {"seed": self.seed, "starts": self.starts, "jumps": self.jumps, "threads": self.threads}
        changes: dict[str, Any] = {name: value for name, value in chosen.items() if value is not None}
        return replace(settings_of_effort(self.effort), **changes)


def calibrate(
    recordings: Annotated[
        list[str], typer.Argument(metavar="RECORDING...", help="Loops and steps with a drive, isobars, cooling curves.")
    ],
    reading: ReadingOptions,
    known: StartOptions,
    search: SearchOptions,
    figure: FigureOptions,
    output: Annotated[
        Path | None, own_help("--output", "Wire file to write (.toml); without, nothing is kept.")
    ] = None,
    report: Annotated[Path | None, REPORT] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Identify the physical parameters of your wire from recordings of it, with uncertainty."""
    from musclewire.extras.calibration._physical.advice import next_experiments
    from musclewire.extras.calibration._physical.calibrate import calibrate as run_calibrate
    from musclewire.extras.calibration._physical.calibration import save_wire
    from musclewire.identify import extrapolation_warnings

    page = report or (output.with_suffix(".html") if output is not None else None)
    require_written(output, ".toml", "a wire", overwrite)
    require_written(page, ".html", "a report", overwrite)
    figure.check()
    settings = search.settings()
    given = {name: read_one(name, reading) for name in distinct(recordings)}
    journal = None if output is None else output.with_name(output.name + JOURNAL_SUFFIX)
    with resumable(journal), stops_between_samples(), step_bar() as on_progress:
        found = run_calibrate(
            given,
            wire=known.wire,
            priors=known.priors,
            bench=mapping(known.set, "--set"),
            settings=settings,
            journal_path=journal,
            on_progress=on_progress,
            on_step=stop_if_asked,
        )
    advice = next_experiments(found)
    warnings = warn(f"{name}: {text}" for name, run in given.items() for text in extrapolation_warnings(run))
    if output is not None:
        save_wire(found, output)
    if page is not None:
        from musclewire.extras.calibration._physical.calibration_report import write_report

        write_report(found, page, advice)
    figure.draw(partial(drawn, found))
    answer = calibrate_answer(found, advice, output, page, warnings)
    failed = None if found.holds else MusclewireError("the fit does not hold: --report shows where")
    return Result(answer, result_text(found, advice, output, page), error=failed)


def drawn(found: Calibration, *, style: str) -> Axes:
    """Return the first recording, measured and fitted; loads what draws only now."""
    from musclewire.extras.calibration._physical.calibration_report import channel_axes

    return channel_axes(found, style=style)


def require_written(path: Path | None, suffix: str, what: str, overwrite: bool) -> None:
    """Raise CallerError for a file of another kind, one that would replace another, or one without a folder."""
    if path is None:
        return
    if path.suffix != suffix:
        raise CallerError(f"{path}: {what} is a {suffix} file, end its name so")
    require_free(path, overwrite)


def distinct(names: list[str]) -> list[str]:
    """Return the names of recordings. Raises CallerError for one that is given twice: it would count twice."""
    for name in names:
        if names.count(name) > 1:
            raise CallerError(f"{name} is given twice: it would count twice, leave one out")
    return names


def read_one(name: str, reading: ReadingOptions) -> Recording:
    """Return a recording with its columns mapped as far as the mapping applies to it, and its strain as requested.

    ``zero`` leaves force as it is, because the load on the wire counts, and isobars, which have one zero of strain.
    """
    recording = replace(reading, column=mappings_for(name, reading.column), zero=False).read(name)
    if not reading.zero or recording.is_isobar_table:
        return recording
    strains = [key for key in ("displacement_m", "reference_strain") if key in recording]
    return recording.with_columns({key: recording[key] - recording[key][0] for key in strains})


def mappings_for(name: str, column: list[str] | None) -> list[str] | None:
    """Return those of the mappings that are for this file: none for our own, by number for files without headers."""
    if not column or Path(name).suffix.lower() in OWN_FORMAT or not Path(name).exists():
        return None
    from musclewire.files import has_headers

    named = has_headers(name)
    return [pair for pair in column if pair.partition("=")[2].lstrip().startswith("#") is not named]


@contextmanager
def resumable(journal: Path | None) -> Iterator[None]:
    """Say to whoever interrupts a search how to resume it."""
    try:
        yield
    except SystemExit as stop:
        kept = journal is not None and journal.exists()
        rest = f"the same command continues where it stopped ({journal})" if kept else "nothing was kept: give -o"
        raise StoppedCommand(stop.code if isinstance(stop.code, int) else 1, rest) from None


def calibrate_answer(
    found: Calibration, advice: Sequence[ExperimentAdvice], output: Path | None, page: Path | None, warnings: list[str]
) -> CalibrateAnswer:
    """Return a calibration, what to measure next, and what was written."""
    from musclewire.extras.calibration._answer import AdvisedExperiment, CalibrateAnswer, CalibratedChannel

    return CalibrateAnswer.read_from(
        found,
        found.inputs,
        parameters={item.name: item for item in found.estimates},
        not_identifiable=[item.name for item in found.not_identifiable],
        channels=[
            CalibratedChannel.read_from(
                pair,
                recording=title,
                channel=pair.channel.name,
                unit=pair.channel.unit,
                rms_in_uncertainties=pair.normalised_rms,
            )
            for title, pair in found.comparisons()
        ],
        correlated=[{"parameters": (one, other), "r": r} for one, other, r in found.correlated],
        simulations=found.search_result.simulations,
        descent_costs=found.search_result.costs,
        seed=found.inputs.settings.seed,
        advice=[AdvisedExperiment.read_from(item, tells=item.identifies) for item in advice],
        recordings=found.inputs.sources,
        started_from=found.inputs.wire,
        priors=found.inputs.priors.name,
        wire=None if output is None else str(output),
        report=None if page is None else str(page),
        warnings=warnings,
    )


def result_text(found: Calibration, advice: Sequence[ExperimentAdvice], output: Path | None, page: Path | None) -> str:
    """Return what was found and what to measure next in words."""
    return "\n".join(
        [
            str(found),
            *(["", "what to measure next:"] if advice else []),
            *(f"  {item.title}: {advice_text(item)}" for item in advice),
            *([] if output is None else ["", f"wire written to {output}"]),
            *([] if page is None else ["", f"open {page}"]),
        ]
    )


def advice_text(item: ExperimentAdvice) -> str:
    """Return what an experiment would add."""
    parts = [f"would identify {', '.join(item.identifies)}"] if item.identifies else []
    parts += [f"would halve the interval of {', '.join(item.narrows)}"] if item.narrows else []
    return "; ".join(parts)
