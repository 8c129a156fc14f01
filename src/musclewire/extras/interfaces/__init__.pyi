"""The list of names that other rooms may use."""

from ._control_systems.study import bode_axes as bode_axes
from ._control_systems.study import linearise as linearise
from ._environments import ENVIRONMENT as ENVIRONMENT
from ._environments.vector import MAX_STEP_S as MAX_STEP_S
from ._environments.vector import WireVectorEnv as WireVectorEnv
from ._simulated_wire import simulated_wire as simulated_wire
