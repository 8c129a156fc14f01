"""The simulated wire for python-control: systems, operating points, linearisations and margins of its closed loop.

Needs the extra ``control`` (python-control).
"""

from musclewire.errors import MissingExtraError

try:
    import control  # noqa: F401  # asked for here, so that its absence is said before anything is computed
except ImportError:
    raise MissingExtraError("a system of python-control", "control") from None
