"""The looks of a body where landmarks or boxes say what is head, torso and legs."""

import cv2
import numpy as np

from core.message import Array
from core.perception.people.appearance import NO_LIMBS, TONE_COUNT, Appearance, tones_of
from core.perception.people.body import Box, WeighedBody
from core.perception.people.pose.landmarks import HIPS, MIN_VISIBILITY, SHOULDERS, BodyLandmarks

THIGHS = ((23, 25), (24, 26), (25, 27), (26, 28))  # hip to knee, knee to ankle
ARMS = ((11, 13), (12, 14), (13, 15), (14, 16))  # shoulder to elbow, elbow to wrist
LEG_CORE_WIDTH = 0.2  # torso's lengths: width of a leg's core
CORE_SHARE = 0.7  # of the width between shoulders and hips that is surely torso
BOX_CORE = 0.5  # of the sides of a part's box, where there are no landmarks
MAX_SIDE_PX = 160  # of the cut-out in which colours are counted, at most


def looks_of(found: BodyLandmarks, weighed: WeighedBody, pixels: Array) -> Appearance:
    """Landmarks in a picture (H, W, 3) → how that person looks; NaN for what is not in it."""
    small, corner, factor = _cut_out(weighed.body.box, pixels)
    points = (found.points - corner) * factor
    length = weighed.body.torso_length * factor
    masks = [np.zeros(small.shape[:2], np.uint8) for _ in range(3)]
    head = (np.array(weighed.body.parts[0]).reshape(2, 2) - corner) * factor
    middle, half = head.mean(axis=0), (head[1] - head[0]) / 2
    cv2.ellipse(masks[0], (_whole(middle), _whole(1.4 * half), 0.0), 255, -1)
    trunk = points[[SHOULDERS[0], SHOULDERS[1], HIPS[1], HIPS[0]]]
    core = trunk.mean(axis=0) + (trunk - trunk.mean(axis=0)) * (CORE_SHARE, 0.85)
    cv2.fillConvexPoly(masks[1], np.clip(np.round(core), -30000, 30000).astype(np.int32), 255)
    for one, other in THIGHS:
        cv2.line(masks[2], _whole(points[one]), _whole(points[other]), 255, max(1, round(LEG_CORE_WIDTH * length)))
    return Appearance(colours=_tones(small, masks, weighed), proportions=proportions_of(found))


def looks_in_boxes(weighed: WeighedBody, pixels: Array) -> Appearance:
    """The same where only boxes of the parts are known."""
    small, corner, factor = _cut_out(weighed.body.box, pixels)
    masks = [np.zeros(small.shape[:2], np.uint8) for _ in range(3)]
    for mask, box in zip(masks, weighed.body.parts, strict=True):
        ends = (np.array(box).reshape(2, 2) - corner) * factor
        core = ends.mean(axis=0) + BOX_CORE * (ends - ends.mean(axis=0))
        cv2.rectangle(mask, _whole(core[0]), _whole(core[1]), 255, -1)
    return Appearance(colours=_tones(small, masks, weighed), proportions=NO_LIMBS)


def proportions_of(found: BodyLandmarks) -> Array:
    """Log lengths of legs, arms and neck in lengths of the torso (LIMBS,); NaN where they are hidden."""
    length = max(float(np.hypot(*(found.shoulders - found.hips))), 1e-3)
    limbs = [_length(found, THIGHS) / 2, _length(found, ARMS) / 2, float(np.hypot(*(found.face - found.shoulders)))]
    return np.log(np.maximum(np.array(limbs) / length, 1e-2))


def _length(found: BodyLandmarks, bones: tuple[tuple[int, int], ...]) -> float:
    ends = sorted({end for bone in bones for end in bone})
    if found.visibility[ends].mean() < MIN_VISIBILITY:
        return float("nan")
    return float(sum(np.hypot(*(found.points[one] - found.points[other])) for one, other in bones))


def _tones(small: Array, masks: list[Array], weighed: WeighedBody) -> Array:
    rows = [
        tones_of(small, mask > 0) if known is not None else np.full(TONE_COUNT, np.nan)
        for mask, known in zip(masks, weighed.likelihoods, strict=True)
    ]
    return np.array(rows)


def _cut_out(box: Box, pixels: Array) -> tuple[Array, Array, float]:
    """Cut out a box of the picture → the part, not too large, its corner (2,) [pixel] and its factor of shrinking."""
    height, width = pixels.shape[:2]
    left, top, right, bottom = (round(edge) for edge in box)
    left, top = min(max(left, 0), width - 1), min(max(top, 0), height - 1)
    region = pixels[top : max(min(bottom, height), top + 1), left : max(min(right, width), left + 1)]
    factor = min(1.0, MAX_SIDE_PX / max(region.shape[:2]))
    size = max(1, round(region.shape[1] * factor)), max(1, round(region.shape[0] * factor))
    return cv2.resize(region, size, interpolation=cv2.INTER_AREA), np.array([left, top]), factor


def _whole(place: Array) -> tuple[int, int]:
    x, y = np.clip(np.round(place), -30000, 30000).astype(int).tolist()
    return x, y
