"""Public recordings of real wires: what our estimators and the wire's model make of them, beside simple baselines.

Nothing is downloaded, and of the recordings named here only those of studies/data are shipped. Give the folder of your
own copies; a file that is not there is listed as not tried, and of one that is the checksum is printed.

Baselines are judged at points that their fit has not seen: each is left out once, or, of pulses, all from the fifth of
a condition on. Ours are fitted to all points but those of pulses: the paper's polynomial, or the wire's model for
isobars, which have a temperature and no resistance. Errors are rms / largest, in percent of the largest stroke.

    python studies/real_recordings.py [FOLDER] [--json]
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import musclewire as mw
from musclewire.errors import MusclewireError
from musclewire.extras.calibration import SearchSettings, calibrate
from musclewire.signals import Recording

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]
DATA = Path(__file__).parent / "data"
TABLE_2 = Path(mw.__file__).parent / "parameters" / "data" / "published" / "lan-fan-2010-table-2.csv"
MICHIGAN = "YILINUMICH/MicroTensileMachine"
PULSES = "Experiment_SMAThermalCharacterization/data/derived"
# Pulses of one condition from this one on are estimated from those before it.
FIRST_ESTIMATED = 5


class Points(NamedTuple):
    """Points of a recording, each (n,): what is read, the stroke, whether heating, and which are fitted and judged.

    Parameters
    ----------
    read
        Resistance [ohm], or over the cold resistance, or temperature [K].
    stroke
        Displacement [m], or strain as a fraction.
    heating
        Whether the wire was heated.
    session
        Number of the part within which a point was measured: one fit is for all of a part.
    energy_j
        Energy of the pulse [J]; None without pulses.
    fitted
        Which points are fitted and all others judged; None to leave out each point once.
    """

    read: FloatArray
    stroke: FloatArray
    heating: Mask
    session: NDArray[np.intp]
    energy_j: FloatArray | None = None
    fitted: Mask | None = None


class Source(NamedTuple):
    """A public recording: where it is from, its licence as found, its files, and how they are read."""

    name: str
    repository: str
    commit: str
    licence: str
    files: tuple[str, ...]
    points: Callable[[list[Path]], Points]
    ours: Callable[[list[Path], Points], FloatArray]


def table_2(paths: list[Path]) -> Points:
    """Return the printed points of the paper's own wire."""
    table = mw.read_recording(paths[0])
    count = len(table.columns["resistance_ohm"])
    return Points(
        np.tile(table["resistance_ohm"], 2),
        np.concatenate([table["strain_heating"], table["strain_cooling"]]),
        np.repeat([True, False], count),
        np.zeros(2 * count, dtype=np.intp),
    )


def isobars(paths: list[Path]) -> Points:
    """Return measured isobars: no resistance was measured, and temperature is read in its place."""
    loops = [isobar(path) for path in paths]
    rows = [(loop["wire_temperature_k"], contraction(loop)) for loop in loops]
    hot = [np.arange(read.size) <= np.argmax(read) for read, _ in rows]
    sessions = np.repeat(np.arange(len(rows)), [read.size for read, _ in rows])
    read, strain = (np.concatenate(part) for part in zip(*rows, strict=True))
    return Points(read, strain, np.concatenate(hot), sessions)


def isobar(path: Path) -> Recording:
    """Return a file of one isobar as a recording."""
    if path.suffix == ".csv":
        with path.open(encoding="utf-8") as file:
            degc, strain = np.array([(row["temperature_degc"], row["strain"]) for row in csv.DictReader(file)], float).T
        stress_pa = np.full(degc.size, 1e6 * float(path.stem.removeprefix("flexinol_").removesuffix("MPa")))
    else:
        degc, percent, mpa = np.loadtxt(path).T
        strain, stress_pa = 0.01 * percent, 1e6 * mpa
    return Recording({"wire_temperature_k": degc + 273.15, "reference_strain": strain, "stress_pa": stress_pa})


def contraction(loop: Recording) -> FloatArray:
    """Return the strain of an isobar from its cold end, contraction positive."""
    strain = loop["reference_strain"]
    return np.asarray(strain.max() - strain)


