"""From voltages to strain: resistance (Eq. 1), segments A-B-C, gaps (Eq. 2), polynomials (Eqs. 3-5), models.

Source: Lan and Fan 2010, "Investigation on Pretensioned Shape Memory Alloy Actuators for Force and
Displacement Self-Sensing". Every function takes plain floats or arrays, time first; nothing here reads a
clock, a rig or the simulator.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
