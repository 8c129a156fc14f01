"""One published equation per pure function: heat, transformation, resistivity, mechanics.

Every function takes and returns plain floats in SI units and is compiled by Numba, so the same function
serves a doctest, an estimator and the simulator's inner loop.
"""
