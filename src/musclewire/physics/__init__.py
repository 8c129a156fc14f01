"""One published equation per pure function: heat, transformation, resistivity, mechanics.

Every function takes and returns plain floats in SI units and is compiled by Numba, so the same function
serves a doctest, an estimator and the simulator's inner loop.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
