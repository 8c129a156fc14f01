"""The serial line between a user's port and an emulated board, which passes bytes on or injects faults."""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from typing import Literal

__all__ = ["Direction", "LineFaults"]

Direction = Literal["to_board", "to_host"]


@dataclass
class LineFaults:
    """Faults of the line; all random draws come from one seed.

    Attributes:
        seed: of all draws.
        corrupt_fraction: fraction of bytes that arrive as another byte.
        lose_fraction: fraction of frames that never arrive.
        repeat_fraction: fraction of frames that arrive twice.
        directions: which directions have faults.
        cut_after_bytes: the line breaks after this many more bytes to the board; None: it does not.
    """

    seed: int = 1
    corrupt_fraction: float = 0.0
    lose_fraction: float = 0.0
    repeat_fraction: float = 0.0
    directions: tuple[Direction, ...] = ("to_board", "to_host")
    cut_after_bytes: int | None = None
    corrupted_bytes: int = 0
    lost_frames: int = 0
    repeated_frames: int = 0
    _random: random.Random = field(init=False)
    _parts: dict[Direction, bytearray] = field(init=False)

    def __post_init__(self) -> None:
        """Start the draws."""
        self._random = random.Random(self.seed)
        self._parts = {"to_board": bytearray(), "to_host": bytearray()}

    def passed(self, data: bytes, direction: Direction) -> tuple[bytes, bool]:
        """Return the bytes that arrive, and whether the line has broken after them."""
        if direction in self.directions:
            if self.lose_fraction or self.repeat_fraction:
                data = self._frames(data, direction)
            if self.corrupt_fraction:
                data = self._corrupted(data)
        if direction == "to_board" and self.cut_after_bytes is not None:
            data, left = data[: self.cut_after_bytes], self.cut_after_bytes - len(data)
            self.cut_after_bytes = max(left, 0)
            return data, left <= 0
        return data, False

    def _corrupted(self, data: bytes) -> bytes:
        spoiled = bytearray(data)
        for at in range(len(spoiled)):
            if self._random.random() < self.corrupt_fraction:
                spoiled[at] ^= self._random.randint(1, 255)
                self.corrupted_bytes += 1
        return bytes(spoiled)

    def _frames(self, data: bytes, direction: Direction) -> bytes:
        """Lose and repeat whole frames; an incomplete one waits until its zero has come."""
        part = self._parts[direction]
        part += data
        *whole, rest = bytes(part).split(b"\0")
        part[:] = rest
        arrived = bytearray()
        for frame in whole:
            drawn = self._random.random()
            if drawn < self.lose_fraction:
                self.lost_frames += 1
                continue
            arrived += frame + b"\0"
            if drawn > 1.0 - self.repeat_fraction:
                self.repeated_frames += 1
                arrived += frame + b"\0"
        return bytes(arrived)
