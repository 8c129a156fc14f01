"""Figures of a finger: unloaded and bent, tendon and stress; its curve; the schemes of actuation side by side."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from musclewire.arrays import FloatArray
from musclewire.pages import COOLING, HEATING, STYLE, TARGET
from musclewire_design._finger.chain import finger_chain
from musclewire_design._finger.comparison import PullingScheme
from musclewire_design._finger.curve import beam_stress_pa
from musclewire_design._finger.finger_study import FingerStudyResult
from musclewire_design._finger.geometry import FingerGeometry
from musclewire_design._finger.shape import FingerShape, beside, finger_shape
from musclewire_design._finger.statics import FingerEquilibrium, equilibria

BODY, EDGE, GHOST, PALM = "#dfe7ec", "#5b6b75", "#f3f5f6", "#c9cfd4"
STRESS_MAP = "YlOrRd"
MM = 1e3


def plot_finger(result: FingerStudyResult) -> Figure:
    """Return the figure of a finger: its shapes at the left, its curve at the right, the schemes of actuation below.

    Parameters
    ----------
    result
        A finger with its numbers at the requested endpoint.

    Returns
    -------
    The figure, not shown and not known to pyplot: lengths in mm, forces in N, stress in MPa.
    """
    with mpl.rc_context(dict(STYLE)):  # type: ignore[arg-type]
        heights = [4.8, 3.2] if result.schemes else [4.8]
        figure = Figure(figsize=(9.6, sum(heights)), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(len(heights), 1, height_ratios=heights)
        top = grid[0].subgridspec(2, 2, width_ratios=[1.75, 1.0])
        draw_shapes(figure, figure.add_subplot(top[:, 0]), result)
        draw_force(figure.add_subplot(top[0, 1]), result)
        draw_endpoint(figure.add_subplot(top[1, 1]), result)
        if result.schemes:
            draw_schemes(figure, grid[1], result)
    return figure


def draw_shapes(figure: Figure, axes: Any, result: FingerStudyResult) -> None:
    """Draw the finger unloaded, in between, and at the requested endpoint, with the stress in its beam."""
    geometry, at = result.geometry, result.at if result.contact is None else result.contact.at
    chain = finger_chain(geometry)
    resting = finger_shape(geometry, chain.resting_angles_rad)
    passed = np.linspace(0.0, at.travel_m, 4)[1:-1]
    way = equilibria(chain, geometry.stiffness_n_m2, passed, obstacle=result.study.obstacle)
    draw_palm(axes, geometry)
    for passing in way:
        ghost = finger_shape(geometry, passing.angles_rad).outline()
        axes.add_patch(Polygon(MM * ghost, closed=True, facecolor="none", edgecolor="#d5dbdf", lw=0.8))
    draw_body(axes, resting, GHOST, TARGET)
    axes.plot(*(MM * resting.tendon()).T, color=TARGET, lw=1.0)
    bent = finger_shape(geometry, at.angles_rad)
    draw_body(axes, bent, BODY, EDGE)
    stressed = draw_stress(axes, bent, result, at)
    axes.plot(*(MM * bent.tendon()).T, color=COOLING, lw=1.4, solid_capstyle="round")
    axes.annotate(
        "", (-4.0, MM * geometry.tendon_offset_m), (0.0, MM * geometry.tendon_offset_m),
        arrowprops={"arrowstyle": "-|>", "color": COOLING, "lw": 1.4, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip
    pull = f"{at.tendon_force_n:.2f} N, {MM * at.travel_m:.2f} mm"
    axes.text(-4.0, MM * geometry.column_height_m + 0.15, pull, color=COOLING, fontsize=8.5, ha="left", va="bottom")
    draw_endpoint_arrow(axes, resting, bent, at.endpoint_displacement_m)
    draw_object(axes, result, resting, bent)
    bar = figure.colorbar(stressed, ax=axes, location="bottom", shrink=0.62, aspect=32, pad=0.02)
    bar.set_label("stress in the beam [MPa]; the scale ends where it yields")
    bar.outline.set_visible(False)
    axes.set_aspect("equal")
    axes.set_xlim(-4.6, MM * geometry.overall_length_m + 1.6)
    axes.set_ylim(-1.5, MM * max(bent.outline()[:, 1].max(), geometry.column_height_m) + 0.8)
    where = "" if result.contact is None else " on the object"
    title = f"endpoint {MM * at.endpoint_displacement_m:.2f} mm{where}"
    axes.set(xlabel="along the finger [mm]", ylabel="across the finger [mm]", title=title)
    axes.grid(visible=False)


def draw_palm(axes: Any, geometry: FingerGeometry) -> None:
    """Draw the palm, with the hole through which the tendon leaves it."""
    low, high = -1.2, MM * geometry.column_height_m
    axes.add_patch(Rectangle((-1.6, low), 1.6, high - low, facecolor=PALM, edgecolor="none"))
    height = MM * geometry.tendon_offset_m
    axes.plot([-1.6, 0.0], [height, height], color="white", lw=3.2, solid_capstyle="butt")


def draw_body(axes: Any, shape: FingerShape, face: str, edge: str) -> None:
    """Draw one finger's outline."""
    axes.add_patch(Polygon(MM * shape.outline(), closed=True, facecolor=face, edgecolor="none"))
    for isolator in shape.isolators():
        axes.add_patch(
            Polygon(MM * isolator, closed=True, facecolor=edge, edgecolor="none", alpha=0.35 if face == BODY else 0.15)
        )
    axes.add_patch(
        Polygon(MM * shape.outline(), closed=True, facecolor="none", edgecolor=edge, lw=0.9, joinstyle="round")
    )


