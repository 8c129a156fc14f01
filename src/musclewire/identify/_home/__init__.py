"""The home move's evidence: a sweep at a known load against the loop that a model was fitted to.

``homed_model`` is the pure part: model and recorded sweep in, model of today out. Driving a rig belongs to
``experiment/_home.py``.
"""

from __future__ import annotations

from musclewire.identify._home.homing import Homing, homed_model
from musclewire.identify._home.registration import Registration, register
from musclewire.identify._home.warming import HeatCourse, WireHeat

__all__ = ["HeatCourse", "Homing", "Registration", "WireHeat", "homed_model", "register"]
