"""A recording as a picture: over time, a run of control with its errors and drive; a loop with points A, B and C."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.figures import StyledFigure, one_panel, panel_rows, panels_side_by_side
from musclewire.identify._loop_gaps import LoopGaps, loop_gaps
from musclewire.identify._recordings import required_quantity
from musclewire.judge import resistance_reading
from musclewire.pages import AVERAGE, COOLING, HEATING, PAPER, TARGET
from musclewire.sensing import SHOWN_AS
from musclewire.signals import COLUMN_SUFFIX, reference_quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from musclewire.signals import Recording


KELVIN_AT_0_DEGC = 273.15


def loop_figure(recording: Recording, style: str) -> StyledFigure:
    """Draw movement against resistance, with A, B and C of the last loop, and against drive voltage if there is one."""
    resistance = np.where((reading := resistance_reading(recording)).valid, reading.resistance_ohm, np.nan)
    movement, label = movement_of(recording)
    drive = recording.columns.get("drive_voltage_v")
    figure, panels = panels_side_by_side(style, 1 if drive is None else 2)
    with figure.styled():
        across = [(resistance, "resistance [ohm]"), *([] if drive is None else [(drive, "drive voltage [V]")])]
        gaps, why = gaps_of(recording)
        for axes, (values, name) in zip(reversed(panels), across, strict=True):
            draw_branches(axes, values, movement, gaps, recording)
            axes.set(xlabel=name, ylabel=label)
        if gaps is None:
            panels[-1].set_title(f"no points A, B, C: {why.split(';')[0].split(':')[0]}", fontsize="small", wrap=True)
        else:
            mark_points(panels[-1], resistance, movement, gaps)
            panels[0].legend(loc="best")
    return figure


def movement_of(recording: Recording) -> tuple[FloatArray, str]:
    """Return strain [%] or, where the wire's length is not known, displacement [mm], with the axis' label."""
    strain = reference_quantity(recording, "strain")
    if strain is not None:
        return 100.0 * strain, "strain [%]"
    return 1e3 * required_quantity(recording, "displacement"), "displacement [mm]"


def gaps_of(recording: Recording) -> tuple[LoopGaps | None, str]:
    """Return the last loop's points, or None and why there are none."""
    try:
        return loop_gaps(recording), ""
    except RecordingError as error:
        return None, str(error)


def draw_branches(axes: Axes, x: FloatArray, y: FloatArray, gaps: LoopGaps | None, recording: Recording) -> None:
    """Draw all cycles in grey and both branches of the analysed one in colour; one line where no loop was found."""
    if gaps is None:
        axes.plot(x, y, color=AVERAGE)
        return
    if "cycle" in recording and np.ptp(recording["cycle"]) > 0:
        axes.plot(x, y, color=TARGET, linewidth=0.6, label="other cycles")
    for part, colour, name in zip(halves(gaps), (HEATING, COOLING), ("heating", "cooling"), strict=True):
        axes.plot(x[part], y[part], color=colour, label=name)


def halves(gaps: LoopGaps) -> tuple[slice, slice]:
    """Return heating and cooling of the analysed cycle, whole branches A to C and C to A, as row slices."""
    found = gaps.segments
    return slice(found.heating_a, found.heating_c + 1), slice(found.heating_c, found.cooling_a + 1)


def mark_points(axes: Axes, resistance_ohm: FloatArray, movement: FloatArray, gaps: LoopGaps) -> None:
    """Write A, B and C at their places on the heating branch, and B on the cooling branch."""
    found = gaps.segments
    places = (
        ("A", found.heating_a, HEATING, (-5, 5), "right"),
        ("B", found.heating_b, HEATING, (5, 4), "left"),
        ("C", found.heating_c, AVERAGE, (-5, 4), "right"),
        ("B", found.cooling_b, COOLING, (-7, 0), "right"),
    )
    for letter, row, colour, offset, side in places:
        place = (resistance_ohm[row], movement[row])
        axes.plot(*place, "o", color=colour, zorder=5)
        axes.annotate(
            letter, place, xytext=offset, textcoords="offset points", ha=side, color=colour, fontweight="bold"
        )
    axes.margins(x=0.12, y=0.1)


def table_figure(recording: Recording, style: str) -> StyledFigure:
    """Draw a table without a clock: both branches of a printed loop, or isobars, strain over temperature."""
    figure, axes = one_panel(style)
    with figure.styled():
        if recording.is_branch_table:
            for name, colour in (("heating", HEATING), ("cooling", COOLING)):
                strain = 100.0 * recording[f"strain_{name}"]
                axes.plot(recording["resistance_ohm"], strain, "o-", color=colour, label=name)
            axes.set(xlabel="resistance [ohm]", ylabel="strain [%]")
            axes.legend()
        else:
            draw_isobars(axes, recording)
    return figure


