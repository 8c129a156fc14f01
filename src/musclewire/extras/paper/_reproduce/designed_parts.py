"""The paper's finger and pretensioner as the design tools size them, each computed once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from musclewire.manifest import absent_part
from musclewire.parameters import load_bench, load_finger, load_material, read_published

if TYPE_CHECKING:
    from musclewire_design import PretensionerDesign, PullingScheme

MATERIAL = "pom"
# Contraction that the pretensioner must follow beyond its pretension, as a fraction of the wire's leg.
STROKE = 0.04


@dataclass(frozen=True)
class SizedPretensioner:
    """A pretensioner by its stiffness and its size across the wire, along it and out of plane."""

    stiffness_n_per_m: float
    size_m: tuple[float, float, float]


@dataclass(frozen=True)
class FingerSchemes:
    """Fig. 13(a): ways to pull one finger; ``ratio`` is range over length, distributed over one chord."""

    schemes: tuple[PullingScheme, ...]

    @property
    def ratio(self) -> float:
        """Range to length of the first scheme over that of the second."""
        return self.schemes[0].range_over_length / self.schemes[1].range_over_length


def require_design() -> None:
    """Raise CallerError if the package that sizes parts is not installed."""
    if absent := absent_part("commands", "design"):
        raise absent


@cache
def paper_pretensioner() -> PretensionerDesign:
    """Return a pretensioner designed for the paper's stiffness, pretension and envelope."""
    require_design()
    from musclewire_design import AvailableRoom, PretensionerDuty, PretensionerRequest, design_pretensioner

    paper = read_published("lan_fan_2010")
    printed = paper["pretensioner"]
    bench = load_bench("finger").values()
    duty = PretensionerDuty(
        pretension_n=paper["displacement_gap"]["pretension_n"],
        stroke_m=STROKE * bench["wire_length_m"] / bench["legs"],
        finger_stiffness_n_per_m=paper["finger"]["stiffness_n_per_m"],
    )
    envelope = AvailableRoom(*(size / 1000.0 for size in printed["envelope_mm"]))
    return design_pretensioner(
        PretensionerRequest(printed["stiffness_n_per_m"], duty, load_material(MATERIAL), envelope)
    )


def designed_pretensioner() -> SizedPretensioner:
    """Return stiffness and size of the pretensioner designed for the paper's numbers."""
    made = paper_pretensioner()
    return SizedPretensioner(
        made.stiffness_n_per_m, (made.geometry.across_m, made.geometry.along_m, made.geometry.depth_m)
    )


@cache
def schemes_of_fig13(*, straight: bool = False) -> FingerSchemes:
    """Return the schemes of Fig. 13(a) to the material's allowable stress, on the shipped finger or one not curved."""
    require_design()
    from musclewire_design import compare_schemes, finger_geometry

    geometry = finger_geometry(load_finger("lan-fan-2010"))
    if straight:
        geometry = geometry.with_(inward_angle_rad=0.0)
    longest = 2.0 * load_finger("lan-fan-2010").curve.tendon_travel_m[-1]
    allowed = load_material(MATERIAL).yield_stress_pa.value
    return FingerSchemes(tuple(compare_schemes(geometry, longest, allowed)))
