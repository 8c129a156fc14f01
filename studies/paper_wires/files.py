"""From the best vector to the parameter files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path

from paper_wires.unknowns import FILES, NAMES, SPOOLS, FloatArray, alloy_numbers, spool_numbers

SOURCE = (
    "fitted to Lan and Fan 2010 (Table 2, R_min, R_max, A-B, gaps of Figs. 4 to 7, 9 and 17) and Flexinol isobars at "
    "50, 100 and 200 MPa (measured, maestrolab/calibrating); studies/fit_paper_wires.py"
)
SPOOL_SOURCE = SOURCE + "; a spool's temperatures lie within 5 K of its alloy's"
DATA = Path(str(files("musclewire.parameters"))) / "data"
SHIFTS = ("temperature_shift_k", "r_phase_shift_k")


def write_parameter_files(vector: FloatArray) -> None:
    """Write a vector into the alloy, the paper's wires, the isobars' sample and the bench, in place.

    Only the numbers that the search moves, with their kind and source; notes stay.
    """
    numbers = dict(zip(NAMES, (float(value) for value in vector), strict=True))
    put(DATA / "alloys" / "flexinol.toml", alloy_numbers(numbers))
    for spool in SPOOLS:
        path = DATA / "wires" / f"{FILES[spool]}.toml"
        own = spool_numbers(numbers, spool)
        put(path, {name: own[name] for name in SHIFTS}, SPOOL_SOURCE)
        put(path, {"convection_factor": own["convection_factor"]})
        if spool != "100um":
            put(path, {"drive_amplitude_v": numbers[f"amplitude_{spool}_v"]})
    sample = DATA / "wires" / "isobar-sample.toml"
    put(sample, {"convection_factor": numbers["convection_factor"]})
    put(sample, {"temperature_shift_k": numbers["isobar_sample_shift_k"]})
    put(DATA / "benches" / "paper.toml", {"guide_friction_n": numbers["guide_friction_n"]})


def put(path: Path, numbers: Mapping[str, float], source: str = SOURCE) -> None:
    """Replace value, kind and source of some parameters in a TOML file, leaving all else as it stands."""
    text = path.read_text("utf-8")
    for name, value in numbers.items():
        pattern = rf'(\[{name}\]\nvalue = )\S+(\nunit = "[^"]*"\nkind = )"[^"]*"(\nsource = )"[^"]*"'
        text, count = re.subn(pattern, rf'\g<1>{value:.6g}\g<2>"fitted"\g<3>"{source}"', text)
        if count != 1:
            raise ValueError(f"{path} has {count} tables [{name}] of the usual form, not one")
    path.write_text(text, "utf-8")