def draw_isobars(axes: Axes, recording: Recording) -> None:
    """Draw strain over temperature, a line for each stress, labelled at its hot end; light to dark with the stress."""
    import matplotlib as mpl

    temperature_degc = recording["wire_temperature_k"] - KELVIN_AT_0_DEGC
    strain = 100.0 * recording["reference_strain"]
    stress_mpa = np.round(1e-6 * recording["stress_pa"])
    each = np.unique(stress_mpa)
    for stress, shade in zip(each, np.linspace(0.75, 0.1, each.size), strict=True):
        there = stress_mpa == stress
        colour = mpl.colormaps["cividis"](1.0 - shade)
        axes.plot(temperature_degc[there], strain[there], color=colour, label=f"{stress:g} MPa")
    axes.set(xlabel="temperature [°C]", ylabel="strain [%]")
    axes.legend(title="stress")


class TrackingSeries(NamedTuple):
    """Target, estimate and measurement of a run in the unit that is shown; None for what was not recorded."""

    name: str
    unit: str
    target: FloatArray
    estimated: FloatArray | None
    measured: FloatArray | None


class FigurePanel(NamedTuple):
    """Columns that share one axis: its label, their factor, and the zero that is subtracted."""

    label: str
    columns: tuple[str, ...]
    factor: float = 1.0
    zero: float = 0.0


PANELS = (
    FigurePanel("voltage [V]", ("drive_voltage_v", "wire_voltage_v", "shunt_voltage_v")),
    FigurePanel("current [mA]", ("wire_current_a",), 1e3),
    FigurePanel("strain [%]", ("target_strain", "reference_strain", "estimated_strain"), 100.0),
    FigurePanel(
        "displacement [mm]",
        ("target_displacement_m", "displacement_m", "estimated_displacement_m", "endpoint_displacement_m"),
        1e3,
    ),
    FigurePanel("force [N]", ("target_force_n", "force_n", "estimated_force_n", "endpoint_force_n")),
    FigurePanel("grip force [N]", ("target_grip_force_n", "estimated_grip_force_n")),
    FigurePanel("stress [MPa]", ("stress_pa",), 1e-6),
    FigurePanel(
        "temperature [°C]", ("wire_temperature_k", "estimated_temperature_k", "ambient_temperature_k"), 1.0, 273.15
    ),
)
COLOURS = (COOLING, HEATING, AVERAGE, PAPER)
WORDS = {"drive_voltage_v": "drive", "wire_voltage_v": "wire", "shunt_voltage_v": "shunt"}


def time_figure(recording: Recording, style: str) -> StyledFigure:
    """Draw over time what was recorded: voltages, resistance, movement, force, temperature, a panel for each."""
    shown = [(one, [name for name in one.columns if name in recording]) for one in PANELS]
    shown = [(panel, names) for panel, names in shown if names]
    resistance = resistance_or_none(recording)
    count = len(shown) + (resistance is not None)
    if not count:
        raise RecordingError(
            f"there is nothing to plot over time in columns {', '.join(recording.names)}: choose another kind"
        )
    figure, axes = panel_rows(style, [1.0] * count)
    with figure.styled():
        if resistance is not None:
            axes[-1].plot(recording["time_s"], resistance, color=AVERAGE)
            axes[-1].set_ylabel("resistance [ohm]")
        for one, (panel, names) in zip(axes, shown, strict=False):
            draw_columns(one, recording, panel, names)
        axes[-1].set_xlabel("time [s]")
    return figure


def draw_columns(axes: Axes, recording: Recording, panel: FigurePanel, names: Sequence[str]) -> None:
    """Draw the columns of one panel, with a legend if they are several."""
    for name, colour in zip(names, COLOURS, strict=False):
        values = panel.factor * (recording[name] - panel.zero)
        axes.plot(recording["time_s"], values, color=colour, label=WORDS.get(name, name_without_unit(name)))
    axes.set_ylabel(panel.label)
    if len(names) > 1:
        axes.legend(loc="best", ncols=len(names) if len(names) < 4 else 2)


def name_without_unit(column: str) -> str:
    """Return a column's name without its unit, as in a legend."""
    words = column.split("_")
    return " ".join(words[:-1] if words[-1] in ("m", "n", "k", "v", "a", "pa") else words)


def resistance_or_none(recording: Recording) -> FloatArray | None:
    """Return the resistance where it is valid, NaN elsewhere; None if nothing in the recording gives it."""
    try:
        reading = resistance_reading(recording)
    except RecordingError:
        return None
    return np.where(reading.valid, reading.resistance_ohm, np.nan)


def control_figure(recording: Recording, style: str) -> StyledFigure:
    """Draw target, estimate and measurement over time, their errors, and the drive."""
    run = tracking_series(recording)
    panels = 2 + ("drive_voltage_v" in recording)
    figure, axes = panel_rows(style, [1.8, 1.0, 0.8][:panels])
    time_s = recording["time_s"]
    with figure.styled():
        draw_followed(axes[0], time_s, run)
        draw_errors(axes[1], time_s, run)
        if "drive_voltage_v" in recording:
            axes[2].plot(time_s, recording["drive_voltage_v"], color=AVERAGE)
            axes[2].set_ylabel("drive [V]")
        axes[-1].set_xlabel("time [s]")
    return figure


