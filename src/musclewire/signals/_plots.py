"""Which plots of a recording there are, by name, and which one fits its columns; drawn in rooms above this one."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any

from musclewire.registry import Registry
from musclewire.signals._columns import needs_no_clock

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Takes the recording and the name of a figure style.
PlotKind = Callable[[Any, str], "Figure"]

PLOTS: Registry[PlotKind] = Registry(
    "plot",
    "plots",
    {
        "loop": "musclewire.identify._time_figures:loop_figure",
        "control": "musclewire.identify._time_figures:control_figure",
        "time": "musclewire.identify._time_figures:time_figure",
        "estimate": "musclewire.identify._time_figures:estimate_figure",
        "table": "musclewire.identify._time_figures:table_figure",
    },
)
ESTIMATED = {"estimated_strain", "estimated_displacement_m", "estimated_force_n"}
MOVEMENTS = {"reference_strain", "displacement_m"}
ELECTRICAL = ({"wire_resistance_ohm"}, {"wire_voltage_v", "shunt_voltage_v"}, {"wire_voltage_v", "wire_current_a"})


def usual_plot(names: Collection[str]) -> str:
    """Return the plot for columns of these names: of control with a target, of an estimate, of a loop with movement."""
    if "time_s" not in names and needs_no_clock(names):
        return "table"
    if any(name.startswith("target_") for name in names):
        return "control"
    if ESTIMATED & set(names):
        return "estimate"
    resistance = any(columns <= set(names) for columns in ELECTRICAL)
    return "loop" if resistance and MOVEMENTS & set(names) else "time"
