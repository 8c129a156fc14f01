"""Fuzzy-tuned PID, drive limits and target trajectories: state in, state out; no clock, no hardware.

A controller takes a number, so it runs alike on a sensor and on an estimate from the wire's own resistance.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
