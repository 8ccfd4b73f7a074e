"""Information of a scan match, from the directions of the walls in the scan."""

import numpy as np

from core.message import Array

MAX_NEIGHBOURS = 16  # points to either side among which they are, at most
MAX_BEND_M = 0.05  # of a point off the line between them, at most


def match_information(points: Array, *, point_sd: float, wall: float, believed: Array | None = None) -> Array:
    """Points (M, 2) [m] of a scan, robot frame, in the order of their beams → information (3, 3) on its pose.

    In the robot frame at the matched pose: x [m], y [m], heading [rad]. Every point measures its distance across
    its wall, with `point_sd` [m], the points' dependence on each other taken in; a wall's direction is that of
    its neighbours on either side, at most `wall` [m] apart; `believed` (M,) 0..1 is how much each point counts.

    A direction that is not quite right feigns information along the wall. That is taken off, so that along a
    corridor without corners nothing at all is left (degeneracy; Zhang, Kaess and Singh, ICRA 2016).
    """
    rows, along, doubts = _on_walls(points, wall)
    across = np.column_stack((-along[:, 1], along[:, 0]))
    weights = np.full(len(rows), point_sd**-2.0) if believed is None else believed[rows] / point_sd**2
    slopes, feigned = (_with_turning(vectors, points[rows]) for vectors in (across, along))
    found = (slopes.T * weights) @ slopes - (feigned.T * (weights * doubts)) @ feigned
    values, vectors = np.linalg.eigh(found)
    return (vectors * np.maximum(values, 0.0)) @ vectors.T


def match_spread(
    points: Array, *, point_sd: float, wall: float, unknown: Array, floor: Array, believed: Array | None = None
) -> Array:
    """Covariance (3, 3) of the same pose where its information is no less than that of `unknown` (3,) sd.

    `floor` (3,) is the least sd that is ever claimed.
    """
    found = match_information(points, point_sd=point_sd, wall=wall, believed=believed)
    return np.linalg.inv(found + np.diag(unknown**-2.0)) + np.diag(floor**2)


def _with_turning(vectors: Array, arms: Array) -> Array:
    """Unit vectors (K, 2) at points (K, 2) [m] → change of the points along them with x, y, heading (K, 3)."""
    return np.column_stack((vectors, arms[:, 0] * vectors[:, 1] - arms[:, 1] * vectors[:, 0]))


def _on_walls(points: Array, wall: float) -> tuple[Array, Array, Array]:
    """Points (M, 2) [m] → which lie on walls (K,), the walls' directions there (K, 2), of length 1, and the
    directions' variances (K,) [rad²].

    Next neighbours on a near wall are closer to each other than their noise: a direction between them would be
    anything, and a corridor would seem to have walls across it.
    """
    index = np.arange(len(points))
    most = np.minimum(index, index[::-1])
    steps = np.minimum(1, most)
    for step in range(2, MAX_NEIGHBOURS + 1):
        wider = np.minimum(step, most)
        longer = np.hypot(*(points[index + wider] - points[index - wider]).T) < wall
        steps = np.where(longer & (steps == step - 1), wider, steps)
    ends = points[index + steps] - points[index - steps]
    reach = np.hypot(ends[:, 0], ends[:, 1])
    aside = points - points[index - steps]
    off = np.abs(ends[:, 0] * aside[:, 1] - ends[:, 1] * aside[:, 0]) / np.maximum(reach, 1e-9)
    rows = np.flatnonzero((reach > 1e-6) & (reach < wall) & (off < MAX_BEND_M))
    along, doubts = _fitted(points, rows - steps[rows], rows + steps[rows] + 1)
    return rows, along, doubts


def _fitted(points: Array, first: Array, last: Array) -> tuple[Array, Array]:
    """Lines through points[first:last], K of them → their directions (K, 2) and variances of these (K,) [rad²]."""
    x, y = points.T
    sums = np.vstack((np.zeros(5), np.cumsum(np.column_stack((x, y, x * x, y * y, x * y)), axis=0)))
    count = (last - first).astype(float)
    mx, my, xx, yy, xy = ((sums[last] - sums[first]) / count[:, None]).T
    xx, yy, xy = xx - mx * mx, yy - my * my, xy - mx * my
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    half, apart = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    noise = np.maximum(half - apart, 0.0) * count / (count - 2)
    return np.column_stack((np.cos(angle), np.sin(angle))), noise / (count * np.maximum(half + apart, 1e-12))
