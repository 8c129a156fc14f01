"""Random numbers by counting: a number depends on a seed and on four counters, and on nothing that was drawn before.

So lanes may be computed in any order and on any number of threads, and each one can be repeated alone.
"""

from __future__ import annotations

import math

import numpy as np

from musclewire.compiled import compiled

__all__ = ["philox", "normal_pair", "uniform"]

ROUNDS = 10
# Multipliers and increments of the key, as published.
MULTIPLIER_0 = np.uint64(0xD2511F53)
MULTIPLIER_1 = np.uint64(0xCD9E8D57)
WEYL_0 = np.uint64(0x9E3779B9)
WEYL_1 = np.uint64(0xBB67AE85)
LOW_WORD = np.uint64(0xFFFFFFFF)  # the lower half of a product
WORD_BITS = np.uint64(32)
# The middle of each of the 2^32 equal parts of the interval from 0 to 1: never 0, whose logarithm has no value.
PER_WORD = 2.0**-32
HALF_WORD = 2.0**-33


@compiled
def philox(
    counter_0: int, counter_1: int, counter_2: int, counter_3: int, key: int
) -> tuple[np.uint64, np.uint64, np.uint64, np.uint64]:
    """Return the four 32-bit words of Philox4x32-10 for a counter of four words and a key of 64 bits.

    References
    ----------
    Salmon, Moraes, Dror and Shaw 2011, doi 10.1145/2063384.2063405.
    """
    c0, c1 = np.uint64(counter_0) & LOW_WORD, np.uint64(counter_1) & LOW_WORD
    c2, c3 = np.uint64(counter_2) & LOW_WORD, np.uint64(counter_3) & LOW_WORD
    k0, k1 = np.uint64(key) & LOW_WORD, np.uint64(key) >> WORD_BITS
    for _ in range(ROUNDS):
        first, second = MULTIPLIER_0 * c0, MULTIPLIER_1 * c2
        c0, c2 = (second >> WORD_BITS) ^ c1 ^ k0, (first >> WORD_BITS) ^ c3 ^ k1
        c1, c3 = second & LOW_WORD, first & LOW_WORD
        k0, k1 = (k0 + WEYL_0) & LOW_WORD, (k1 + WEYL_1) & LOW_WORD
    return c0, c1, c2, c3


@compiled
def uniform(word: np.uint64) -> float:
    """Return a 32-bit word as a number between 0 and 1, without both ends."""
    return float(word) * PER_WORD + HALF_WORD


@compiled
def normal_pair(first: np.uint64, second: np.uint64) -> tuple[float, float]:
    """Return two independent normal numbers of variance 1 from two words.

    References
    ----------
    Box and Muller 1958, doi 10.1214/aoms/1177706645.
    """
    radius = math.sqrt(-2.0 * math.log(uniform(first)))
    angle = 2.0 * math.pi * uniform(second)
    return radius * math.cos(angle), radius * math.sin(angle)
