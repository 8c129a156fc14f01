"""Simulated circuits and instruments that are not those of a sound wire on a steady drive: faults, and pulses."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
