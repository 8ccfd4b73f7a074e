"""A chessboard that a person holds up in the room."""

import numpy as np

from core.geometry import Transform
from core.message import Array, message


@message
class HeldBoard:
    """A stiff panel with a chessboard printed on its front.

    Its frame has the first inner corner as origin, x along a row of corners, y down the rows, z away from the viewer.
    """

    columns: int  # inner corners in a row
    rows: int  # rows of inner corners
    square: float  # [m] side of one square
    panel: tuple[float, float]  # [m] width and height of the panel, around the middle of the corners
    pose: Transform  # world_from_board

    @property
    def middle(self) -> Array:
        """(3,) [m]: the middle of the corners, in the board's frame."""
        return np.array([(self.columns - 1) * self.square / 2, (self.rows - 1) * self.square / 2, 0.0])

    @property
    def place(self) -> Array:
        """(3,) [m]: the middle of the corners, in the world."""
        return self.pose.apply(self.middle[None])[0]

    def spots(self, count: int) -> Array:
        """`count` x `count` points (count², 3) [m] spread evenly over the panel from rim to rim, in the world."""
        share = np.linspace(-0.5, 0.5, count)
        grid = np.stack(np.meshgrid(share, share), axis=-1).reshape(-1, 2) * self.panel
        return self.pose.apply(self.middle + np.column_stack((grid, np.zeros(len(grid)))))

    @property
    def outline(self) -> Array:
        """The panel's corners (4, 3) [m] in the world, clockwise as seen from its front."""
        return self.spots(2)[[0, 1, 3, 2]]

    def cut(self, height: float) -> Array:
        """Cut the panel at `height` [m] → (0 or 2, 4): x0 y0 x1 y1 [m], one face for each side."""
        ends = _crossings(self.outline, height)
        if len(ends) != 2 or np.hypot(*(ends[1] - ends[0])) < MIN_EDGE_M:
            return np.empty((0, 4))
        return np.array([[*ends[0], *ends[1]], [*ends[1], *ends[0]]])

    def footprint(self, height: float) -> Array:
        """Return the rim (K, 4) x0 y0 x1 y1 [m] of the part below `height` [m], seen from above."""
        rim = np.array(_below(self.outline, height)).reshape(-1, 3)[:, :2]
        edges = np.hstack((rim, np.roll(rim, -1, axis=0)))
        return edges[np.hypot(*(edges[:, 2:] - edges[:, :2]).T) > MIN_EDGE_M]


MIN_EDGE_M = 1e-6  # what is shorter is a point


def _crossings(rim: Array, height: float) -> Array:
    """Find the points (M, 2) [m] where a closed line (K, 3) crosses a height."""
    found = [
        start[:2] + (end - start)[:2] * (height - start[2]) / (end[2] - start[2])
        for start, end in zip(rim, np.roll(rim, -1, axis=0), strict=True)
        if (start[2] < height) != (end[2] < height)
    ]
    return np.array(found).reshape(-1, 2)


def _below(rim: Array, height: float) -> list[Array]:
    """The part of a convex polygon (K, 3) under a height."""
    kept: list[Array] = []
    for start, end in zip(rim, np.roll(rim, -1, axis=0), strict=True):
        if start[2] <= height:
            kept.append(start)
        if (start[2] <= height) != (end[2] <= height):
            kept.append(start + (end - start) * (height - start[2]) / (end[2] - start[2]))
    return kept
