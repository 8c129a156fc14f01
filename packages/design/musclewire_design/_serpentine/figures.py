"""Figure of a pretensioner: at rest and pulled, with its stress, next to its force and stress over travel."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.pages import AVERAGE, COOLING, HEATING, STYLE, TARGET
from musclewire_design._drawing import DrawnHole, polyline_m
from musclewire_design._serpentine.outline import serpentine_drawing
from musclewire_design._serpentine.strip import pulled_strip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.transforms import Affine2D

    from musclewire_design._elasticity import BodyEquilibrium
    from musclewire_design._serpentine.analysis import PretensionerDesign


SIZE_INCHES, DPI = (10.4, 5.6), 120
MM, MPA = 1e3, 1e-6
# Stress is drawn on a coarser mesh than the one that is checked: the eye sees no difference.
DRAWN_MESH = 3
BLOCK = "#d5d9de"
# From no stress to the largest: never as pale as the page.
SHADES = ("#a9c9d8", "#f0d98c", "#e8853f", "#8f1d2c")


def draw_pretensioner(made: PretensionerDesign) -> Axes:
    """Draw a pretensioner at its whole travel, and its curve; return the axes of the part."""
    import matplotlib as mpl
    import matplotlib.pyplot as plt

    with mpl.rc_context(dict(STYLE)):  # type: ignore[arg-type]
        figure = plt.figure(figsize=SIZE_INCHES, dpi=DPI, layout="constrained")
        part, curve = figure.subplots(1, 2, width_ratios=(1.12, 1.0))
        draw_part(part, made)
        draw_curve(curve, made)
    return part  # type: ignore[no-any-return]


def draw_part(axes: Axes, made: PretensionerDesign) -> None:
    """Draw the part at rest as an outline, and pulled with the stress as colour."""
    from matplotlib.transforms import Affine2D

    geometry, fittings = made.geometry, made.geometry.fittings
    travel = made.travel_m if made.travel_m is not None else made.curve.safe_travel_m
    state = pulled_strip(geometry, made.material, made.curve.force_at(travel), DRAWN_MESH)
    drawing = serpentine_drawing(geometry, "")
    rest = MM * polyline_m(drawing.outline)
    axes.plot(*rest.T, color=TARGET, linewidth=0.8, linestyle=(0, (4, 2)), zorder=1)
    end, turned = end_motion(state, geometry.connector_m)
    pad, (left, right, connector) = 0.5 * MM * geometry.pad_width_m, drawing.holes
    block(axes, (-pad, 0.0), (2 * pad, MM * fittings.pad_height_m), [left, right], Affine2D())
    width = MM * fittings.connector_width_m
    moved = Affine2D().rotate_around(0.0, MM * geometry.connector_m, turned).translate(*end)
    corner = (-0.5 * width, MM * geometry.connector_m)
    block(axes, corner, (width, MM * fittings.connector_height_m), [connector], moved)
    shades = stress_mesh(axes, state)
    top = MM * geometry.along_m + end[1]
    draw_pull(axes, end[0], top, f"{made.curve.force_at(travel):.2f} N\n{MM * travel:.2f} mm")
    axes.set(aspect="equal", xlabel="across the wire [mm]", ylabel="along the wire [mm]", ylim=(-1.5, top + 5.2))
    axes.set_title(part_title(made), loc="left", fontsize=10)
    axes.grid(visible=False)
    add_stress_bar(axes, shades, made.material.allowable_stress_pa.value)


def add_stress_bar(axes: Axes, shades: Any, allowed_pa: float) -> None:
    """Add the colour bar of the stress below the part."""
    bar = axes.figure.colorbar(shades, ax=axes, location="bottom", shrink=0.75, pad=0.02, aspect=34)
    bar.set_label(f"von Mises stress [MPa]; {MPA * allowed_pa:g} MPa are allowed")
    bar.outline.set_visible(False)


def draw_pull(axes: Axes, across_mm: float, top_mm: float, text: str) -> None:
    """Draw the arrow of the force that pulls at the part's end, with its value."""
    from matplotlib.patches import FancyArrowPatch

    begin, end = (across_mm, top_mm + 0.4), (across_mm, top_mm + 4.2)
    axes.add_patch(FancyArrowPatch(begin, end, arrowstyle="-|>", mutation_scale=14, color=AVERAGE))
    axes.text(across_mm + 0.8, top_mm + 2.4, text, va="center", fontsize=9)


def part_title(made: PretensionerDesign) -> str:
    """Return the line above the part."""
    g = made.geometry
    return (
        f"{g.beams} beams of {made.material.name}, {MM * g.thickness_m:.2f} mm thick, {MM * g.depth_m:g} mm deep\n"
        f"half length {MM * g.half_length_m:.2f} mm, pitch {MM * g.pitch_m:.2f} mm: {made.stiffness_n_per_m:.1f} N/m"
    )


