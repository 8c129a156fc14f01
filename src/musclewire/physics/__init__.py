"""Published equations as pure functions of plain floats in SI units: heat loss, measured resistance, friction."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
