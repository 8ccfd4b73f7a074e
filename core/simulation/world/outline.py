"""From rectangles of free and solid floor to the walls between them."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from core.message import Array


@dataclass(frozen=True)
class Rect:
    """A rectangle along the axes."""

    x0: float  # [m]
    y0: float  # [m]
    x1: float  # [m]
    y1: float  # [m]

    def contains(self, x: float, y: float) -> bool:
        """Return whether (x, y) lies inside or on the border."""
        return self.x0 <= x <= self.x1 and self.y0 <= y <= self.y1


def outline(free: Sequence[Rect], solid: Sequence[Rect] = ()) -> Array:
    """Free floor (the union of `free` without `solid`) → its walls (W, 4): x0 y0 x1 y1 [m], free floor on the left.

    Collinear neighbours come as one wall, so every wall ends at a corner.
    """
    rects = [*free, *solid]
    xs = np.unique([edge for r in rects for edge in (r.x0, r.x1)])
    ys = np.unique([edge for r in rects for edge in (r.y0, r.y1)])
    cells = np.zeros((len(xs) + 1, len(ys) + 1), dtype=np.int8)  # with a solid margin all around
    for r in free:
        cells[_span(xs, r.x0, r.x1), _span(ys, r.y0, r.y1)] = 1
    for r in solid:
        cells[_span(xs, r.x0, r.x1), _span(ys, r.y0, r.y1)] = 0
    walls: list[tuple[float, float, float, float]] = []
    for step, x in zip(np.diff(cells, axis=0), xs, strict=True):  # walls across x, looking along y
        for low, high, side in _runs(step[1:-1]):
            a, b = ys[low], ys[high]
            walls.append((x, b, x, a) if side > 0 else (x, a, x, b))
    for step, y in zip(np.diff(cells, axis=1).T, ys, strict=True):
        for low, high, side in _runs(step[1:-1]):
            a, b = xs[low], xs[high]
            walls.append((a, y, b, y) if side > 0 else (b, y, a, y))
    return np.array(walls)


def _span(edges: Array, low: float, high: float) -> slice:
    return slice(int(np.searchsorted(edges, low)) + 1, int(np.searchsorted(edges, high)) + 1)


def _runs(sides: Array) -> list[tuple[int, int, int]]:
    """Find runs (first, past the last, side) where a line of cells goes from solid to free (+1) or back (-1)."""
    bounds = np.flatnonzero(np.diff(sides, prepend=0, append=0))
    return [(int(low), int(high), int(sides[low])) for low, high in pairwise(bounds) if sides[low] != 0]
