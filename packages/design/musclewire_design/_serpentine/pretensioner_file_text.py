"""A designed pretensioner as a file (parameters.pretensioner_file), and back."""

from __future__ import annotations

from musclewire.parameters import Parameter, PretensionerFile
from musclewire.small_files import toml_text
from musclewire_design._serpentine.analysis import PretensionerDesign
from musclewire_design._serpentine.geometry import SerpentineGeometry

DIMENSIONS = ("half_length_m", "pitch_m", "thickness_m", "depth_m", "corner_radius_m")


def geometry_of(file: PretensionerFile) -> SerpentineGeometry:
    """Return the serpentine of a pretensioner's file. Raises CallerError if it is none."""
    return SerpentineGeometry(file.geometry.beams, **{name: getattr(file.geometry, name) for name in DIMENSIONS})


def pretensioner_text(made: PretensionerDesign, material_name: str) -> str:
    """Return the text of a pretensioner's file; every number keeps all its bits."""
    geometry = made.geometry
    return toml_text(
        {
            "format": "musclewire-pretensioner",
            "version": 1,
            "material": material_name,
            "process": made.process,
            "geometry": {"beams": geometry.beams} | {name: getattr(geometry, name) for name in DIMENSIONS},
            "computed": {key: item.model_dump() for key, item in computed(made).items()},
        }
    )


def computed(made: PretensionerDesign) -> dict[str, Parameter]:
    """Return the computed numbers of a file."""
    source = "musclewire design pretensioner, plane-stress finite elements"
    values = {
        "stiffness_n_per_m": (made.stiffness_n_per_m, "N/m"),
        "stiffness_guided_n_per_m": (made.guided.stiffness_n_per_m, "N/m"),
        "safe_travel_m": (made.curve.safe_travel_m, "m"),
    }
    return {
        key: Parameter(value=float(value), unit=unit, kind="derived", source=source)
        for key, (value, unit) in values.items()
    }
