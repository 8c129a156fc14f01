"""Everything that a linearisation shows of a wire at one displacement: both branches, both motions, with margins."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.controllers import PidSettings
from musclewire.errors import CallerError
from musclewire.extras.interfaces._control_systems.linearisation import LinearWire, linearised
from musclewire.extras.interfaces._control_systems.loops import (
    LoopMargins,
    controller_system,
    loop_margins,
    sampled_system,
)
from musclewire.extras.interfaces._control_systems.operating_points import OperatingPoint, operating_point
from musclewire.pages import COOLING, HEATING
from musclewire.rigs import RigConfiguration
from musclewire.sensing import SensingModel

COLOURS = {"heating": HEATING, "cooling": COOLING}
LINES = {"branch": "-", "minor loop": ":"}
POINTS = 400
MIN_HZ = 1e-3  # lowest frequency of the plot: far below the wire's pole
MAX_OF_NYQUIST = 0.97  # highest frequency over half of the sampling rate, just below it


@dataclass(frozen=True)
class LinearisedLoop:
    """A linear wire, and the margins of the loop around it."""

    linear: LinearWire
    margins: LoopMargins


@dataclass(frozen=True)
class Linearisation:
    """A wire at one displacement, reached by heating and by cooling, each linearised onward and back."""

    # The four linear wires with their margins: heating branch and its minor loop, then cooling.
    loops: tuple[LinearisedLoop, ...]
    settings: PidSettings  # the plain PID of the loops
    model: SensingModel | None  # model by which the loops sense strain; None if they are closed on the strain itself

    @property
    def points(self) -> tuple[OperatingPoint, OperatingPoint]:
        """Both operating points: reached by heating, reached by cooling."""
        return self.loops[0].linear.point, self.loops[-1].linear.point

    @property
    def width_v(self) -> float:
        """Drive [V] by which the heating branch is above the cooling branch: what a reversal has to go through."""
        heated, cooled = self.points
        return heated.drive_voltage_v - cooled.drive_voltage_v


def linearise(
    displacement_m: float,
    rig: str | Path | RigConfiguration = "simulated",
    *,
    model: SensingModel | None = None,
    settings: PidSettings | None = None,
) -> Linearisation:
    """Return a rig's wire linearised at a displacement, with the margins of its closed loop.

    Parameters
    ----------
    displacement_m
        Displacement of the connector [m], positive for a shorter wire.
    rig
        A simulated rig with one wire: its name, its file, or a configuration; its air is taken as still.
    model
        Model of strain by which the loop senses; None closes it on the strain itself.
    settings
        Those of the plain PID; its defaults, the middles of the paper's ranges, if None.

    Returns
    -------
    Operating points on both branches, four linear wires, and their margins.

    Raises
    ------
    CallerError
        For a displacement that the wire does not reach, and a model that does not estimate strain.
    NumericsError
        If the wire finds no balance with its load.

    Examples
    --------
    >>> from musclewire.extras.interfaces._control_systems.study import linearise
    >>> found = linearise(2e-3)
    >>> [one.linear.motion for one in found.loops]
    ['branch', 'minor loop', 'branch', 'minor loop']
    """
    if model is not None and model.quantity != "strain":
        raise CallerError(f"the loop is one of strain, and this model estimates {model.quantity}: fit one of strain")
    chosen = settings or PidSettings()
    points = [operating_point(displacement_m, rig, branch=branch) for branch in ("heating", "cooling")]
    linear = [linearised(point, motion) for point in points for motion in ("branch", "minor loop")]
    loops = tuple(LinearisedLoop(one, loop_margins(one, chosen, model)) for one in linear)
    return Linearisation(loops, chosen, model)


def bode_axes(found: Linearisation, *, style: str = "screen") -> Any:
    """Draw the open loops of a linearisation as a Bode plot, with pyplot; return the axes of the magnitude."""
    from musclewire.figures import panel_rows

    figure, (magnitude, phase) = panel_rows(style, (1.5, 1.1), by_pyplot=True)
    with figure.styled():
        for one in found.loops:
            draw_open_loop(magnitude, phase, one, found)
        magnitude.axhline(1.0, color="#9aa0a6", lw=0.8)
        phase.axhline(-180.0, color="#9aa0a6", lw=0.8)
        magnitude.set_ylabel("magnitude of\nthe open loop")
        phase.set(xlabel="frequency [Hz]", ylabel="phase [deg]")
        figure.legend(*magnitude.get_legend_handles_labels(), loc="outside lower center")
        point = found.points[0]
        magnitude.set_title(f"{point.wire.name} at {1e3 * point.displacement_m:.3g} mm", loc="left")
    return magnitude


def draw_open_loop(magnitude: Any, phase: Any, one: LinearisedLoop, found: Linearisation) -> None:
    """Draw the open loop of one linear wire over frequency."""
    period_s = one.linear.point.wire.sample_period_s
    loop = controller_system(found.settings, period_s) * sampled_system(one.linear, period_s, found.model)
    hz = np.geomspace(MIN_HZ, MAX_OF_NYQUIST * 0.5 / period_s, POINTS)
    response = loop.frequency_response(2.0 * np.pi * hz)
    branch, motion = one.linear.point.branch, one.linear.motion
    line = {"color": COLOURS[branch], "ls": LINES[motion], "label": f"{branch}, {motion}{margins_text(one.margins)}"}
    magnitude.loglog(hz, np.abs(response.complex), **line)
    phase.semilogx(hz, np.degrees(np.unwrap(np.angle(response.complex))), **line)


def margins_text(margins: LoopMargins) -> str:
    """Return the margins of a loop for a legend; nothing for a loop that has none."""
    if margins.gain_margin is None or margins.phase_margin_deg is None:
        return ""
    return f": gain margin {margins.gain_margin:.1f}, phase margin {margins.phase_margin_deg:.0f} deg"
