"""Gymnasium environments of a simulated wire; importing this registers them as ``musclewire/Wire-v0``.

Needs the extra ``gym`` (Gymnasium).
"""

from musclewire.errors import MissingExtraError

try:
    import gymnasium
except ImportError:
    raise MissingExtraError("a Gymnasium environment", "gym") from None

from musclewire.extras.interfaces._environments.episodes import Episode
from musclewire.extras.interfaces._environments.single import WireEnv
from musclewire.extras.interfaces._environments.vector import WireVectorEnv

__all__ = ["ENVIRONMENT", "Episode", "WireEnv", "WireVectorEnv"]

ENVIRONMENT = "musclewire/Wire-v0"

if ENVIRONMENT not in gymnasium.registry:
    gymnasium.register(
        ENVIRONMENT,
        entry_point="musclewire.extras.interfaces._environments:WireEnv",
        vector_entry_point="musclewire.extras.interfaces._environments:WireVectorEnv",
    )
