"""What a study leaves in its folder: the data set, the sensitivity table, and a page that needs no other file."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from musclewire.extras.studies._data_set import require_extra, write_data
from musclewire.extras.studies._folder import StudyFolder
from musclewire.extras.studies._plan import engine
from musclewire.extras.studies._sensitivity import Sensitivity, sensitivity_of, sensitivity_text
from musclewire.extras.studies._study import StudyResult
from musclewire.extras.studies._study_figures import (
    distribution_figure,
    index_figure,
    numbers_of,
    over_parameters_figure,
    series_figure,
)
from musclewire.pages import NumberCard, page, svg_in_frame
from musclewire.signals import write_text_whole

# A page with more figures than this is read by nobody; the data set has everything.
MAX_FIGURES = 12
MAX_FAILURES = 8
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def require_packages() -> None:
    """Raise MissingExtraError, before anything is computed, if a package is missing that writing a study needs."""
    require_extra("a study with data set and sensitivity table", "pyarrow", "xarray", "SALib")


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
    require_packages()
    kept = StudyFolder(Path(folder), result.plan)
    indices = sensitivity_of(result.plan.design, result.columns, result.plan.file.seed)
    write_data(kept.data, result.plan, result.columns, result.errors, result.texts)
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
            (name, svg_in_frame(over_parameters_figure(result, name), f"over-{name}")) for name in numbers[:MAX_FIGURES]
        ],
        series=[svg_in_frame(series_figure(result, name), f"series-{name}") for name in series[:MAX_FIGURES]],
        indices=[
            (row.quantity, row.parameter, row.method, *("–" if value is None else f"{value:.3f}" for value in row[3:]))
            for row in indices
        ],
        index_figure=svg_in_frame(index_figure(indices), "indices") if indices else "",
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
        NumberCard("Parameters", f"{len(design.names)}", f"seed {result.plan.file.seed}"),
    ]


def parameter_rows(result: StudyResult) -> list[tuple[str, ...]]:
    """Return what varied, and between which values."""
    design = result.plan.design
    rows: list[tuple[str, ...]] = []
    for name in design.names:
        column = design.column(name)
        different = np.unique(column)
        how = "grid" if name in {axis.name for axis in design.axes} else design.method
        is_number = column.dtype.kind in "fiu"
        ends = (f"{column.min():.6g}", f"{column.max():.6g}") if is_number else (", ".join(map(str, different)), "")
        rows.append((name, design.units[name], how, *ends, str(different.size)))
    return rows


def quantity_rows(result: StudyResult, names: Sequence[str]) -> list[tuple[str, ...]]:
    """Return the distribution of each quantity in numbers."""
    rows = []
    for name in names:
        values = result.columns[name][np.isfinite(result.columns[name])]
        spread = (values.min(), *np.percentile(values, (5.0, 50.0, 95.0)), values.max(), values.mean(), values.std())
        rows.append((name, result.plan.keep[name].unit, *(f"{value:.5g}" for value in spread), str(values.size)))
    return rows
