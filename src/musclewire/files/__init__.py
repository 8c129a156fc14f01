"""From a file of musclewire or of another program to a recording: columns, units, clocks, and every check."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
