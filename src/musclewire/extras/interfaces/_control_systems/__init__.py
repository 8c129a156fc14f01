"""The simulated wire for python-control: systems, operating points, linearisations and margins of its closed loop.

Needs the extra ``control`` (python-control).
"""

from musclewire.errors import MissingExtraError

try:
    import control  # noqa: F401  # asked for here, so that its absence is said before anything is computed
except ImportError:
    raise MissingExtraError("a system of python-control", "control") from None

from musclewire.extras.interfaces._control_systems.linearisation import LinearWire, SampledWire, linearised
from musclewire.extras.interfaces._control_systems.loops import (
    LoopMargins,
    controller_system,
    loop_margins,
    sampled_system,
)
from musclewire.extras.interfaces._control_systems.operating_points import OperatingPoint, operating_point
from musclewire.extras.interfaces._control_systems.study import Linearisation, LinearisedLoop, bode_axes, linearise
from musclewire.extras.interfaces._control_systems.systems import branch_system, linear_system, wire_system

__all__ = [
    "LinearWire",
    "Linearisation",
    "LinearisedLoop",
    "LoopMargins",
    "OperatingPoint",
    "SampledWire",
    "bode_axes",
    "branch_system",
    "controller_system",
    "linear_system",
    "linearise",
    "linearised",
    "loop_margins",
    "operating_point",
    "sampled_system",
    "wire_system",
]