def end_motion(state: BodyEquilibrium, connector_m: float) -> tuple[FloatArray, float]:
    """Return the displacement of the middle of the strip's upper end (2,) [mm], and its rotation [rad]."""
    end = state.body.nodes_near(y_m=connector_m, within_m=1e-9)
    end = end[np.argsort(state.body.nodes_m[end, 0])]
    across = (state.body.nodes_m + state.displacement_m)[end[-1]] - (state.body.nodes_m + state.displacement_m)[end[0]]
    motion: FloatArray = MM * state.displacement_m[end].mean(axis=0)
    return motion, float(np.arctan2(across[1], across[0]))


def block(
    axes: Axes, corner: tuple[float, float], size: tuple[float, float], holes: list[DrawnHole], moved: Affine2D
) -> None:
    """Draw a thick block with its holes [mm], moved and turned."""
    import matplotlib.patches as shapes

    rounding = "round,pad=0,rounding_size=0.8"
    look: dict[str, Any] = {"edgecolor": "#8a9099", "linewidth": 0.8, "transform": moved + axes.transData}
    axes.add_patch(shapes.FancyBboxPatch(corner, *size, boxstyle=rounding, facecolor=BLOCK, **look))
    for hole in holes:
        centre = (MM * hole.x_m, MM * hole.y_m)
        axes.add_patch(shapes.Circle(centre, 0.5 * MM * hole.diameter_m, facecolor="white", **look))


def stress_mesh(axes: Axes, state: BodyEquilibrium) -> Any:
    """Draw the stress on the pulled strip; each element of nine nodes as a ring of triangles around its middle."""
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.tri import Triangulation

    places = MM * (state.body.nodes_m + state.displacement_m)
    ring = state.body.elements[:, [0, 4, 1, 5, 2, 6, 3, 7]]
    middle = np.broadcast_to(state.body.elements[:, 8:9], ring.shape)
    triangles = np.stack([middle, ring, np.roll(ring, -1, axis=1)], axis=-1).reshape(-1, 3)
    mesh = Triangulation(places[:, 0], places[:, 1], triangles)
    shades = LinearSegmentedColormap.from_list("stress", SHADES)
    drawn = axes.tripcolor(mesh, MPA * state.von_mises_pa, shading="gouraud", cmap=shades, vmin=0.0, zorder=3)
    # Smooth colours on triangles take megabytes as vectors, and browsers do not draw them.
    drawn.set_rasterized(True)
    return drawn


def draw_curve(axes: Axes, made: PretensionerDesign) -> None:
    """Draw pull and stress over travel, with their limits."""
    curve, duty = made.curve, made.duty
    travel = np.linspace(0.0, curve.travel_m[-1], 200)
    axes.plot(MM * travel, [curve.force_at(at) for at in travel], color=COOLING)
    axes.set(xlabel="travel of the connector [mm]", ylabel="pull [N]", xlim=(0.0, None), ylim=(0.0, None))
    axes.yaxis.label.set_color(COOLING)
    if duty.pretension_n is not None and duty.travel_m is None and made.travel_m is not None:
        start = made.travel_m - duty.stroke_m
        axes.axvspan(MM * start, MM * made.travel_m, color="#1f6f8b", alpha=0.12, linewidth=0.0)
        axes.plot(MM * start, duty.pretension_n, "o", color=COOLING, markersize=5)
        axes.annotate(
            f"pretension {duty.pretension_n:g} N",
            (MM * start, duty.pretension_n),
            textcoords="offset points",
            xytext=(-6, 10),
            ha="right",
            fontsize=9,
        )
        axes.text(MM * (start + 0.5 * duty.stroke_m), 0.02, "stroke", transform=axes.get_xaxis_transform(), ha="center")
    draw_stress(axes, made)


def draw_stress(axes: Axes, made: PretensionerDesign) -> None:
    """Draw the largest stress over travel on an axis of its own, with the allowed stress."""
    curve, allowed = made.curve, made.material.allowable_stress_pa.value
    travel = np.linspace(0.0, curve.travel_m[-1], 200)
    right = axes.twinx()
    right.grid(visible=False)
    right.spines["right"].set_visible(True)
    right.plot(MM * travel, [MPA * curve.stress_at(at) for at in travel], color=HEATING, linestyle="--")
    right.axhline(MPA * allowed, color=HEATING, linewidth=0.9, alpha=0.6)
    right.text(0.02, MPA * allowed, "allowed ", transform=right.get_yaxis_transform(), va="bottom", color=HEATING)
    right.axvline(MM * curve.safe_travel_m, color=HEATING, linewidth=0.9, linestyle=":")
    safe = f"safe to {MM * curve.safe_travel_m:.2f} mm "
    at_bottom = right.get_xaxis_transform()
    right.text(
        MM * curve.safe_travel_m, 0.03, safe, transform=at_bottom, rotation=90, ha="right", color=HEATING, size=9
    )
    right.set(
        ylabel="largest von Mises stress [MPa]", ylim=(0.0, 1.12 * MPA * max(allowed, float(curve.stress_pa.max())))
    )
    right.yaxis.label.set_color(HEATING)
