"""Answers of the detector network: the faces of people, their hips, and how far their bodies reach."""

import math
from functools import cache

import numpy as np

from core.message import Array, message
from core.perception.people.body import Box, overlap
from core.perception.people.pose.landmarks import sigmoid
from core.perception.people.pose.networks import DETECTOR_SIDE, PoseNetworks
from core.perception.people.pose.squares import SECOND_SIDE, ImagePyramid, Square, picture_from_crop

GRIDS = ((28, 2), (14, 2), (7, 6))  # cells a side, anchors a cell
SURE_SCORE = 0.5  # score from which someone is there
SAME_OVERLAP = 0.3  # overlap of the boxes of one face


@message
class FoundFace:
    """A person's face."""

    box: Box  # [pixel] of the picture
    score: float  # 0..1
    body: Square  # around the whole of them, for the landmark network


@cache
def anchors() -> Array:
    """(2254, 2): where each row of the answer counts from, in parts of the square's side."""
    rows: list[Array] = []
    for count, many in GRIDS:
        y, x = np.mgrid[0:count, 0:count]
        rows.append(np.repeat(np.column_stack((x.ravel() + 0.5, y.ravel() + 0.5)) / count, many, axis=0))
    return np.concatenate(rows)


def find_faces(networks: PoseNetworks, picture: ImagePyramid, square: Square) -> tuple[FoundFace, ...]:
    """Everybody in a square of the picture, surest first. Raises Unavailable without a detector."""
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
    return tuple(_found(row, score, matrix) for row, score in kept)


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


def _found(row: Array, score: float, matrix: Array) -> FoundFace:
    places = DETECTOR_SIDE * row.reshape(4, 2) @ matrix[:, :2].T + matrix[:, 2]
    hips, rim = places[2], places[3]
    turn = math.pi / 2 - math.atan2(-(rim[1] - hips[1]), rim[0] - hips[0])
    side = SECOND_SIDE * max(float(np.hypot(*(rim - hips))), 1.0)
    body = Square(x=float(hips[0]), y=float(hips[1]), side=side, turn=math.remainder(turn, math.tau))
    low, high = places[:2].min(axis=0), places[:2].max(axis=0)
    return FoundFace(box=(float(low[0]), float(low[1]), float(high[0]), float(high[1])), score=score, body=body)
