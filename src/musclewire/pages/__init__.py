"""What all pages share: style sheet, key numbers as cards, tables, the look of figures, figures as text in a page."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
