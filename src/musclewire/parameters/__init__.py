"""Wires, alloys, rigs and published results as data files: each number with unit, source and kind."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
