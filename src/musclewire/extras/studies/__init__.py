"""Studies of many wires: what varies, what is run, where it is evaluated, and what becomes of the results."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
