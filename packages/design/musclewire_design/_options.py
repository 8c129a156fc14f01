"""Options of the commands that design parts."""

from __future__ import annotations

from math import inf

from musclewire.app import complete_fingers, complete_materials, option, quantity

DRAWING = option("--drawing", help="Drawing to cut, 1:1 (.svg, .dxf). Repeatable.")
SOLID = option("--solid", help="Solid to print, in millimetres (.stl, .step; extra 'cad'). Repeatable.")
PRETENSION = quantity("--pretension", "N", "Pretension of the wire, both legs of a V together, as '0.71 N'.")
STIFFNESS = quantity("--stiffness", "N/m", "Size a part of this stiffness, as '386.2 N/m'.")
STROKE = quantity("--stroke", "m", "Contraction of the wire, as '1.05 mm'.")
TRAVEL = quantity("--travel", "m", "Largest travel of the connector, where wire, tendon and pretensioner meet.")
FINGER_STIFFNESS = quantity(
    "--finger-stiffness", "N/m", "Stiffness of the finger on the same connector, which must be the greater one."
)
MATERIAL = option(
    "--material",
    help="Material by name ('musclewire design pretensioner --list' shows all), or its .toml file.",
    autocompletion=complete_materials,
)
PROCESS = option("--process", help="Manufacturing process, which limits how thin a beam can be; 'fdm' is 'print'.")
ENVELOPE = option("--envelope", help="Room across the wire, along it, out of plane, as '24.6x27.6x10 mm'.")
BEAMS = option("--beams", help="Compute given dimensions: number of beams.")
HALF_LENGTH = quantity("--half-length", "m", "Half of a beam's length, a.")
PITCH = quantity("--pitch", "m", "Distance between the centre lines of beams, p.")
THICKNESS = quantity("--thickness", "m", "Compute given dimensions: thickness of a beam in the plane of bending, t.")
DEPTH = quantity("--depth", "m", "Depth of the part out of the plane of bending, b.")
MAX_DEPTH = quantity("--max-depth", "m", "Largest depth there is room for.")
TENDON_HOLE = quantity("--tendon-hole", "m", "Diameter of the solid's holes for the tendon's two legs.")
CORNER_RADIUS = quantity("--corner-radius", "m", "Inner radius of corners; by default a quarter of the thickness.")
FINGER = option(
    "--finger",
    help="Take all dimensions from a finger, by name or .toml file.",
    autocompletion=complete_fingers,
)
OFFSET = quantity("--offset", "m", "With --thickness: distance of the tendon from the beam's centre line.")
OVERALL_LENGTH = quantity("--overall-length", "m", "Length along the beam, extension plate included.")
PLATE = quantity("--plate", "m", "Length of the extension plate.")
COLUMNS = option("--columns", help="Number of columns that guide the tendon.")
COLUMN_WIDTH = quantity("--column-width", "m", "Width of a column.")
INWARD_ANGLE = quantity(
    "--inward-angle",
    "rad",
    "Angle by which all unloaded segments together curve inward, as '8 deg'.",
    0.0,
    inf,
)
ENDPOINT = quantity("--endpoint", "m", "Displacement of the endpoint that is wanted, as '6 mm'.")
FRICTION = option("--friction", help="Coefficient of friction between tendon and holes.", min=0.0)
PRETENSIONER = quantity(
    "--pretensioner", "N/m", "Stiffness of the pretensioner on the same connector, as '386.2 N/m', or its .toml file."
)
COMPARE = option("--compare", help="Compare distributed with concentrated actuation.")
REFINED = option("--refined", help="Factor by which the finite elements are finer.", min=1, max=4)