def draw_stress(axes: Any, shape: FingerShape, result: FingerStudyResult, at: FingerEquilibrium) -> LineCollection:
    """Draw the beam's segments in the colour of the stress at their faces, from none to yield."""
    geometry = result.geometry
    middle = [beside(part, 0.0) for part in shape.segments]
    pieces = [MM * part[index : index + 2] for part in middle for index in range(len(part) - 1)]
    stress = 1e-6 * beam_stress_pa(geometry, at)
    lines = LineCollection(pieces, cmap=STRESS_MAP, lw=3.0, capstyle="butt", zorder=3)
    lines.set_array(stress)
    lines.set_clim(0.0, 1e-6 * result.study.material.yield_stress_pa.value)
    axes.add_collection(lines)
    return lines


def draw_endpoint_arrow(axes: Any, resting: FingerShape, bent: FingerShape, moved_m: float) -> None:
    """Draw the endpoint's displacement across the palm's axis."""
    x = MM * max(resting.endpoint[0], bent.endpoint[0]) + 0.7
    low, high = MM * resting.endpoint[1], MM * bent.endpoint[1]
    for shape, level in ((resting, low), (bent, high)):
        axes.plot([MM * shape.endpoint[0] + 0.15, x + 0.2], [level, level], color=HEATING, lw=0.7, ls=(0, (3, 2)))
    axes.annotate("", (x, high), (x, low), arrowprops={"arrowstyle": "<|-|>", "color": HEATING, "lw": 1.2})
    axes.text(x + 0.25, 0.5 * (low + high), f"{MM * moved_m:.2f} mm", color=HEATING, va="center", rotation=90)


def draw_object(axes: Any, result: FingerStudyResult, resting: FingerShape, bent: FingerShape) -> None:
    """Draw the object in the endpoint's way, if there is one, and the force between them."""
    obstacle, found = result.study.obstacle, result.contact
    if obstacle is None or found is None:
        return
    # The plate's corner touches, ahead of the endpoint on the middle of the beam.
    ahead = bent.outline()[:, 1].max() - bent.endpoint[1]
    low, x = MM * (resting.endpoint[1] + obstacle.clearance_m + ahead), MM * bent.endpoint[0]
    axes.text(x - 2.5, low + 1.1, f"{found.force_n:.2f} N", ha="right", va="center", fontsize=8.5, color="#a9812c")
    axes.add_patch(
        Rectangle((x - 2.0, low), 4.0, 2.2, facecolor="#f7e7c6", edgecolor="#d9b667", lw=0.8, hatch="..", zorder=0)
    )


def mark(axes: Any, result: FingerStudyResult, free: float, touching: float | None, color: str) -> None:
    """Mark the free finger at the requested endpoint and, with an object, the finger on it."""
    axes.plot([MM * result.at.travel_m], [free], "o", color=color, ms=4.5, label="free, requested endpoint")
    if touching is None or result.contact is None:
        return
    axes.plot(
        [MM * result.contact.at.travel_m], [touching], "D", ms=5, mfc="white", mec=color, mew=1.4, label="on the object"
    )


