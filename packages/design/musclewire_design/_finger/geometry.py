"""A finger's dimensions, their limits, and their keys in a finger's file.

Along the finger: a palm with a guide hole, then for each column a flexible segment and the column, then the extension
plate. Segments and columns are as many as there are columns and all alike. The tendon runs at ``tendon_offset_m`` from
the beam's middle, on the side the finger bends to; columns and plate count as rigid.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters import Parameter
from musclewire_design._finger.closed_forms import bending_stiffness_n_m2

UNITS = {
    "overall_length_m": "m",
    "plate_length_m": "m",
    "columns": "1",
    "column_width_m": "m",
    "column_height_m": "m",
    "tendon_offset_m": "m",
    "beam_thickness_m": "m",
    "beam_depth_m": "m",
    "inward_angle_rad": "rad",
    "plate_thickness_m": "m",
    "youngs_modulus_pa": "Pa",
}
MAX_COLUMNS = 40
# Holes for the two legs of the tendon: the smallest that are drilled by hand, 0.3 mm.
HOLE_RADIUS_M = 0.15e-3
# Beyond this the unloaded finger already points backwards.
MAX_INWARD_RAD = 0.5 * math.pi


@dataclass(frozen=True)
class FingerGeometry:
    """A finger's dimensions in metres and radians, and the modulus of its material.

    Parameters
    ----------
    overall_length_m
        Length along the beam, plate included [m].
    plate_length_m
        Length of the extension plate at the end [m].
    columns
        Number of columns, and of flexible segments, 1 to 40.
    column_width_m
        Width of a column along the beam [m].
    column_height_m
        From the middle of the beam to the outer end of the isolators [m].
    tendon_offset_m
        From the middle of the beam to the tendon [m], on the side that the finger bends to.
    beam_thickness_m
        Thickness of the flexible segments [m].
    beam_depth_m
        Depth of the finger out of plane [m].
    inward_angle_rad
        What the curved segments add up to without load [rad], 0 for a straight finger, at most a right angle.
    plate_thickness_m
        Thickness of the plate [m].
    youngs_modulus_pa
        Young's modulus of the material [Pa].

    Raises
    ------
    CallerError
        For dimensions that cannot belong to a finger: the message names the dimension and what it collides with.
    """

    overall_length_m: float
    plate_length_m: float
    columns: int
    column_width_m: float
    column_height_m: float
    tendon_offset_m: float
    beam_thickness_m: float
    beam_depth_m: float
    inward_angle_rad: float
    plate_thickness_m: float
    youngs_modulus_pa: float

    def __post_init__(self) -> None:
        """Refuse impossible dimensions, naming the dimension and its conflict."""
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and (value > 0.0 or (field.name == "inward_angle_rad" and value >= 0.0))):
                raise CallerError(f"{field.name} is {value:g}: give a number above 0")
        if not 1 <= self.columns <= MAX_COLUMNS or self.columns != int(self.columns):
            raise CallerError(f"a finger has 1 to {MAX_COLUMNS} columns, not {self.columns:g}")
        if self.segment_length_m <= 0.0:
            taken = self.columns * self.column_width_m + self.plate_length_m
            raise CallerError(
                f"{self.columns} columns of {1e3 * self.column_width_m:g} mm and a plate of "
                f"{1e3 * self.plate_length_m:g} mm take {1e3 * taken:g} mm of an overall length of "
                f"{1e3 * self.overall_length_m:g} mm: nothing is left to bend, make the finger longer"
            )
        self._check_tendon()

    def _check_tendon(self) -> None:
        """Refuse a tendon that would run inside the beam or outside the columns, and plates that lean too far."""
        if self.inward_angle_rad > MAX_INWARD_RAD:
            raise CallerError(f"inward_angle_rad is {self.inward_angle_rad:g}: at most a right angle, 1.57")
        if self.tendon_offset_m <= 0.5 * self.beam_thickness_m:
            raise CallerError(
                f"tendon_offset_m is {1e3 * self.tendon_offset_m:g} mm: the tendon would run inside the beam of "
                f"{1e3 * self.beam_thickness_m:g} mm, give more than half of that"
            )
        if self.column_height_m <= self.tendon_offset_m + HOLE_RADIUS_M:
            raise CallerError(
                f"column_height_m is {1e3 * self.column_height_m:g} mm: holes of 0.3 mm at "
                f"{1e3 * self.tendon_offset_m:g} mm would not be inside the column, give more"
            )

    @property
    def segment_length_m(self) -> float:
        """Length of one flexible segment along its arc [m]."""
        return (self.overall_length_m - self.plate_length_m) / self.columns - self.column_width_m

    @property
    def flexible_length_m(self) -> float:
        """Length of all flexible segments [m]."""
        return self.columns * self.segment_length_m

    @property
    def stiffness_n_m2(self) -> float:
        """Bending stiffness EI of the beam [N m2]."""
        return bending_stiffness_n_m2(self.youngs_modulus_pa, self.beam_depth_m, self.beam_thickness_m)

    def with_(self, **changes: float) -> FingerGeometry:
        """Return the geometry with other dimensions, as in ``geometry.with_(columns=8)``."""
        return replace(self, **changes)  # type: ignore[arg-type]

    def values(self) -> dict[str, float]:
        """Return the numbers by name, in the order in which files and JSON have them."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @classmethod
    def from_parameters(cls, items: Mapping[str, Parameter], where: str) -> FingerGeometry:
        """Return the geometry of a finger file; other keys of the file are ignored.

        Parameters
        ----------
        items
            The numbers of the file's table ``[geometry]``, by key.
        where
            What the file is called in a message.

        Returns
        -------
        The geometry, checked.

        Raises
        ------
        CallerError
            For a number that is missing or has another unit, and for dimensions that cannot belong to a finger.
        """
        for key, unit in UNITS.items():
            if key not in items:
                raise CallerError(f"{where}: geometry.{key} is missing{nearest_hint(key, items)}")
            if items[key].unit != unit:
                raise CallerError(f"{where}: geometry.{key} has the unit '{items[key].unit}', it must be '{unit}'")
        values = {key: items[key].value for key in UNITS}
        return cls(**{**values, "columns": round(values["columns"])})  # type: ignore[arg-type]
