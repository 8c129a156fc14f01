"""What a study leaves in its folder: the data set, the sensitivity table, and a page that needs no other file."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, require_extra
from musclewire.extras.studies._data_set import write_data
from musclewire.extras.studies._folder import StudyFolder
from musclewire.extras.studies._plan import engine
from musclewire.extras.studies._sensitivity import Sensitivity, sensitivity_of, sensitivity_text
from musclewire.extras.studies._study import StudyResult
from musclewire.figures import panel_grid
from musclewire.pages import AVERAGE, COOLING, HEATING, STYLE, TARGET, NumberCard, page, svg_in_frame
from musclewire.signals import write_text_whole

WIDTH = 9.6  # [in] of a figure
ROW_HEIGHT = 2.5  # [in] of a row of panels
COLUMNS = 4  # panels in a row
KELVIN_AT_0_DEGC = 273.15
# Numbers whose names end so are shown in percent.
PERCENT = ("gap", "stroke", "strain", "fraction", "rmse")
EXTREMES = {"min": "least", "max": "largest", "mean": "mean"}
WORDS = {"mae": "error", "rms": "rms error", "rmse": "rms error"}
# The look of all pages, with powers of ten for numbers as small as a diameter in metres.
LOOK: Mapping[Any, Any] = {**STYLE, "axes.formatter.limits": (-3, 5)}
# A cloud of more points than this hides itself; they are taken evenly from all runs.
MAX_POINTS = 3000
# As many runs of a series are drawn one by one.
MAX_LINES = 40
BINS = 40
# Values of a parameter that a plot shows with their mean: an axis of the grid, and not a cloud.
MAX_LEVELS = 60


def panels(number: int, columns: int = COLUMNS) -> tuple[Figure, list[Any]]:
    """Return a figure and its axes, row by row."""
    columns = min(columns, number)
    rows = -(-number // columns)
    figure = Figure(figsize=(WIDTH if columns > 2 else 0.55 * WIDTH, rows * ROW_HEIGHT), layout="constrained")
    axes = np.atleast_1d(figure.subplots(rows, columns, squeeze=False)).ravel().tolist()
    for unused in axes[number:]:
        unused.set_visible(False)
    return figure, axes[:number]


class ShownColumn(NamedTuple):
    """A column of the data set as people read it: its name in words, its unit, and how its numbers become that."""

    words: str
    unit: str
    factor: float = 1.0
    zero: float = 0.0

    @property
    def label(self) -> str:
        """The label of an axis."""
        return f"{self.words} [{self.unit}]" if self.unit else self.words

    def from_si(self, values: Any) -> Any:
        """Return SI values in the shown unit; text stays as it is."""
        return self.factor * (values - self.zero) if np.asarray(values).dtype.kind in "fiu" else values


def shown_column(name: str, unit: str) -> ShownColumn:
    """Return how a quantity or parameter of this name and SI unit is shown."""
    if name.endswith("_pct"):
        return ShownColumn(in_words(name.removesuffix("_pct")), "%")
    words = in_words(name.removesuffix(f"_{unit.lower().replace('/', '_per_')}"))
    if unit == "K" and "temperature" in name:
        return ShownColumn(words, "°C", 1.0, KELVIN_AT_0_DEGC)
    if unit == "1" and name.endswith(PERCENT):
        return ShownColumn(words, "%", 100.0)
    known = {"m": ("mm", 1e3), "Pa": ("MPa", 1e-6), "1": ("", 1.0)}
    return ShownColumn(words, *known.get(unit, (unit, 1.0)))


def in_words(name: str) -> str:
    """Return a name in the code as words, what it is the least, largest or mean of first."""
    words = name.replace(".", " ").split("_")
    first = [EXTREMES[word] for word in words if word in EXTREMES]
    return " ".join([*first, *(WORDS.get(word, word) for word in words if word not in EXTREMES)])


def distribution_figure(result: StudyResult, names: Sequence[str]) -> Figure:
    """Draw how often each value of each quantity occurs."""
    with mpl.rc_context(dict(LOOK)):
        figure, axes = panels(len(names))
        draw_distributions(axes, result, names, 4)
    return figure


def draw_distributions(axes: Sequence[Any], result: StudyResult, names: Sequence[str], ticks: int) -> None:
    """Draw how often each value of each quantity occurs, a panel for each with so many ticks at most."""
    for axis, name in zip(axes, names, strict=True):
        shown = shown_column(name, result.plan.keep[name].unit)
        values = shown.from_si(result.columns[name][np.isfinite(result.columns[name])])
        axis.hist(values, bins=BINS, color=COOLING, alpha=0.85)
        axis.axvline(float(np.median(values)), color=AVERAGE, linewidth=1.2)
        axis.set_xlabel(shown.label)
        axis.set_ylabel("runs" if axis is axes[0] else "")
        axis.locator_params(axis="x", nbins=ticks)
        axis.set_axisbelow(True)


def distributions(result: StudyResult, *, style: str = "screen") -> Figure:
    """Draw how often each value of each kept quantity occurs, with the median; CallerError if no run gave a number."""
    names = numbers_of(result)
    if not names:
        raise CallerError(f"there is nothing to plot: none of {len(result)} runs gave a number, look at its errors")
    figure, axes = panel_grid(style, len(names), COLUMNS)
    with figure.styled(), mpl.rc_context({"axes.formatter.limits": LOOK["axes.formatter.limits"]}):
        draw_distributions(axes, result, names, 3)
    return figure


def numbers_of(result: StudyResult) -> list[str]:
    """Return the names of the kept quantities that are a number for each run, and finite for one at least."""
    return [name for name, column in result.columns.items() if column.ndim == 1 and np.isfinite(column).any()]


def over_parameters_figure(result: StudyResult, name: str) -> Figure:
    """Draw a quantity over each parameter: a point for each run, and the mean over the values of a grid's axis."""
    design, quantity = result.plan.design, shown_column(name, result.plan.keep[name].unit)
    values = quantity.from_si(result.columns[name])
    varied = [parameter for parameter in design.names if np.unique(design.column(parameter)).size > 1]
    with mpl.rc_context(dict(LOOK)):
        figure, axes = panels(max(len(varied), 1))
        for axis, parameter in zip(axes, varied, strict=False):
            shown = shown_column(parameter, design.units[parameter])
            cloud(axis, shown.from_si(design.column(parameter)), values)
            axis.set_xlabel(shown.label)
            axis.set_ylabel(quantity.label if axis is axes[0] else "")
    return figure


