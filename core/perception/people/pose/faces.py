"""Answers of the detector network: the faces of people, their hips, and how far their bodies reach."""

import math
from functools import cache

import numpy as np

from core.message import Array
from core.perception.people.body import overlap
from core.perception.people.pose.landmarks import sigmoid
from core.perception.people.pose.networks import DETECTOR_SIDE, PoseNetworks
from core.perception.people.pose.squares import SECOND_SIDE, ImagePyramid, Square, picture_from_crop

GRIDS = ((28, 2), (14, 2), (7, 6))  # cells a side, anchors a cell
SURE_SCORE = 0.5  # score from which someone is there
SAME_OVERLAP = 0.3  # overlap of the boxes of one face


@cache
def anchors() -> Array:
    """(2254, 2): where each row of the answer counts from, in parts of the square's side."""
    rows: list[Array] = []
    for count, many in GRIDS:
        y, x = np.mgrid[0:count, 0:count]
        rows.append(np.repeat(np.column_stack((x.ravel() + 0.5, y.ravel() + 0.5)) / count, many, axis=0))
    return np.concatenate(rows)


def find_faces(networks: PoseNetworks, picture: ImagePyramid, square: Square) -> tuple[Square, ...]:
    """Everybody in a square of the picture, surest first: for each the square that the landmark network looks at.

    Raises Unavailable without a detector.
    """
    rows, raw = networks.faces(picture.cut(square, DETECTOR_SIDE))
    scores = sigmoid(raw)
    sure = scores >= SURE_SCORE
    points = rows[sure].reshape(-1, 6, 2) / DETECTOR_SIDE
    size = points[:, 1].copy()
    points = points + anchors()[sure][:, None, :]
    corners = np.concatenate((points[:, 0] - size / 2, points[:, 0] + size / 2), axis=1)
    marks = points[:, [2, 3]].reshape(-1, 4)  # the hips, and the rim of the circle around the body
    kept = without_doubles(np.concatenate((corners, marks), axis=1), scores[sure])
    matrix = picture_from_crop(square, DETECTOR_SIDE)
    return tuple(_around_body(row, matrix) for row, _ in kept)


def without_doubles(rows: Array, scores: Array) -> list[tuple[Array, float]]:
    """Rows (N, 8) that begin with a box, and scores (N,) → one row for those that overlap: their mean by score."""
    kept: list[tuple[Array, float]] = []
    rest = list(np.argsort(-scores))
    while rest:
        first = rest[0]
        same = [
            one
            for one in rest
            if one == first or overlap(tuple(rows[first, :4]), tuple(rows[one, :4])) > SAME_OVERLAP
        ]
        kept.append((np.average(rows[same], axis=0, weights=scores[same]), float(scores[first])))
        rest = [one for one in rest if one not in same]
    return kept


def _around_body(row: Array, matrix: Array) -> Square:
    """A row of the box, the hips and the rim (8,), and the map (2, 3) to the picture."""
    hips, rim = DETECTOR_SIDE * row[4:].reshape(2, 2) @ matrix[:, :2].T + matrix[:, 2]
    turn = math.pi / 2 - math.atan2(-(rim[1] - hips[1]), rim[0] - hips[0])
    side = SECOND_SIDE * max(float(np.hypot(*(rim - hips))), 1.0)
    return Square(x=float(hips[0]), y=float(hips[1]), side=side, turn=math.remainder(turn, math.tau))
