"""Samples and recordings, which all rooms use, and the reading and writing of recordings."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
