"""Commands that work on files: fit, with or without an instrument, estimate, tune, rules, cite."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Protocol

import typer

from musclewire.app._answer import AnswerModel
from musclewire.app._figure_options import FigureOptions
from musclewire.app._files import opened_model, require_free, require_model_file
from musclewire.app._options import (
    BIBTEX,
    CLOSED_LOOP_TIME,
    CYCLE,
    ESTIMATOR_OF_A_RECORDING,
    ORDER,
    OVERWRITE,
    QUANTITY,
    RELATIVE_RESISTANCE,
    RULES,
    TUNED_CONTROLLER,
    WIRE_FILE,
    Offered,
    in_si,
    own_help,
)
from musclewire.app._output import Result, table, warn
from musclewire.app._recording_options import ReadingOptions
from musclewire.errors import CallerError, MusclewireError

if TYPE_CHECKING:
    from musclewire.sensing import SensingModel
    from musclewire.signals import Recording


class OtherwiseFitted(Protocol):
    """A model that was not fitted to a motion: how far its stroke may be off; its text says why.

    Of the keys ``misfit``, ``costs`` and ``helps`` of ``fit --json`` it has the attributes that it knows.
    """

    model: SensingModel
    stroke: float
    stroke_std: float


class OtherFit(Protocol):
    """A way to fit that a part offers, ``fits`` of its manifest: a frozen dataclass whose fields are options."""

    def asked_for(self, *, relative_resistance: bool) -> bool:
        """Return whether its options ask for it. Raises CallerError for options that do not go together."""
        ...

    def fit(self, recording: Recording, order: int | str, quantity: str) -> OtherwiseFitted:
        """Return the fit to a recording."""
        ...


RecordingPath = Annotated[
    str,
    typer.Argument(
        metavar="RECORDING",
        help="Recording of musclewire or of another program, or 'lan-fan-2010-table-2', the paper's.",
    ),
]


def fit(
    recording: RecordingPath,
    reading: ReadingOptions,
    others: Annotated[tuple[OtherFit, ...], Offered("fits")],
    figure: FigureOptions,
    output: Annotated[Path | None, own_help("--output", "Model file to write (.json).")] = None,
    order: Annotated[str, ORDER] = "6",
    quantity: Annotated[str, QUANTITY] = "strain",
    cycle: Annotated[str, CYCLE] = "last",
    relative_resistance: Annotated[bool, RELATIVE_RESISTANCE] = False,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Fit the self-sensing model to a slow loop; with --wire from its resistance alone."""
    from musclewire.app._answers import FitAnswer
    from musclewire.identify import estimate as run_estimate
    from musclewire.identify import fit as run_fit

    figure.check()
    if output is not None:
        require_model_file(output)
        require_free(output, overwrite)
    other = next((one for one in others if one.asked_for(relative_resistance=relative_resistance)), None)
    data, chosen = reading.read(recording), whole_number_or(order, "auto")
    alone = None if other is None else other.fit(data, chosen, quantity)
    how = {"order": chosen, "quantity": quantity, "cycle": whole_number_or(cycle)}
    model = alone.model if alone else run_fit(data, **how, relative_resistance=relative_resistance)
    on_recording = None if data.is_branch_table else run_estimate(model, data)
    if output is not None:
        model.save(output)
    figure.draw(model.plot)
    off_pct = None if alone is None else 100.0 * alone.stroke_std / alone.stroke
    written = None if output is None else str(output)
    answer = FitAnswer.read_from(on_recording, alone, **model.report(), stroke_std_pct=off_pct, model=written)
    lines = [model.summary(), *([] if alone is None else [str(alone)])]
    lines.append(
        "the model is in no file yet: -o model.json keeps it" if output is None else f"model written to {output}"
    )
    if on_recording is not None:
        lines.append(f"estimate of this recording: {on_recording.summary()}")
    failed = None if model.holds else MusclewireError(f"this model does not hold: {model.does_not_hold}")
    return Result(answer, "\n".join(lines), error=failed)


