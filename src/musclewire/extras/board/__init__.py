"""Boards and cards that drive a real wire, and the controller in C for them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
