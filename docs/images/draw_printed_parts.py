"""Draw the printed finger and pretensioner of docs/how-to/design_a_finger.md, as their STL files have them:
python docs/images/draw_printed_parts.py

The surfaces are drawn by depth, with a light from the left, so that the picture is of the files and of nothing else.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh
from matplotlib.figure import Figure

HERE = Path(__file__).parent
SPECIFICATIONS = HERE.parent.parent / "examples" / "printed"
PARTS = {"pretensioner": "petg_pretensioner", "finger": "petg_finger"}
# Okabe and Ito's blue and orange: told apart by everybody.
COLOURS = {"pretensioner": (0.0, 0.447, 0.698), "finger": (0.902, 0.624, 0.0)}
PIXELS_PER_MM, SAMPLES = 16, 2
TURN_RAD, TILT_RAD = np.radians(-28.0), np.radians(-40.0)
LIGHT = np.array([-0.35, 0.45, 0.82])


def main() -> None:
    """Write the solids by the commands of the page, and their picture."""
    with tempfile.TemporaryDirectory() as folder:
        meshes = {part: mesh_of(part, Path(folder)) for part in PARTS}
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    grid = figure.subplots(1, 2, width_ratios=(1.0, 1.35))
    for axes, (part, mesh) in zip(grid, meshes.items(), strict=True):
        image, millimetre = rendered(mesh, COLOURS[part])
        axes.imshow(image, interpolation="antialiased")
        axes.set_axis_off()
        size = mesh.extents
        axes.set_title(f"{part}, {size[0]:.1f} x {size[1]:.1f} x {size[2]:.1f} mm", fontsize=10)
        high, wide = image.shape[:2]
        axes.plot([0.03 * wide, 0.03 * wide + 10 * millimetre], [0.97 * high] * 2, color="black", linewidth=2)
        axes.text(0.03 * wide + 10.5 * millimetre, 0.97 * high, "10 mm", va="center", fontsize=9)
    figure.savefig(HERE / "printed_parts.png", dpi=150)


def mesh_of(part: str, folder: Path) -> trimesh.Trimesh:
    """Return the mesh that the design command writes for a part."""
    file = folder / f"{part}.stl"
    command = ["design", part, str(SPECIFICATIONS / f"{PARTS[part]}.toml"), "--solid", str(file)]
    subprocess.run([sys.executable, "-m", "musclewire", *command], check=True, stdout=subprocess.DEVNULL)
    return trimesh.load_mesh(file)


def rendered(mesh: trimesh.Trimesh, colour: tuple[float, float, float]) -> tuple[np.ndarray, float]:
    """Return a picture (rows, columns, 3) of a mesh, and how many of its pixels are a millimetre."""
    turn = trimesh.transformations.euler_matrix(TILT_RAD, 0.0, 0.0) @ trimesh.transformations.euler_matrix(
        0.0, 0.0, TURN_RAD
    )
    turned = mesh.copy()
    turned.apply_transform(turn)
    scale = PIXELS_PER_MM * SAMPLES
    margin = 2.0
    corner = turned.bounds[0] - margin
    wide, high = (np.ceil((turned.bounds[1] - turned.bounds[0] + 2 * margin)[:2] * scale)).astype(int)
    depth = np.full((high, wide), -np.inf)
    faces = np.full((high, wide), -1)
    for index, triangle in enumerate((turned.triangles - corner) * [scale, scale, 1.0]):
        fill(depth, faces, triangle, index)
    light = LIGHT / np.linalg.norm(LIGHT)
    shade = 0.45 + 0.55 * np.clip(turned.face_normals @ light, 0.0, 1.0)
    image = np.ones((high, wide, 3))
    seen = faces >= 0
    image[seen] = np.outer(shade[faces[seen]], colour)
    image[edges(depth, turned.face_normals[faces], seen)] = 0.1
    image = image[::-1]
    high, wide = (size - size % SAMPLES for size in (high, wide))
    blocks = image[:high, :wide].reshape(high // SAMPLES, SAMPLES, wide // SAMPLES, SAMPLES, 3)
    return blocks.mean(axis=(1, 3)), float(PIXELS_PER_MM)


def fill(depth: np.ndarray, faces: np.ndarray, triangle: np.ndarray, index: int) -> None:
    """Draw one triangle where it is nearer than what is there."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = triangle
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    if area <= 1e-9:
        return  # seen from behind or on edge
    low = np.maximum(np.floor(triangle.min(axis=0)[:2]).astype(int), 0)
    top = np.ceil(triangle.max(axis=0)[:2]).astype(int) + 1
    y, x = np.mgrid[low[1] : top[1], low[0] : top[0]] + 0.5
    second = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
    third = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
    place = np.s_[low[1] : top[1], low[0] : top[0]]
    if depth[place].shape != x.shape:
        return
    z = az + second * (bz - az) + third * (cz - az)
    inside = (second >= -1e-9) & (third >= -1e-9) & (second + third <= 1.0 + 1e-9) & (z > depth[place])
    depth[place][inside], faces[place][inside] = z[inside], index


def edges(depth: np.ndarray, normals: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return where a line belongs: at the rim, and where depth or direction jump."""
    found = np.zeros(seen.shape, dtype=bool)
    solid = np.where(seen, depth, -1e3)
    for axis in (0, 1):
        jump = np.abs(np.diff(solid, axis=axis)) > 0.8
        before, after = ((slice(None),) * axis + (part,) for part in (slice(None, -1), slice(1, None)))
        bend = (normals[after] * normals[before]).sum(axis=-1) < 0.8
        found[after] |= jump | (bend & seen[after] & seen[before])
    return found


if __name__ == "__main__":
    main()
