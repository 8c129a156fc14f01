"""Figures of one look: styles by name, for a screen, slides and the columns of journals."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
