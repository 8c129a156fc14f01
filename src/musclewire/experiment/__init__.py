"""Recipes on a rig, their measures, and the one loop that runs them all."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
