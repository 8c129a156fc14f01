"""From the best vector to the parameter files."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

from musclewire.parameters.parameter_groups import Alloy
from paper_wires.unknowns import DIAMETERS_UM, NAMES, FloatArray

SOURCE = (
    "fitted to Lan and Fan 2010 (Table 2, R_min, R_max, gaps of Figs. 4, 5, 9) and Flexinol isobars at 50 to 200 MPa "
    "(measured, maestrolab/calibrating); studies/fit_paper_wires.py"
)
SPOOL_SOURCE = SOURCE + "; one shift for the 125 and 200 um spools against the 100 um spool"
DATA = Path(str(files("musclewire.parameters"))) / "data"


def write_parameter_files(vector: FloatArray) -> None:
    """Write a vector into the alloy, the paper's wires, the isobars' sample and the bench, in place.

    Only the numbers that the search moves, with their kind and source; notes stay.
    """
    numbers = dict(zip(NAMES, (float(value) for value in vector), strict=True))
    alloy = {name: numbers[name] for name in NAMES if name in Alloy.model_fields}
    put(DATA / "alloys" / "flexinol.toml", alloy)
    for diameter in DIAMETERS_UM:
        path = DATA / "wires" / f"paper-{diameter}um.toml"
        put(path, {"convection_factor": numbers["convection_factor"]})
        if diameter != 100:
            put(path, {"r_phase_shift_k": numbers["r_phase_shift_125_200um_k"]}, SPOOL_SOURCE)
            put(path, {"drive_amplitude_v": numbers[f"amplitude_{diameter}um_v"]})
    sample = DATA / "wires" / "isobar-sample.toml"
    put(sample, {"convection_factor": numbers["convection_factor"]})
    put(sample, {"temperature_shift_k": numbers["isobar_sample_shift_k"]})
    put(DATA / "benches" / "paper.toml", {"guide_friction_n": numbers["guide_friction_n"]})


def put(path: Path, numbers: dict[str, float], source: str = SOURCE) -> None:
    """Replace value, kind and source of some parameters in a TOML file, leaving all else as it stands."""
    text = path.read_text("utf-8")
    for name, value in numbers.items():
        pattern = rf'(\[{name}\]\nvalue = )\S+(\nunit = "[^"]*"\nkind = )"[^"]*"(\nsource = )"[^"]*"'
        text, count = re.subn(pattern, rf'\g<1>{value:.6g}\g<2>"fitted"\g<3>"{source}"', text)
        if count != 1:
            raise ValueError(f"{path} has {count} tables [{name}] of the usual form, not one")
    path.write_text(text, "utf-8")
