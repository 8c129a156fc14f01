"""A rig operated live: its process, the web server that shows it, the page, and a client for programs."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