def estimate(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model file from 'musclewire fit'.")],
    recording: RecordingPath,
    reading: ReadingOptions,
    figure: FigureOptions,
    estimator: Annotated[str | None, ESTIMATOR_OF_A_RECORDING] = None,
    wire_file: Annotated[Path | None, WIRE_FILE] = None,
    output: Annotated[
        Path | None, own_help("--output", "Recording with its estimate to write (.h5, .csv, .parquet, .mat, .xlsx).")
    ] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Estimate strain from a recording's resistance; errors where it has a reference."""
    from musclewire.signals import require_format

    figure.check()
    if output is not None:
        require_free(output, overwrite)
        require_format(output)
    from musclewire.app._answers import EstimateAnswer
    from musclewire.identify import estimate as run_estimate

    report = run_estimate(opened_model(model), reading.read(recording), estimator=estimator, wire_file=wire_file)
    if output is not None:
        report.recording.save(output)
    figure.draw(report.plot)
    warn(report.warnings)
    failed = MusclewireError("this is not the estimate that was asked for") if report.fell_back else None
    return Result(EstimateAnswer.read_from(report, samples=len(report.recording)), report.summary(), error=failed)


def rules(
    figure: FigureOptions,
    name: Annotated[str, typer.Argument(metavar="[RULES]", help="Name of a rule base, or a TOML file.")] = "zhao-1993",
) -> Result:
    """Show a fuzzy rule base, and its surfaces with --plot."""
    from musclewire.app._answers import RulesAnswer
    from musclewire.controllers import load_rule_base, plot_rule_surfaces, rule_base_names

    figure.check()
    rule_base = load_rule_base(name)
    figure.draw(lambda style: plot_rule_surfaces(rule_base, style=style)[0])
    lines = [str(rule_base)]
    for name_of_table, rows in rule_base.rules.model_dump().items():
        if isinstance(rows, (list, tuple)):
            lines += ["", f"{name_of_table}: rows error NB..PB, columns change of error NB..PB"]
            lines.append(table([""] * len(rows[0]), rows, left=()))
    known = rule_base_names()
    answer = RulesAnswer(known=known, **rule_base.model_dump())
    return Result(answer, "\n".join([*lines, "", f"known: {', '.join(known)}"]))


@dataclass(frozen=True)
class CitedWork:
    """A work to cite: its fields as BibTeX has them, and what in musclewire it is the source of."""

    key: str
    kind: str
    of: str
    fields: Mapping[str, str]

    @property
    def line(self) -> str:
        """The work in one line."""
        where = "".join(f", {self.fields[name]}" for name in ("journal", "volume", "pages") if name in self.fields)
        number = f" {self.fields['version']}" if "version" in self.fields else ""
        doi = f", doi {self.fields['doi']}" if "doi" in self.fields else ""
        authors = self.fields["author"].strip("{}").replace(" and ", ", ")
        return f"{authors}, {self.fields['year']}: {self.fields['title']}{number}{where}{doi} ({self.of})"

    @property
    def bibtex(self) -> str:
        """The work as an entry of BibTeX; braces keep the capitals of a title."""
        fields = {**self.fields, "title": f"{{{self.fields['title']}}}"}
        return "\n".join([f"@{self.kind}{{{self.key},", *(f"  {key} = {{{fields[key]}}}," for key in fields), "}"])


class CiteAnswer(AnswerModel):
    """Of ``cite``."""

    cite: tuple[str, ...]
    bibtex: tuple[str, ...]


def cite(bibtex: Annotated[bool, BIBTEX] = False) -> Result:
    """Print the references to cite; --bibtex as entries of BibTeX."""
    works = cited_works()
    answer = CiteAnswer(cite=tuple(one.line for one in works), bibtex=tuple(one.bibtex for one in works))
    return Result(answer, "\n\n".join(answer.bibtex) if bibtex else "\n".join(answer.cite))


def cited_works() -> tuple[CitedWork, ...]:
    """Return the works to cite: musclewire itself, the paper, and the sources of what a run needs by default."""
    from importlib.metadata import version

    from musclewire.parameters import read_published

    paper = read_published("lan_fan_2010")
    return (
        CitedWork(
            "musclewire",
            "software",
            "BSD-3-Clause; see CITATION.cff",
            {
                "author": "{The musclewire developers}",
                "title": "musclewire",
                "year": "2026",
                "version": version("musclewire"),
            },
        ),
        CitedWork(
            "lan_fan_2010",
            "misc",
            "method: Eqs. 1 to 7",
            {
                "author": paper["authors"].replace(", ", " and "),
                "title": paper["title"],
                "year": str(paper["year"]),
            },
        ),
        CitedWork(
            "zhao_1993",
            "article",
            "rule base zhao-1993",
            {
                "author": "Z.-Y. Zhao and M. Tomizuka and S. Isaka",
                "title": "Fuzzy gain scheduling of PID controllers",
                "journal": "IEEE Transactions on Systems, Man, and Cybernetics",
                "volume": "23",
                "number": "5",
                "pages": "1392--1398",
                "year": "1993",
                "doi": "10.1109/21.260670",
            },
        ),
        CitedWork(
            "churchill_chu_1975",
            "article",
            "simulated wires",
            {
                "author": "S. W. Churchill and H. H. S. Chu",
                "title": "Correlating equations for laminar and turbulent free convection from a horizontal cylinder",
                "journal": "International Journal of Heat and Mass Transfer",
                "year": "1975",
                "doi": "10.1016/0017-9310(75)90222-7",
            },
        ),
    )


def whole_number_or(text: str, *words: str) -> Any:
    """Return a whole number, or the text itself if it is one of the words (any text without words)."""
    try:
        return int(text)
    except ValueError:
        if words and text not in words:
            raise CallerError(
                f"'{text}' is neither a whole number nor {' or '.join(words)}: write one of these"
            ) from None
        return text


def tune(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model file from 'musclewire fit'.")],
    recording: RecordingPath,
    reading: ReadingOptions,
    figure: FigureOptions,
    output: Annotated[Path | None, own_help("--output", "Model (.json) or gains file (.toml) to write.")] = None,
    controller: Annotated[str, TUNED_CONTROLLER] = "inverse-model",
    rules: Annotated[str | None, RULES] = None,
    closed_loop_time: Annotated[str | None, CLOSED_LOOP_TIME] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Find a controller's gains from the slow loop, by a published rule; -o keeps them in a .json model or .toml."""
    from musclewire.app._answers import TuneAnswer
    from musclewire.identify import tune as run_tune

    figure.check()
    if output is not None and output.suffix == ".json":
        require_model_file(output)
        # The gains go into the model that they were found for, as a rule.
        require_free(output, overwrite or output.resolve() == model.resolve())
    elif output is not None:
        require_free(output, overwrite)
    loaded = opened_model(model)
    found = run_tune(
        loaded,
        reading.read(recording),
        controller=controller,
        closed_loop_time_s=in_si("--closed-loop-time", closed_loop_time),
        rule_base=rules,
    )
    text = str(found)
    if output is not None and output.suffix == ".json":
        found.kept_in(loaded).save(output)
        text += f"\nmodel with these gains written to {output}"
    elif output is not None:
        found.save(output)
        text += f"\ngains written to {output}"
    figure.draw(found.plot)
    answer = TuneAnswer(**found.report(), gains=None if output is None else str(output))
    return Result(answer, text)