def draw_force(axes: Any, result: FingerStudyResult) -> None:
    """Draw the force at the connector over the travel: pulling, easing, and without friction."""
    curve = result.curve
    travel, force, fraction = (
        np.array(part) for part in (curve.tendon_travel_m, curve.tendon_force_n, curve.friction_share)
    )
    axes.fill_between(MM * travel, force * (1 - fraction), force * (1 + fraction), color=COOLING, alpha=0.18, lw=0)
    axes.plot(MM * travel, force, color=COOLING)
    mark(
        axes,
        result,
        result.at.tendon_force_n,
        None if result.contact is None else result.contact.tendon_force_n,
        COOLING,
    )
    axes.text(
        0.04, 0.95, f"{result.stiffness_n_per_m:.1f} N/m\nband: friction {result.study.friction:g}",
        transform=axes.transAxes, va="top", fontsize=8.5, color="#444444",
    )  # fmt: skip
    if result.contact is not None:
        axes.legend(frameon=False, fontsize=8, loc="lower right", handletextpad=0.2, borderaxespad=0.1)
    axes.set(ylabel="tendon force [N]", xlim=(0.0, None), ylim=(0.0, None))


def draw_endpoint(axes: Any, result: FingerStudyResult) -> None:
    """Draw the endpoint's displacement over the travel."""
    curve = result.curve
    axes.plot(MM * np.array(curve.tendon_travel_m), MM * np.array(curve.endpoint_displacement_m), color=HEATING)
    touching = None if result.contact is None else MM * result.contact.endpoint_m
    mark(axes, result, MM * result.at.endpoint_displacement_m, touching, HEATING)
    axes.axvline(MM * result.study.travel_m, color=TARGET, lw=1.0, ls=(0, (4, 3)))
    axes.text(
        MM * result.study.travel_m, 0.04 * MM * curve.endpoint_displacement_m[-1],
        f"available: {MM * result.study.travel_m:.2f} mm ",
        color="#777777", fontsize=8, ha="right", rotation=90, va="bottom",
    )  # fmt: skip
    axes.set(xlabel="tendon travel [mm]", ylabel="endpoint [mm]", xlim=(0.0, None), ylim=(0.0, None))


def draw_schemes(figure: Figure, place: Any, result: FingerStudyResult) -> None:
    """Draw the schemes of actuation side by side, to one scale."""
    below = place.subgridspec(1, len(result.schemes))
    shapes = [finger_shape(result.geometry, scheme.angles_rad) for scheme in result.schemes]
    high = MM * max(shape.outline()[:, 1].max() for shape in shapes) + 0.8
    for index, (scheme, shape) in enumerate(zip(result.schemes, shapes, strict=True)):
        axes = figure.add_subplot(below[index])
        draw_scheme(axes, result.geometry, scheme, shape)
        axes.set_xlim(-1.8, MM * result.geometry.overall_length_m + 0.8)
        axes.set_ylim(-1.4, high)


def draw_scheme(axes: Any, geometry: FingerGeometry, scheme: PullingScheme, shape: FingerShape) -> None:
    """Draw one scheme of actuation, at its limit."""
    draw_palm(axes, geometry)
    resting = finger_shape(geometry, finger_chain(geometry).resting_angles_rad)
    draw_body(axes, resting, GHOST, "#d5dbdf")
    draw_body(axes, shape, BODY, EDGE)
    tendon: FloatArray = shape.tendon(scheme.guided)
    axes.plot(*(MM * tendon).T, color=COOLING, lw=1.4)
    axes.set_title(f"{scheme.name}\nrange/length {scheme.range_over_length:.2f}", fontsize=9.5)
    axes.text(
        0.98, 0.02, f"{scheme.limit} used up:\n{MM * scheme.travel_m:.2f} mm, {1e-6 * scheme.stress_pa:.0f} MPa",
        transform=axes.transAxes, ha="right", va="bottom", fontsize=8, color="#555555",
    )  # fmt: skip
    axes.set_aspect("equal")
    axes.set(xlabel="along the finger [mm]")
    axes.grid(visible=False)
