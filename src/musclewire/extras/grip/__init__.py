"""Gripping without a sensor: contact and force of fingers, from their wires' voltages."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
