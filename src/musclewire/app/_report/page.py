"""The report as one HTML file that needs no other file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from markupsafe import Markup

from musclewire.app._report.figures import report_figures
from musclewire.experiment import run_warnings
from musclewire.pages import NumberCard, page
from musclewire.parameters import load_alloy, load_bench, load_wire, read_published
from musclewire.signals import write_text_whole

if TYPE_CHECKING:
    from pathlib import Path

    from musclewire.experiment import DemoResult, StepMetrics

MINIMUM, MAXIMUM = Markup("R<sub>min</sub>"), Markup("R<sub>max</sub>")


def write_report(result: DemoResult, path: Path, wall_s: float) -> None:
    """Write the report of a demo, whole or not at all; ``wall_s`` is the time that the demo took."""
    figures = report_figures(result)
    metadata, step_s = result.run.metadata, result.run.facts.time_step_s
    parts = {
        "cards": key_numbers(result, wall_s),
        "steps": step_rows(result),
        "approach": result.run.metrics.approach,
        "sweep_rows": sweep_rows(result),
        "assumed": parameter_rows(result, "assumed"),
        "fitted": parameter_rows(result, "fitted"),
        "warnings": result.model.warnings,
        "sweep_warnings": result.sweep.warnings,
        "run_warnings": run_warnings(result.run),
        "gap": f"{100 * result.gaps.strain_gap:.2f}",
        "share": f"{100 * result.gaps.segments.transformation_fraction:.0f}",
        "best": None if result.sweep.best is None else f"{result.sweep.best.pretension_n:.2f}",
        "advice": result.sweep.advice,
        "wire": metadata["wire"],
        "seed": metadata["seed"],
        "time_step": f"steps of {1e3 * step_s:g} ms" if step_s else "steps chosen by tolerance",
        "started": metadata["start_time"],
        "files": [file.name for file in result.files.values()],
    }
    write_text_whole(path, page("musclewire.app._report/report.html", **figures, **parts))


def key_numbers(result: DemoResult, wall_s: float) -> list[NumberCard]:
    """Return the key numbers next to the paper's."""
    paper = read_published("lan_fan_2010")["loop_100um"]
    table = read_published("lan_fan_2010")["table2"]
    printed = [*table["mae_rise_pct"], *table["mae_return_pct"]]
    model, metrics = result.model, result.run.metrics
    return [
        error_card("Mean step MAE from cold", metrics.mae_mean_pct, sum(printed) / len(printed)),
        error_card("Largest step MAE from cold", metrics.mae_max_pct, max(printed)),
        NumberCard("Strain gap", f"{100 * result.gaps.strain_gap:.3f} %", f"paper {paper['strain_gap_pct']} %"),
        NumberCard(MINIMUM, f"{model.resistance_min_ohm:.3f} Ω", f"paper {paper['resistance_min_ohm']} Ω"),
        NumberCard(MAXIMUM, f"{model.resistance_max_ohm:.3f} Ω", f"paper {paper['resistance_max_ohm']} Ω"),
        NumberCard("Computed in", f"{wall_s:.1f} s", f"{wire_seconds(result):.0f} s of wire time"),
    ]


def error_card(name: str, found: float | None, paper: float) -> NumberCard:
    """Return the card of an error of the steps; the paper's is after an approach that it does not describe."""
    return NumberCard(name, f"{found:.2f} %", f"paper {paper:.2f} %, after an approach")


def wire_seconds(result: DemoResult) -> float:
    """Return the simulated time of everything the demo ran."""
    swept = sum(row.recording.duration_s for row in result.sweep.rows)
    return sum(loop.duration_s for loop in result.loops.values()) + result.run.duration_s + swept


def paper_mae_pct(step: StepMetrics) -> float | None:
    """Return what the paper printed for this step, None if it printed none."""
    table = read_published("lan_fan_2010")["table2"]
    printed = dict(zip(table["desired_strain_pct"], table[f"mae_{step.direction}_pct"], strict=False))
    return printed.get(round(100 * step.target, 6))


def step_rows(result: DemoResult) -> list[tuple[str, ...]]:
    """Return the rows of the MAE table: each step next to the paper's (Table 2)."""
    return [
        (
            f"{100 * step.target:.1f}",
            step.direction,
            number(step.mae_pct),
            number(paper_mae_pct(step)),
            number(step.estimate_mae_pct),
            number(step.tracking_mae_pct),
        )
        for step in result.run.metrics.steps
    ]


def number(value: float | None) -> str:
    """Return a percentage for a table; a dash for None."""
    return "–" if value is None else f"{value:.3f}"


def sweep_rows(result: DemoResult) -> list[tuple[str, ...]]:
    """Return the rows of the pretension table, the best marked."""
    best = result.sweep.best
    return [
        (
            f"{row.pretension_n:.2f}{' (best)' if row is best else ''}",
            f"{row.strain_gap_pct:.2f}",
            number(row.force_gap_pct),
            f"{row.stroke_pct:.2f}",
        )
        for row in result.sweep.rows
    ]


def parameter_rows(result: DemoResult, kind: str) -> list[tuple[str, ...]]:
    """Return the rows of all parameters of one kind, of alloy, wire and bench."""
    wire = load_wire(result.run.facts.text("wire", "name of the wire"))
    groups = {"alloy": load_alloy(wire.alloy), "wire": wire, "bench": load_bench("paper")}
    return [
        (
            group,
            name,
            f"{item.value:.4g}" + ("" if item.unit == "1" else f" {item.unit}"),
            item.source + (f". {item.note}" if item.note else ""),
        )
        for group, parameters in groups.items()
        for name, item in parameters.items()
        if item.kind == kind
    ]