def pulses(paths: list[Path]) -> Points:
    """Return pulses of one coil: resistance at their end over that before, peak displacement, and energy."""
    with paths[0].open(encoding="utf-8") as file:
        rows = [
            row for row in csv.DictReader(file) if row["detect_ok"] == "1" and row["clipped"] == row["railed"] == "0"
        ]
    hot, cold, watt, ms, um, cycle = (
        np.array([float(row[name]) for row in rows])
        for name in ("r_hot_ohm", "r_base_ohm", "p_hot_W", "heat_ms", "dx_um", "cycle")
    )
    every = np.ones(hot.size, dtype=np.bool_)
    return Points(hot / cold, 1e-6 * um, every, np.zeros(hot.size, np.intp), 1e-3 * ms * watt, cycle < FIRST_ESTIMATED)


def coil_loop(paths: list[Path]) -> Points:
    """Return one pulse and its cooling: resistance of an LCR meter that repeats its readings, and a laser."""
    with paths[0].open(encoding="utf-8") as file:
        rows = np.array([(row["rs_raw_ohm"], row["displacement_mm"]) for row in csv.DictReader(file)], float)
    rows = rows[np.isfinite(rows).all(axis=1)]
    ohm, mm = rows[np.append(True, np.diff(rows[:, 0]) != 0.0)].T
    mm = mm - np.median(mm[: max(mm.size // 20, 1)])
    mm = -mm if abs(mm.min()) > mm.max() else mm
    return Points(ohm, 1e-3 * mm, np.arange(mm.size) <= np.argmax(mm), np.zeros(mm.size, np.intp))


def by_the_wires_model(paths: list[Path], points: Points) -> FloatArray:
    """Return the strain of the wire's model, calibrated on all isobars at once, at each point."""
    loops = {path.stem: isobar(path) for path in paths}
    found = calibrate(loops, priors="sma-isobars", settings=SearchSettings(seed=1))
    off = [pair.predicted - pair.channel.measured for _, pair in found.comparisons()]
    return points.stroke - np.concatenate(off)


def by_the_papers_polynomial(paths: list[Path], points: Points) -> FloatArray:
    """Return what the paper's polynomial says: of its printed table, or of readings alone, without current."""
    if paths == [TABLE_2]:
        return mw.fit(mw.read_recording(TABLE_2), order="auto").estimate(points.read).value
    read, stroke = points.read, points.stroke
    if points.fitted is not None:  # pulses have no cooling: each point stands on both branches
        order = np.argsort(stroke[points.fitted])
        order = np.concatenate([order, order[::-1]])
        read, stroke = read[points.fitted][order], stroke[points.fitted][order]
    return mw.fit(read, stroke, quantity="displacement", order="auto").estimate(points.read).value


SOURCES = (
    Source(
        "Lan and Fan 2010, Table 2", "in the package", "", "printed", (str(TABLE_2),), table_2, by_the_papers_polynomial
    ),
    Source(
        "NiTiHf, 6 isobars",
        "maestrolab/SMA-REACT",
        "45bac2c7",
        "BSD-3-Clause",
        tuple(f"sma_react/NiTiHf_{mpa}MPa.txt" for mpa in (7, 50, 100, 200, 300, 400)),
        isobars,
        by_the_wires_model,
    ),
    Source(
        "Flexinol, 5 isobars",
        "maestrolab/calibrating",
        "be63692d",
        "MIT by setup.py",
        tuple(f"flexinol_isobars/flexinol_{mpa}MPa.csv" for mpa in (50, 100, 150, 172, 200)),
        isobars,
        by_the_wires_model,
    ),
    Source(
        "coil A, pulses",
        MICHIGAN,
        "e3e7ae16",
        "none found",
        (f"{PULSES}/heat_time_map_20260731_all.csv",),
        pulses,
        by_the_papers_polynomial,
    ),
    Source(
        "coil B, pulses",
        MICHIGAN,
        "6030ee42",
        "none found",
        (f"{PULSES}/heat_time_map_20260805_dynalloy_all.csv",),
        pulses,
        by_the_papers_polynomial,
    ),
    Source(
        "coil, one pulse and its cooling",
        MICHIGAN,
        "f317127b",
        "none found",
        ("SMA_Characterization/data/sma_run_20260424_160556_processed.csv",),
        coil_loop,
        by_the_papers_polynomial,
    ),
)
# Degree of the polynomial, and whether each branch has its own.
BASELINES = {"line": (1, False), "quadratic": (2, False), "line a branch": (1, True), "cubic a branch": (3, True)}


def by_curves(points: Points, read: FloatArray, degree: int, of_each_branch: bool) -> FloatArray:
    """Return a polynomial's estimate of every judged point, NaN elsewhere: of points that its fit has not seen."""
    found = np.full(points.stroke.size, np.nan)
    branch = points.heating if of_each_branch else np.zeros(read.size, dtype=np.bool_)
    for part in {(int(one), bool(other)) for one, other in zip(points.session, branch, strict=True)}:
        rows = np.flatnonzero((points.session == part[0]) & (branch == part[1]))
        scaled = (read[rows] - read[rows].mean()) / max(float(np.ptp(read[rows])), 1e-12)
        powers = np.vander(scaled, degree + 1)
        if points.fitted is not None:
            fitted = points.fitted[rows]
            weight = np.linalg.lstsq(powers[fitted], points.stroke[rows][fitted])[0]
            found[rows[~fitted]] = powers[~fitted] @ weight
        elif rows.size > degree + 1:
            hat = powers @ np.linalg.pinv(powers)
            off = (points.stroke[rows] - hat @ points.stroke[rows]) / (1.0 - np.diag(hat))  # each left out once
            found[rows] = points.stroke[rows] - off
    return found


def error_pct(points: Points, estimated: FloatArray) -> tuple[float, float]:
    """Return the rms and the largest error of the judged points [%] of the largest stroke."""
    judged = np.isfinite(estimated) & (np.bool_(True) if points.fitted is None else ~points.fitted)
    off = 100.0 * np.abs(estimated - points.stroke)[judged] / float(points.stroke.max())
    return float(np.sqrt(np.mean(off**2))), float(off.max())


def copy_of(name: str, folder: Path | None) -> Path | None:
    """Return where a file is: shipped, or in the reader's folder by its path or its name alone; None if nowhere."""
    places = [Path(name), DATA / name, *([] if folder is None else [folder / name, folder / Path(name).name])]
    return next((place for place in places if place.is_file()), None)


def tried(source: Source, folder: Path | None) -> dict[str, Any]:
    """Return what became of a recording: its errors by method, or that it was not tried."""
    stated = {"name": source.name, "from": f"{source.repository} {source.commit}".strip(), "licence": source.licence}
    places = [copy_of(name, folder) for name in source.files]
    paths = [place for place in places if place is not None]
    if len(paths) < len(places):
        return {**stated, "files": {Path(name).name: "not tried" for name in source.files}}
    sums = {path.name: hashlib.sha256(path.read_bytes()).hexdigest()[:8] for path in paths}
    points = source.points(paths)
    found: dict[str, Any] = {
        name: error_pct(points, by_curves(points, points.read, degree, each))
        for name, (degree, each) in BASELINES.items()
    }
    if points.energy_j is not None:
        found["energy"] = error_pct(points, by_curves(points, points.energy_j, 2, False))
    try:
        found["ours"] = error_pct(points, source.ours(paths, points))
    except MusclewireError as error:
        found["ours"] = f"refused: {error}"
    return {**stated, "files": sums, "points": points.stroke.size, **found}


def tables(rows: list[dict[str, Any]]) -> str:
    """Return the errors of what was tried, and where each recording is from, as two tables in Markdown."""
    columns = [*BASELINES, "energy", "ours"]
    lines = ["| recording | points | " + " | ".join(columns) + " |", "|---" * (len(columns) + 2) + "|"]
    for row in rows:
        if "points" in row:
            cells = [row.get(name, "-") for name in columns]
            shown = [f"{one[0]:.2f} / {one[1]:.1f}" if isinstance(one, tuple) else str(one) for one in cells]
            lines.append(f"| {row['name']} | {row['points']} | {' | '.join(shown)} |")
    lines += ["", "| recording | from | licence as found | files, first digits of their SHA-256 |", "|---" * 4 + "|"]
    for row in rows:
        files = ", ".join(f"{name} {found}" for name, found in row["files"].items())
        lines.append(f"| {row['name']} | {row['from']} | {row['licence']} | {files} |")
    return "\n".join(lines)


def main() -> None:
    """Print both tables, or one JSON document."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, help="folder of your own copies")
    parser.add_argument("--json", action="store_true", help="one JSON document")
    asked = parser.parse_args()
    rows = [tried(source, asked.folder) for source in SOURCES]
    print(json.dumps(rows, indent=2) if asked.json else tables(rows))


if __name__ == "__main__":
    main()