def estimate_figure(recording: Recording, style: str) -> StyledFigure:
    """Draw an estimate with its standard deviation, and the reference, over time and over resistance."""
    found = [name for name, suffix in COLUMN_SUFFIX.items() if f"estimated_{suffix}" in recording]
    if not found:
        raise RecordingError(f"this recording has no estimate; it has {', '.join(recording.names)}: estimate it first")
    factor, unit = SHOWN_AS[found[0]]
    label = f"{found[0]} [{unit}]"
    estimated = factor * recording[f"estimated_{COLUMN_SUFFIX[found[0]]}"]
    counted = recording["valid"] > 0.0 if "valid" in recording else np.ones(len(recording), dtype=np.bool_)
    measured = reference_quantity(recording, found[0])
    resistance = resistance_or_none(recording)
    figure, panels = panel_rows(style, [1.0, 1.3][: 1 + (resistance is not None)], common_x=False)
    with figure.styled():
        for axes, across in zip(panels, (recording["time_s"], resistance), strict=False):
            if measured is not None and across is not None:
                axes.plot(across, factor * measured, color=COOLING, label="reference")
            axes.set_ylabel(label)
        draw_estimate_over_time(panels[0], recording, factor, estimated, counted)
        panels[0].set_xlabel("time [s]")
        if resistance is not None:
            there = counted & np.isfinite(resistance)
            panels[1].plot(resistance[there], estimated[there], ".", markersize=2.0, color=HEATING)
            panels[1].set_xlabel("resistance [ohm]")
        panels[0].legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    return figure


def draw_estimate_over_time(
    axes: Axes, recording: Recording, factor: float, estimated: FloatArray, counted: NDArray[np.bool_]
) -> None:
    """Draw the estimate where it counts, with its standard deviation as a band, and faintly where it does not."""
    time_s = recording["time_s"]
    if not counted.all():
        held = np.where(counted, np.nan, estimated)
        axes.plot(time_s, held, color=TARGET, linewidth=0.8, label="estimate, not valid")
    if "estimate_std" in recording:
        std = np.where(counted, factor * recording["estimate_std"], np.nan)
        band = (estimated - std, estimated + std)
        axes.fill_between(time_s, *band, color=HEATING, alpha=0.25, linewidth=0, label="± standard deviation")
    axes.plot(time_s, np.where(counted, estimated, np.nan), color=HEATING, linestyle="--", label="estimate", zorder=3)


def tracking_series(recording: Recording) -> TrackingSeries:
    """Return what a run followed; raises RecordingError for a recording without a target."""
    for quantity, suffix in COLUMN_SUFFIX.items():
        if f"target_{suffix}" in recording:
            factor, unit = SHOWN_AS[quantity]
            columns = recording.columns.get(f"estimated_{suffix}"), reference_quantity(recording, quantity)
            found = (None if one is None else factor * one for one in columns)
            return TrackingSeries(quantity, unit, factor * recording[f"target_{suffix}"], *found)
    if "target_grip_force_n" in recording:
        columns = recording.columns.get("estimated_grip_force_n"), recording.columns.get("endpoint_force_n")
        return TrackingSeries("grip force", "N", recording["target_grip_force_n"], *columns)
    raise RecordingError(f"a run of control has a target; this recording has {', '.join(recording.names)}")


def draw_followed(axes: Axes, time_s: FloatArray, run: TrackingSeries) -> None:
    """Draw the target as a broad grey line, and on it what was measured and what was estimated."""
    wide = 1.8 * axes.figure.style.line_pt  # type: ignore[union-attr]  # our figures have a style
    axes.plot(time_s, run.target, color=TARGET, linewidth=wide, drawstyle="steps-post", label="target")
    if run.measured is not None:
        axes.plot(time_s, run.measured, color=COOLING, label="measured")
    if run.estimated is not None:
        axes.plot(time_s, run.estimated, color=HEATING, linestyle="--", label="estimated")
    axes.set_ylabel(f"{run.name} [{run.unit}]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)


def draw_errors(axes: Axes, time_s: FloatArray, run: TrackingSeries) -> None:
    """Draw measured less target and estimated less measured; estimated less target where nothing was measured."""
    axes.axhline(0.0, color=TARGET, linewidth=0.8)
    pairs = (
        (run.measured, run.target, COOLING, "measured - target"),
        (run.estimated, run.measured, HEATING, "estimated - measured"),
    )
    if run.measured is None:
        pairs = ((run.estimated, run.target, HEATING, "estimated - target"),) * 1  # type: ignore[assignment]
    for one, other, colour, name in pairs:
        if one is not None and other is not None:
            axes.plot(time_s, one - other, color=colour, linestyle="--" if colour == HEATING else "-", label=name)
    axes.set_ylabel(f"error [{'% strain' if run.unit == '%' else run.unit}]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
