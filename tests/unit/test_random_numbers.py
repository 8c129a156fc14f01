"""Random numbers by counting: the published test vectors, and the law of the normal numbers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from musclewire.random_numbers import normal_pair, philox, uniform

ONES = 0xFFFFFFFF
# Counter, key and result, from the file of known answers that its authors publish with Random123.
KNOWN = [
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((ONES, ONES, ONES, ONES), (ONES, ONES), (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]


@pytest.mark.parametrize(("counter", "key", "words"), KNOWN)
def test_philox_gives_the_published_words(counter: tuple[int, ...], key: tuple[int, int], words: tuple[int]) -> None:
    assert tuple(int(word) for word in philox(*counter, np.uint64(key[1] << 32 | key[0]))) == words


def test_both_numbers_of_a_pair_are_normal_and_independent() -> None:
    pairs = np.array([normal_pair(*philox(count, 0, 0, 0, 11)[:2]) for count in range(20000)])
    assert stats.kstest(pairs[:, 0], "norm").pvalue > 1e-3
    assert stats.kstest(pairs[:, 1], "norm").pvalue > 1e-3
    assert abs(np.corrcoef(pairs.T)[0, 1]) < 0.03  # four standard deviations of the mean of 20000 products


def test_the_ends_of_the_interval_are_never_drawn() -> None:
    assert uniform(np.uint64(0)) > 0.0
    assert uniform(np.uint64(ONES)) < 1.0
