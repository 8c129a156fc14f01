"""Geometry of a serpentine flexure: its dimensions, its centre line, its fittings.

The wire pulls along y. A strip of one thickness leaves the clamping pad on the axis x = 0, goes to and fro across it,
and ends on the axis in the connector. Dimensions are those of the centre line:

                 ___
                |___|           connector, hole for wire and tendon
                  |
       ___________|             half a beam
      |                  ^
      |____________________     pitch p between beams
                           |
       ____________________|    a beam of length 2a, from -a to +a
      |
      |___________              half a beam
                  |
        __________|_________
       |  o              o  |   pad, two holes

N links of length p join N - 1 whole beams and two halves: N beams' worth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from musclewire.errors import CallerError

# A strip shorter than this many thicknesses is no beam: closed forms and intuition end there.
MIN_HALF_BEAM = 2.0
# Inner radius of a corner over the thickness.
USUAL_CORNER = 0.25
# More beams are no longer made in one piece, and their finite elements take minutes.
MAX_BEAMS = 60


class CentreLineStraight(NamedTuple):
    """A straight piece of the centre line: where it begins and ends [m]."""

    start_m: tuple[float, float]
    end_m: tuple[float, float]

    @property
    def length_m(self) -> float:
        """Length [m]."""
        return math.dist(self.start_m, self.end_m)


class CentreLineArc(NamedTuple):
    """A rounded corner of the centre line: centre, radius, angle where it begins, angle it turns by (left positive)."""

    centre_m: tuple[float, float]
    radius_m: float
    start_rad: float
    turn_rad: float

    @property
    def length_m(self) -> float:
        """Length [m]."""
        return self.radius_m * abs(self.turn_rad)


class AvailableRoom(NamedTuple):
    """Available room across the wire, along it and out of plane [m]; it holds pad and connector too."""

    across_m: float
    along_m: float
    depth_m: float


@dataclass(frozen=True)
class SerpentineFittings:
    """Fittings of a serpentine: a clamping pad with screw holes, and a connector with a hole for wire and tendon."""

    pad_height_m: float = 5e-3
    pad_hole_diameter_m: float = 2.2e-3  # M2, medium fit of ISO 273
    connector_height_m: float = 4e-3
    connector_width_m: float = 6e-3
    connector_hole_diameter_m: float = 1.5e-3
    pad_width_m: float = 12e-3  # minimum; as wide as the beams if they are wider


@dataclass(frozen=True)
class SerpentineGeometry:
    """A serpentine flexure. ``beams`` is N; lengths are those of the centre line, ``depth_m`` is out of plane.

    ``corner_radius_m`` is that of the inner edge of every corner. Raises CallerError for dimensions that cannot be
    made.
    """

    beams: int
    half_length_m: float
    pitch_m: float
    thickness_m: float
    depth_m: float
    corner_radius_m: float
    fittings: SerpentineFittings = field(default_factory=SerpentineFittings)

    def __post_init__(self) -> None:
        """Refuse impossible dimensions, in one line that names the wrong number and its limits."""
        for name in ("half_length_m", "pitch_m", "thickness_m", "depth_m"):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise CallerError(f"a serpentine's {words(name)} is {1e3 * value:g} mm: it must be above 0")
        if not 1 <= self.beams <= MAX_BEAMS:
            raise CallerError(f"a serpentine has 1 to {MAX_BEAMS} beams, not {self.beams}")
        if not 0.0 <= self.corner_radius_m < math.inf:
            raise CallerError(
                f"a serpentine's corner radius is {1e3 * self.corner_radius_m:g} mm: it must be 0 or more"
            )
        self._check_corners()

    def _check_corners(self) -> None:
        """Refuse beams that touch, corners that do not fit between them, and beams that are no flexures."""
        widest = self.pitch_m - self.thickness_m
        if widest <= 0.0:
            raise CallerError(
                f"beams of {1e3 * self.thickness_m:g} mm at a pitch of {1e3 * self.pitch_m:g} mm leave no gap: the "
                f"pitch must be above the thickness, {-1e3 * widest:.3g} mm more at least"
            )
        if 2.0 * self.corner_radius_m > widest + 1e-12:
            raise CallerError(
                f"a corner radius of {1e3 * self.corner_radius_m:g} mm does not fit between beams "
                f"{1e3 * widest:.3g} mm apart: pitch less thickness must be twice the radius at least"
            )
        if self.half_length_m < MIN_HALF_BEAM * self.thickness_m + self.centre_radius_m:
            least = MIN_HALF_BEAM * self.thickness_m + self.centre_radius_m
            raise CallerError(
                f"a half length of {1e3 * self.half_length_m:g} mm is too short for beams of "
                f"{1e3 * self.thickness_m:g} mm: it is no flexure below {1e3 * least:.3g} mm"
            )

    @classmethod
    def with_corner_fraction(
        cls,
        beams: int,
        half_length_m: float,
        pitch_m: float,
        thickness_m: float,
        depth_m: float,
        corner_fraction: float = USUAL_CORNER,
    ) -> SerpentineGeometry:
        """Return a serpentine whose corners have an inner radius of a fraction of the thickness, at most what fits.

        Larger radii reduce the stress and the length that the closed form counts.
        """
        radius = min(corner_fraction * thickness_m, 0.5 * (pitch_m - thickness_m))
        return cls(beams, half_length_m, pitch_m, thickness_m, depth_m, max(radius, 0.0))

    def with_(self, **changes: float) -> SerpentineGeometry:
        """Return the geometry with some of its numbers changed."""
        return replace(self, **changes)  # type: ignore[arg-type]

    @property
    def centre_radius_m(self) -> float:
        """Radius of a corner of the centre line [m]."""
        return self.corner_radius_m + 0.5 * self.thickness_m

    @property
    def gap_m(self) -> float:
        """Clear distance between neighbouring beams [m]."""
        return self.pitch_m - self.thickness_m

    @property
    def across_m(self) -> float:
        """Overall size across the wire [m]."""
        return max(2.0 * self.half_length_m + self.thickness_m, self.fittings.connector_width_m, self.pad_width_m)

    @property
    def pad_width_m(self) -> float:
        """Width of the clamping pad [m]."""
        return max(2.0 * self.half_length_m + self.thickness_m, self.fittings.pad_width_m)

    @property
    def first_beam_m(self) -> float:
        """Where the first half beam is, above the pad's lower edge [m]: the gap to the pad is that between beams."""
        return self.fittings.pad_height_m + self.gap_m + 0.5 * self.thickness_m

    @property
    def last_beam_m(self) -> float:
        """Where the last half beam is, above the pad's lower edge [m]."""
        return self.first_beam_m + self.beams * self.pitch_m

    @property
    def connector_m(self) -> float:
        """Where the connector begins, above the pad's lower edge [m]."""
        return self.last_beam_m + 0.5 * self.thickness_m + self.gap_m

    @property
    def along_m(self) -> float:
        """Overall size along the wire [m], pad and connector included, at rest."""
        return self.connector_m + self.fittings.connector_height_m

    @property
    def second_moment_m4(self) -> float:
        """Second moment of area I = b t^3/12 [m^4] of the strip."""
        return self.depth_m * self.thickness_m**3 / 12.0

    def vertices_m(self) -> list[tuple[float, float]]:
        """Return the corners of the centre line [m], from the pad's upper edge to the connector's lower one."""
        a, y = self.half_length_m, self.first_beam_m
        found = [(0.0, self.fittings.pad_height_m), (0.0, y)]
        for link in range(self.beams):
            side = a if link % 2 == 0 else -a
            found += [(side, y), (side, y + self.pitch_m)]
            y += self.pitch_m
        return [*found, (0.0, y), (0.0, self.connector_m)]

    def centre_line(self) -> list[CentreLineStraight | CentreLineArc]:
        """Return the centre line with its rounded corners, from pad to connector."""
        corners, radius = self.vertices_m(), self.centre_radius_m
        pieces: list[CentreLineStraight | CentreLineArc] = []
        start = corners[0]
        for before, corner, after in zip(corners, corners[1:], corners[2:], strict=False):
            into, out = direction(before, corner), direction(corner, after)
            turn = math.copysign(0.5 * math.pi, into[0] * out[1] - into[1] * out[0])
            begins = (corner[0] - radius * into[0], corner[1] - radius * into[1])
            centre = (begins[0] + radius * out[0], begins[1] + radius * out[1])
            pieces.append(CentreLineStraight(start, begins))
            pieces.append(CentreLineArc(centre, radius, math.atan2(-out[1], -out[0]), turn))
            start = (corner[0] + radius * out[0], corner[1] + radius * out[1])
        return [*(piece for piece in pieces if piece.length_m > 1e-12), CentreLineStraight(start, corners[-1])]


def words(name: str) -> str:
    """Return a field's name as words."""
    return name.removesuffix("_m").replace("_", " ")


def direction(start: tuple[float, float], end: tuple[float, float]) -> tuple[float, float]:
    """Return the unit vector from one point to another."""
    length = math.dist(start, end)
    return (end[0] - start[0]) / length, (end[1] - start[1]) / length
