"""Rows from a loop to whoever watches it: a ring in shared memory that no reader can make the loop wait for.

One process writes, any number read. A row carries its number before and after its values: a reader that comes while the
row is being overwritten sees two different numbers and leaves it out. A reader that was away for longer than the ring
lasts has lost rows, and learns how many.
"""

from __future__ import annotations

import mmap
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray

MAX_COLUMNS = 48
# At 1 kHz sixteen seconds, at the paper's 20 Hz a quarter of an hour.
SLOTS = 16_384
# Of a slot: the row's number, the number of its layout, how many values, the values, the row's number again.
SLOT_NUMBERS = MAX_COLUMNS + 4
HEAD_BYTES = 64
SLOT_BYTES = 8 * SLOT_NUMBERS
# On Linux all of it is fetched at once: no row waits for its page, and no process seems to grow while the ring fills.
IN_MEMORY = {"flags": mmap.MAP_SHARED | mmap.MAP_POPULATE} if hasattr(mmap, "MAP_POPULATE") else {}


class RingRows(NamedTuple):
    """Rows of one layout, (n_rows, n_columns), in the order in which they were written."""

    layout: int
    values: FloatArray


def create_ring(path: Path) -> None:
    """Make the file of an empty ring, all zeros; on Linux it lies in memory if ``path`` does."""
    with path.open("wb") as file:
        file.truncate(HEAD_BYTES + SLOTS * SLOT_BYTES)


class RowRing:
    """An end of a ring, whose file :func:`create_ring` makes."""

    def __init__(self, path: Path) -> None:
        """Map the file into memory."""
        with path.open("r+b") as file:
            self._memory = mmap.mmap(file.fileno(), 0, **IN_MEMORY)
        self._numbers: FloatArray = np.frombuffer(self._memory, np.float64, SLOTS * SLOT_NUMBERS, HEAD_BYTES)
        self._slots = self._numbers.reshape(SLOTS, SLOT_NUMBERS)
        self._pack_count = struct.Struct("<Q").pack_into
        self._unpack_count = struct.Struct("<Q").unpack_from
        self._pack_one = struct.Struct("<d").pack_into
        self._packers: dict[int, struct.Struct] = {}
        self._written = self.written

    @property
    def written(self) -> int:
        """How many rows were written since the ring was made."""
        return int(self._unpack_count(self._memory, 0)[0])

    def write(self, layout: int, values: Sequence[float]) -> None:
        """Add a row of numbers; never waits. Raises ValueError for more than ``MAX_COLUMNS`` of them."""
        count = len(values)
        packer = self._packers.get(count)
        if packer is None:
            if count > MAX_COLUMNS:
                raise ValueError(f"a row of {count} values; a ring holds {MAX_COLUMNS}: leave columns out")
            packer = self._packers[count] = struct.Struct(f"<{count + 2}d")
        self._written += 1
        number, start = float(self._written), HEAD_BYTES + (self._written - 1) % SLOTS * SLOT_BYTES
        # The number behind first: from here on the old row is recognised as incomplete.
        self._pack_one(self._memory, start + SLOT_BYTES - 8, number)
        packer.pack_into(self._memory, start + 8, layout, count, *values)
        self._pack_one(self._memory, start, number)
        self._pack_count(self._memory, 0, self._written)

    def read(self, cursor: int, most: int = SLOTS // 2) -> tuple[int, list[RingRows], int]:
        """Return the next cursor, the rows after a cursor, those of one layout together, and how many rows were lost.

        A cursor below 0 stands for none of the rows that are there; of more than ``most`` rows the newest are returned.
        """
        written = self.written
        if cursor < 0 or cursor > written:
            return written, [], 0
        wanted = written - cursor
        first = max(cursor, written - most)
        places = np.arange(first, written) % SLOTS
        copied = self._slots[places]
        numbers = np.arange(first + 1, written + 1, dtype=np.float64)
        whole = copied[(copied[:, 0] == numbers) & (copied[:, -1] == numbers)]
        return written, same_layouts(whole), wanted - len(whole)

    def close(self) -> None:
        """Give the memory back; the file stays."""
        del self._slots, self._numbers
        self._memory.close()


def same_layouts(slots: FloatArray) -> list[RingRows]:
    """Return the values of slots, those of one layout in a row together."""
    if not len(slots):
        return []
    changes = np.flatnonzero((np.diff(slots[:, 1]) != 0) | (np.diff(slots[:, 2]) != 0)) + 1
    return [
        RingRows(int(part[0, 1]), part[:, 3 : 3 + int(part[0, 2])].copy())
        for part in np.split(slots, changes)
        if len(part)
    ]
