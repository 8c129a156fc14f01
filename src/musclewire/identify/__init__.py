"""From recordings to models: strain and resistance of a recorded wire, and the fit of one to the other."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
