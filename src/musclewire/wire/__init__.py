"""One wire: its row, one step and its balances; through time in a driving circuit, alone or with others."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
