"""A wire's supply: what a drive does to the wire, and which supply, shunt and current the wire needs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
