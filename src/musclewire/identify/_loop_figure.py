"""A recorded loop as a picture: movement over drive voltage and over resistance, with points A, B and C."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.figures import StyledFigure, one_panel, panels_side_by_side
from musclewire.identify._loop_gaps import LoopGaps, loop_gaps
from musclewire.identify._recordings import reference_quantity, required_quantity, resistance_reading
from musclewire.pages import AVERAGE, COOLING, HEATING, TARGET

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
