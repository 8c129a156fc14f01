"""Find ways for tracks on two layers, the cheapest on a grid, no nearer to another net than is allowed."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable
from typing import NamedTuple

__all__ = ["Grid", "Rectangle"]

STEP_MM = 0.3175  # an eighth of the pitch of usual parts, so that their pads lie on the grid
VIA_COST, BACK_COST, TURN_COST = 25.0, 1.8, 0.4
Cell = tuple[int, int, int]


class Rectangle(NamedTuple):
    """Copper of a net, in mm; on which layers (0 the front, 1 the back)."""

    net: str
    left: float
    top: float
    right: float
    bottom: float
    layers: tuple[int, ...]

    def distance_mm(self, x: float, y: float) -> float:
        """Return how far a place is from it."""
        return math.hypot(max(self.left - x, 0.0, x - self.right), max(self.top - y, 0.0, y - self.bottom))


class Grid:
    """The board as cells, with the copper that is on it."""

    def __init__(self, width_mm: float, height_mm: float, clearance_mm: float, edge_mm: float) -> None:
        """Begin without copper."""
        self._cells = (round(width_mm / STEP_MM), round(height_mm / STEP_MM))
        self._clearance_mm = clearance_mm
        self._margin = math.ceil(edge_mm / STEP_MM)
        self.copper: list[Rectangle] = []

    def place(self, cell: Cell) -> tuple[float, float]:
        """Return a cell's place in mm."""
        return cell[0] * STEP_MM, cell[1] * STEP_MM

    def _blocked(self, net: str, radius_mm: float) -> set[Cell]:
        """Return the cells where copper of this radius would be too near to another net's."""
        near_mm = radius_mm + self._clearance_mm
        blocked: set[Cell] = set()
        for item in self.copper:
            if item.net == net:
                continue
            columns, rows = _steps_in(item.left, item.right, near_mm), _steps_in(item.top, item.bottom, near_mm)
            found = [(i, j) for i in columns for j in rows if item.distance_mm(i * STEP_MM, j * STEP_MM) < near_mm]
            blocked |= {(i, j, layer) for i, j in found for layer in item.layers}
        return blocked

    def route(self, net: str, start: set[Cell], end: set[Cell], width_mm: float, via_mm: float) -> list[Cell]:
        """Return the cheapest way from one set of cells to another. Raises ValueError if there is none."""
        blocked = self._blocked(net, 0.5 * width_mm) - start - end
        no_via = self._blocked(net, 0.5 * via_mm)
        goal = next(iter(end))
        queue = [(0.0, 0.0, cell, None) for cell in sorted(start)]
        came: dict[Cell, Cell | None] = {}
        while queue:
            _, cost, cell, before = heapq.heappop(queue)
            if cell in came:
                continue
            came[cell] = before
            if cell in end:
                return _way(came, cell)
            for there, more in self._steps(cell, before, no_via):
                if there not in came and there not in blocked:
                    guess = math.hypot(there[0] - goal[0], there[1] - goal[1])
                    heapq.heappush(queue, (cost + more + guess, cost + more, there, cell))
        raise ValueError(f"there is no way left for the net {net}")

    def _steps(self, cell: Cell, before: Cell | None, no_via: set[Cell]) -> Iterable[tuple[Cell, float]]:
        """Yield the neighbours of a cell with what it costs to go there."""
        i, j, layer = cell
        for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)):
            if self._inside(i + di, j + dj):
                turns = before and before[2] == layer and (i - before[0], j - before[1]) != (di, dj)
                ahead = math.hypot(di, dj) * (BACK_COST if layer else 1.0)
                yield (i + di, j + dj, layer), ahead + (TURN_COST if turns else 0.0)
        if (i, j, 0) not in no_via and (i, j, 1) not in no_via:
            yield (i, j, 1 - layer), VIA_COST

    def _inside(self, i: int, j: int) -> bool:
        """Whether a cell is far enough from the board's edge."""
        return self._margin <= i <= self._cells[0] - self._margin and self._margin <= j <= self._cells[1] - self._margin


def _steps_in(low_mm: float, high_mm: float, more_mm: float) -> range:
    """Return the steps of the grid in a stretch, and in a little more at its ends."""
    return range(math.floor((low_mm - more_mm) / STEP_MM), math.ceil((high_mm + more_mm) / STEP_MM) + 1)


def _way(came: dict[Cell, Cell | None], cell: Cell) -> list[Cell]:
    """Return the cells up to one, from the first."""
    way: list[Cell] = []
    at: Cell | None = cell
    while at is not None:
        way.append(at)
        at = came[at]
    return way[::-1]
