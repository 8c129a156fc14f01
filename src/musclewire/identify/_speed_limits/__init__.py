"""Speed limits said beforehand: where a reference is faster than its wire, and what would help."""

from musclewire.identify._speed_limits.limits import SpeedLimits, TooFast, speed_limits_of

__all__ = ["SpeedLimits", "TooFast", "speed_limits_of"]