def cloud(axis: Any, at: np.ndarray[Any, Any], values: FloatArray) -> None:
    """Draw values over a parameter."""
    finite = np.flatnonzero(np.isfinite(values))
    shown = finite[:: max(1, -(-finite.size // MAX_POINTS))]
    levels, place = np.unique(at, return_inverse=True)
    is_text = at.dtype.kind not in "fiu"
    across = place.astype(np.float64) if is_text else at.astype(np.float64)
    # As points of a picture inside the drawing: thousands of vector circles would make a page of megabytes.
    axis.plot(across[shown], values[shown], ".", markersize=3, color=COOLING, alpha=0.4, rasterized=True)
    if levels.size <= min(MAX_LEVELS, at.size // 2):
        means = [float(values[finite[place[finite] == level]].mean()) if (place[finite] == level).any() else np.nan
                 for level in range(levels.size)]  # fmt: skip
        axis.plot(np.unique(across), means, color=HEATING)
    if is_text:
        axis.set_xticks(range(levels.size), [str(level)[-18:] for level in levels], rotation=30)
    else:
        axis.locator_params(axis="x", nbins=4)


def series_figure(result: StudyResult, name: str) -> Figure:
    """Draw a series of some runs over their samples, with the median of all runs."""
    shown = shown_column(name, result.plan.keep[name].unit)
    rows = shown.from_si(result.columns[name][np.isfinite(result.columns[name]).any(axis=1)])
    with mpl.rc_context(dict(LOOK)):
        figure, axes = panels(1)
        for row in rows[:: max(1, -(-len(rows) // MAX_LINES))]:
            axes[0].plot(row, color=TARGET, linewidth=0.6, alpha=0.7)
        axes[0].plot(np.nanmedian(rows, axis=0), color=AVERAGE)
        axes[0].set_xlabel("sample")
        axes[0].set_ylabel(shown.label)
    return figure


def index_figure(result: StudyResult, rows: Sequence[Sensitivity]) -> Figure:
    """Draw first and total indices, and PAWN's, of each quantity as bars."""
    quantities = list(dict.fromkeys(row.quantity for row in rows))
    with mpl.rc_context(dict(LOOK)):
        figure, axes = panels(len(quantities), 2)
        parameters = len({row.parameter for row in rows})
        figure.set_size_inches(WIDTH, max(1.4, 0.5 + 0.32 * parameters) * -(-len(quantities) // 2))
        for axis, quantity in zip(axes, quantities, strict=True):
            here = [row for row in rows if row.quantity == quantity]
            bars(axis, here)
            axis.set_yticks(range(len(here)), [parameter_words(result, row.parameter) for row in here])
            axis.set_title(quantity_words(result, quantity), fontsize=9.5, loc="left")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def quantity_words(result: StudyResult, name: str) -> str:
    """Return a quantity in words."""
    return shown_column(name, result.plan.keep[name].unit).words


def parameter_words(result: StudyResult, name: str) -> str:
    """Return a parameter in words."""
    return shown_column(name, result.plan.design.units[name]).words


def bars(axis: Any, rows: Sequence[Sensitivity]) -> None:
    """Draw the indices of one quantity."""
    kinds = {"first": COOLING, "total": HEATING, "pawn": TARGET}
    names = {
        "first": "alone (first index)",
        "total": "with interactions (total index)",
        "pawn": "on the whole distribution (PAWN)",
    }
    known = {kind: colour for kind, colour in kinds.items() if any(getattr(row, kind) is not None for row in rows)}
    height = 0.8 / len(known)
    for place, (kind, colour) in enumerate(known.items()):
        lengths = [max(getattr(row, kind) or 0.0, 0.0) for row in rows]
        errors = None if kind == "pawn" else [getattr(row, f"{kind}_error") or 0.0 for row in rows]
        at = np.arange(len(rows)) + (place - 0.5 * (len(known) - 1)) * height
        axis.barh(at, lengths, height, xerr=errors, color=colour, label=names[kind], error_kw={"linewidth": 0.8})
    axis.invert_yaxis()
    axis.set_xlim(0.0, None)


# A page with more figures than this is read by nobody; the data set has everything.
MAX_FIGURES = 12
MAX_FAILURES = 8
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def write_study(result: StudyResult, folder: str | Path) -> list[Path]:
    """Write the data set, the sensitivity table and the page of a study; its chunks, now in the data set, are deleted.

    Parameters
    ----------
    result
        The study with all runs, as ``sweep`` returns it.
    folder
        Folder of the study, the one that ``sweep`` was given.

    Returns
    -------
    The files ``data.parquet``, ``sensitivity.csv`` and ``report.html``.

    Raises
    ------
    MissingExtraError
        If the extra ``sweep`` is not installed.
    CallerError
        If the folder belongs to another study or cannot be written to.
    """
    require_extra("a study with data set and sensitivity table", "sweep")
    kept = StudyFolder(Path(folder), result.plan)
    indices = sensitivity_of(result.plan.design, result.columns, result.plan.file.seed)
    write_data(kept.data, result.plan, result.columns, result.errors, result.texts, result.overheated)
    write_text_whole(kept.table, sensitivity_text(indices))
    write_text_whole(kept.page, page_text(result, indices))
    kept.remove_chunks()
    return [kept.data, kept.table, kept.page]


def page_text(result: StudyResult, indices: Sequence[Sensitivity]) -> str:
    """Return the page of a study."""
    plan = result.plan
    numbers = numbers_of(result)
    series = [name for name, column in result.columns.items() if column.ndim == 2 and np.isfinite(column).any()]
    known = Counter(NUMBER.sub("#", text) for text in result.errors if text)
    # The same error in many runs differs by its numbers: one of them is shown for all.
    examples = {NUMBER.sub("#", text): text for text in reversed(result.errors) if text}
    return page(
        "musclewire.extras.studies/study.html",
        title=plan.file.name,
        description=plan.file.description or "A study of simulated wires.",
        cards=key_numbers(result),
        parameters=parameter_rows(result),
        quantities=quantity_rows(result, numbers),
        distributions=svg_in_frame(distribution_figure(result, numbers), "distributions") if numbers else "",
        over=[
            (
                quantity_words(result, name),
                plan.keep[name].meaning,
                svg_in_frame(over_parameters_figure(result, name), f"over-{name}"),
            )
            for name in numbers[:MAX_FIGURES]
        ],
        series=[svg_in_frame(series_figure(result, name), f"series-{name}") for name in series[:MAX_FIGURES]],
        indices=[
            (
                quantity_words(result, row.quantity),
                parameter_words(result, row.parameter),
                row.method,
                *("–" if value is None else f"{value:.3f}" for value in row[3:]),
            )
            for row in indices
        ],
        index_figure=svg_in_frame(index_figure(result, indices), "indices") if indices else "",
        failed=result.failed,
        failures=[(count, examples[words]) for words, count in known.most_common(MAX_FAILURES)],
        more_failures=max(len(known) - MAX_FAILURES, 0),
        study=json.dumps(plan.file.model_dump(mode="json", exclude_none=True, exclude_defaults=True), indent=2),
        engine=engine(),
        fingerprint=plan.fingerprint,
    )


def key_numbers(result: StudyResult) -> list[NumberCard]:
    """Return the key numbers of a study."""
    design = result.plan.design
    sampled = f"{len(design.samples)} samples ({design.method})" if design.method else ""
    grid = f"{design.points} points of a grid" if design.axes else ""
    return [
        NumberCard("Runs", f"{len(result)}", " x ".join(text for text in (grid, sampled) if text) or "one setting"),
        NumberCard("Kind", str(result.plan.file.run["kind"]), f"{len(result.plan.keep)} quantities kept"),
        NumberCard("Failed", f"{result.failed}", "runs without a result", ok=result.failed == 0),
        *(
            [NumberCard("Too hot", f"{len(result.overheated)}", "wires beyond their limit", ok=False)]
            if result.overheated
            else []
        ),
        NumberCard("Parameters", f"{len(design.names)}", f"seed {result.plan.file.seed}"),
    ]


def parameter_rows(result: StudyResult) -> list[tuple[str, ...]]:
    """Return what varied, and between which values."""
    design = result.plan.design
    rows: list[tuple[str, ...]] = []
    for name in design.names:
        shown = shown_column(name, design.units[name])
        column = shown.from_si(design.column(name))
        different = np.unique(column)
        how = "grid" if name in {axis.name for axis in design.axes} else design.method
        is_number = column.dtype.kind in "fiu"
        ends = (f"{column.min():.6g}", f"{column.max():.6g}") if is_number else (", ".join(map(str, different)), "")
        rows.append((shown.words, shown.unit, how, *ends, str(different.size), name))
    return rows


def quantity_rows(result: StudyResult, names: Sequence[str]) -> list[tuple[str, ...]]:
    """Return the distribution of each quantity in numbers."""
    rows = []
    for name in names:
        shown = shown_column(name, result.plan.keep[name].unit)
        values = shown.from_si(result.columns[name][np.isfinite(result.columns[name])])
        spread = (values.min(), *np.percentile(values, (5.0, 50.0, 95.0)), values.max(), values.mean(), values.std())
        rows.append((shown.words, shown.unit, *(f"{value:.5g}" for value in spread), str(values.size), name))
    return rows
