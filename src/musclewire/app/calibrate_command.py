"""The command that finds a wire's physical parameters from recordings: calibrate."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app.files import require_folder
from musclewire.app.model_commands import read
from musclewire.app.options import Columns, Force, Invert, Json, Length, Shunt, Zero, mapping
from musclewire.app.output import emit_json, say, show, step_bar
from musclewire.app.stopping import Stopped, stop_if_asked, stops_between_samples
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.identify.physical.calibration import Calibration
    from musclewire.identify.physical.search import Settings
    from musclewire.signals.recording import Recording

__all__ = ["add_calibrate_command"]

JOURNAL_SUFFIX = ".search"
OWN_FORMAT = (".h5", ".hdf5")


def add_calibrate_command(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command()(calibrate)


def calibrate(
    recordings: Annotated[
        list[str], typer.Argument(metavar="RECORDING...", help="Loops and steps with a drive, isobars, cooling curves.")
    ],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Wire file to write (.toml).")] = None,
    wire: Annotated[
        str, typer.Option("--wire", help="Wire to start from, by name or wire file: what is not searched for.")
    ] = "paper-100um",
    priors: Annotated[str, typer.Option("--priors", help="What is known before, by name or TOML file.")] = "niti-wire",
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A number of the bench no recording states. Repeatable."),
    ] = None,
    report: Annotated[
        Path | None, typer.Option("--report", help="Page to write (.html); beside the wire file without it.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the search.")] = 1,
    effort: Annotated[str, typer.Option("--effort", help="quick, normal or thorough.")] = "normal",
    starts: Annotated[
        int | None, typer.Option("--starts", min=1, help="Descents from the prior; by the effort without it.")
    ] = None,
    jumps: Annotated[
        int | None, typer.Option("--jumps", min=0, help="Descents from near the best; by the effort without it.")
    ] = None,
    threads: Annotated[int | None, typer.Option("--threads", min=1, help="All cores without it.")] = None,
    column: Columns = None,
    length: Length = None,
    shunt: Shunt = None,
    zero: Zero = False,
    invert: Invert = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """The physical parameters of your wire from recordings of it, with uncertainty."""
    from musclewire.identify.physical.calibration import calibrate as run_calibrate
    from musclewire.identify.physical.search import settings_of_effort

    page = report or (output.with_suffix(".html") if output is not None else None)
    require_free(output, ".toml", "a wire", force)
    require_free(page, ".html", "a report", force)
    search = chosen(settings_of_effort(effort), seed=seed, starts=starts, jumps=jumps, threads=threads)
    given = {name: read_one(name, column, length, shunt, zero, invert) for name in distinct(recordings)}
    journal = None if output is None else output.with_name(output.name + JOURNAL_SUFFIX)
    with goes_on(journal), stops_between_samples(), step_bar("descents", json) as on_progress:
        found = run_calibrate(
            given,
            wire=wire,
            priors=priors,
            bench=mapping(settings, "--set"),
            settings=search,
            journal_path=journal,
            on_progress=on_progress,
            on_step=stop_if_asked,
        )
    if output is not None:
        found.save(output)
    if page is not None:
        found.report(page)
    if json:
        emit_json(document(found, output, page))
    else:
        show_result(found, output, page)
    if not found.holds:
        raise typer.Exit(1)


def require_free(path: Path | None, suffix: str, what: str, force: bool) -> None:
    """Raise CallerError for a file of another kind, one that would replace another, or one without a folder."""
    if path is None:
        return
    if path.suffix != suffix:
        raise CallerError(f"{path}: {what} is a {suffix} file")
    if path.exists() and not force:
        raise CallerError(f"{path} exists: give another name or --force")
    require_folder(path)


def chosen(settings: Settings, **given: int | None) -> Settings:
    """Return the settings of an effort with what the user chose otherwise."""
    changes: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    return replace(settings, **changes)


def distinct(names: list[str]) -> list[str]:
    """Return the names of recordings. Raises CallerError for one that is given twice: it would count twice."""
    for name in names:
        if names.count(name) > 1:
            raise CallerError(f"{name} is given twice: it would count twice")
    return names


def read_one(
    name: str, column: list[str] | None, length: str | None, shunt: str | None, zero: bool, invert: bool
) -> Recording:
    """Return a recording with its columns mapped as far as the mapping is for it, and its strain as asked for.

    ``zero`` leaves force as it is, because the load on the wire counts, and isobars, which share one zero of strain.
    """
    recording = read(name, meant_for(name, column), length, shunt, False, invert)
    if not zero or recording.is_isobar_table:
        return recording
    strains = [key for key in ("displacement_m", "reference_strain") if key in recording]
    return recording.with_columns({key: recording[key] - recording[key][0] for key in strains})


def meant_for(name: str, column: list[str] | None) -> list[str] | None:
    """Return those of the mappings that are for this file: none for our own, by number for files without headers."""
    if not column or Path(name).suffix.lower() in OWN_FORMAT or not Path(name).exists():
        return None
    from musclewire.signals import has_headers

    named = has_headers(name)
    return [pair for pair in column if pair.partition("=")[2].lstrip().startswith("#") is not named]


@contextmanager
def goes_on(journal: Path | None) -> Iterator[None]:
    """Let whoever interrupts a search know how it goes on."""
    try:
        yield
    except SystemExit as stop:
        kept = journal is not None and journal.exists()
        rest = f"the same command goes on where it stopped ({journal})" if kept else "nothing was kept: give -o"
        raise Stopped(stop.code if isinstance(stop.code, int) else 1, rest) from None


def document(found: Calibration, output: Path | None, page: Path | None) -> dict[str, Any]:
    """Return the answer under the keys of the interface."""
    return {
        **found.as_dict(),
        "advice": [item.as_dict() for item in found.advice],
        "recordings": list(found.asked.sources),
        "started_from": found.asked.wire,
        "priors": found.asked.priors.name,
        "wire": None if output is None else str(output),
        "report": None if page is None else str(page),
    }


def show_result(found: Calibration, output: Path | None, page: Path | None) -> None:
    """Print what was found and what to measure next on stdout."""
    show(str(found))
    if found.advice:
        show("\nwhat to measure next:")
    for item in found.advice:
        show(f"  {item.title}: {advice_words(item.tells, item.narrows)}")
    if output is not None:
        show(f"\nwire written to {output}")
    if page is not None:
        show(f"open {page}")
    if not found.holds:
        say("warning: the fit does not hold; the report shows where")


def advice_words(tells: tuple[str, ...], narrows: tuple[str, ...]) -> str:
    """Say what an experiment would add."""
    parts = [f"would tell {', '.join(tells)}"] if tells else []
    parts += [f"would halve the interval of {', '.join(narrows)}"] if narrows else []
    return "; ".join(parts)
