"""What the benchmark found as text: tables for people, CSV for spreadsheets, rows for programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

from musclewire.app import AnswerModel
from musclewire_robustness.benchmark import Robustness
from musclewire_robustness.grips import GripRow
from musclewire_robustness.rows import EstimatorRow


class RobustnessRow(AnswerModel):
    """A row of an estimator; null what could not be found."""

    disturbance: str
    level: str
    estimator: str
    estimate_rms_pct: float | None = None
    beyond_5_share: float | None = None
    valid_share: float | None = None
    flagged_s: float | None = None
    estimate_rms_new_zero_pct: float | None = None
    estimate_rms_counted_pct: float | None = None
    one_segment_rms_pct: float | None = None
    segmented_rms_pct: float | None = None
    worst_wire_seed: int | None = None
    worst_wire_rms_pct: float | None = None
    interval_coverage: float | None = None
    interval_half_width_pct: float | None = None
    noted_share: float | None = None
    flagged_share: float | None = None
    valid_before_b_fraction: float | None = None
    flags_in_time_fraction: float | None = None
    false_flags_per_hour: float | None = None
    force_rms_pct: float | None = None
    ended_early: int | None = None
    home_moves_refused: int | None = None
    problem: str


COLUMNS = tuple(RobustnessRow.model_fields)


def estimator_answer(row: EstimatorRow) -> RobustnessRow:
    """Return an estimator's row."""
    score, worst = row.score, row.worst
    return RobustnessRow.read_from(
        row,
        score,
        disturbance=row.condition.disturbance,
        level=row.condition.level,
        estimate_rms_pct=score.rms_pct,
        estimate_rms_new_zero_pct=score.rms_new_zero_pct,
        estimate_rms_counted_pct=row.counted_pct,
        one_segment_rms_pct=row.one_segment_pct,
        segmented_rms_pct=row.segmented_pct,
        worst_wire_seed=None if worst is None else worst.seed,
        worst_wire_rms_pct=None if worst is None else worst.counted_pct,
        interval_coverage=score.coverage,
        valid_before_b_fraction=score.valid_cold_fraction,
        force_rms_pct=row.force.rms_pct,
        ended_early=row.ended,
        home_moves_refused=row.refused,
    )


def rows_answer(result: Robustness) -> list[RobustnessRow]:
    """Return all rows."""
    return [*map(estimator_answer, result.estimators)]


def csv_text(result: Robustness) -> str:
    """Return all rows as CSV with a header."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(row.model_dump() for row in rows_answer(result))
    return text.getvalue()


def table_text(result: Robustness) -> str:
    """Return what the benchmark found as lines for people."""
    parts = [
        f"{len(result.seeds)} wires, {result.seeds_text}; references: {', '.join(result.references)}",
        "",
        "Error of the estimate, rms in percent of the full stroke, in the usable range; the instruments' zero kept.",
        *error_lines(result),
        "",
        "The zero taken again, the fraction that is valid, of it unflagged and beyond 5 %, 95 % intervals that hold "
        "and their median half-width, samples noted and flagged, flags, force.",
        *honest_lines(result.estimators),
    ]
    if result.grips:
        parts += ["", "Held force of a grip, in percent of the target.", *grip_lines(result.grips)]
    return "\n".join([*parts, "", *bar_lines(result)])


def bar_lines(result: Robustness) -> list[str]:
    """Return how many bars hold, and which do not, by whether the committed list has them."""
    known = [one for one in result.missed if one.known_reason is not None]
    lines = [
        f"{len(result.verdicts) - len(result.missed)} of {len(result.verdicts)} bars hold; missed as expected: "
        f"{len(known)}; missed unexpectedly: {len(result.new_misses)}; held although expected to miss: "
        f"{len(result.repaired)}"
    ]
    groups = (
        ("missed as expected", known),
        ("missed unexpectedly, not on the committed list", result.new_misses),
        ("held although expected to miss", result.repaired),
    )
    for title, verdicts in groups:
        lines += [f"{title}:"] if verdicts else []
        by_reason: dict[str, list[str]] = {}
        for one in verdicts:
            by_reason.setdefault(one.known_reason or "", []).append(f"  {one}")
        for reason, bars in by_reason.items():
            lines += [*bars, *([f"    {reason}"] if reason else [])]
    return lines


def number(value: float | None, digits: int = 2) -> str:
    """Return a number, or a dash for none."""
    return "-" if value is None else f"{value:.{digits}f}"


def columns(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return rows as lines, the first column to the left and all others to the right."""
    table = [head, *rows]
    widths = [max(len(row[place]) for row in table) for place in range(len(head))]
    lines = []
    for row in table:
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        lines.append("  ".join(cells).rstrip())
    return lines


def error_lines(result: Robustness) -> list[str]:
    """Return the errors of all estimators as a table."""
    names = list(dict.fromkeys(row.estimator for row in result.estimators))
    rows = {(row.condition.name, row.estimator): row for row in result.estimators}
    return columns(
        ["", *names],
        [[item.name, *(number(rows[item.name, name].score.rms_pct) for name in names)] for item in result.conditions],
    )


def honest_lines(rows: Sequence[EstimatorRow]) -> list[str]:
    """Return what estimators say of themselves as a table."""
    return columns(
        [
            "",
            "estimator",
            "new zero",
            "valid",
            "beyond 5 %",
            "intervals",
            "half %",
            "noted",
            "flagged",
            "flagged s",
            "in time",
            "force",
            "worst wire",
        ],
        [
            [
                row.condition.name,
                row.estimator,
                number(row.score.rms_new_zero_pct),
                number(row.score.valid_share, 3),
                number(row.score.beyond_5_share, 4),
                number(row.score.coverage, 3),
                number(row.score.interval_half_width_pct),
                number(row.score.noted_share, 3),
                number(row.score.flagged_share, 3),
                number(row.score.flagged_s, 1),
                number(row.score.flags_in_time_fraction),
                number(row.force.rms_pct),
                "-" if row.worst is None else f"{row.worst.seed}: {number(row.worst.rms_pct)}",
            ]
            for row in rows
        ],
    )


def grip_lines(rows: Sequence[GripRow]) -> list[str]:
    """Return the grips as a table."""
    return columns(
        ["", "error, mean", "largest", "of the estimate", "held"],
        [
            [
                row.condition,
                number(row.held_mean_pct, 1),
                number(row.held_max_pct, 1),
                number(row.estimate_mean_pct, 1),
                f"{row.held} of {row.grips}",
            ]
            for row in rows
        ],
    )
