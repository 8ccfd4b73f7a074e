"""The colours of head, torso and legs where the landmarks say that body is."""

from __future__ import annotations

import cv2
import numpy as np

from core.message import Array
from core.perception.people.body import Box, WeighedBody
from core.perception.people.colours import GREYS, HUES, shares_of
from core.perception.people.pose.landmarks import HIPS, SHOULDERS, BodyLandmarks

THIGHS = ((23, 25), (24, 26), (25, 27), (26, 28))  # hip to knee, knee to ankle
THICKNESS = 0.2  # torso's lengths: width of a leg's core
CORE = 0.7  # of the width between shoulders and hips that is surely torso
SIDE = 160  # [pixel] of the cut-out in which colours are counted, at most


def colours_of(found: BodyLandmarks, weighed: WeighedBody, pixels: Array) -> Array:
    """Landmarks in a picture (H, W, 3) → colours (3, HUES + GREYS); NaN for a part that is not in it."""
    left, top, right, bottom = _inside(weighed.body.box, pixels)
    region = pixels[top:bottom, left:right]
    if min(region.shape[:2]) < 2:
        return np.full((3, HUES + GREYS), np.nan)
    factor = min(1.0, SIDE / max(region.shape[:2]))
    small = cv2.resize(region, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    points = (found.points - (left, top)) * factor
    length = weighed.body.torso_length * factor
    masks = [np.zeros(small.shape[:2], np.uint8) for _ in range(3)]
    head = (np.array(weighed.body.parts[0]).reshape(2, 2) - (left, top)) * factor
    middle, half = head.mean(axis=0), (head[1] - head[0]) / 2
    cv2.ellipse(masks[0], (_whole(middle), _whole(1.4 * half), 0.0), 255, -1)
    trunk = points[[SHOULDERS[0], SHOULDERS[1], HIPS[1], HIPS[0]]]
    core = trunk.mean(axis=0) + (trunk - trunk.mean(axis=0)) * (CORE, 0.85)
    cv2.fillConvexPoly(masks[1], np.round(core).astype(np.int32), 255)
    for one, other in THIGHS:
        cv2.line(masks[2], _whole(points[one]), _whole(points[other]), 255, max(1, round(THICKNESS * length)))
    rows = [
        shares_of(small, mask > 0) if known is not None and mask.any() else np.full(HUES + GREYS, np.nan)
        for mask, known in zip(masks, weighed.likelihoods, strict=True)
    ]
    return np.array(rows)


def _inside(box: Box, pixels: Array) -> tuple[int, int, int, int]:
    height, width = pixels.shape[:2]
    left, top, right, bottom = (round(edge) for edge in box)
    return max(left, 0), max(top, 0), min(right, width), min(bottom, height)


def _whole(place: Array) -> tuple[int, int]:
    x, y = np.clip(np.round(place), -30000, 30000).astype(int).tolist()
    return x, y
