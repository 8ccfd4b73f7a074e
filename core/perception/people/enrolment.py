"""Learning what one person looks like: from pictures with different gestures, by the difference to the background."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from core.errors import BadInput
from core.message import Array
from core.perception.people.colours import Enrolled, region_of, shares_of
from core.perception.people.parts import CEILING, PARTS, SCALE, TALL

CHANGED = 24.0  # grey levels that a pixel must differ from the background
SMALLEST = 0.02  # share of the picture that somebody must fill
SLIMMEST, STOUTEST = 1.6, 7.0  # height of the contour against the torso's width
FEWEST = 3  # pictures


def contour_of(picture: Array, background: Array) -> Array:
    """Picture and background (H, W, 3) uint8 → the body's mask (H, W) bool. Raises BadInput with a sentence."""
    if picture.shape != background.shape:
        raise BadInput("The picture and the background are of different size; take both with the same camera.")
    smooth = [cv2.GaussianBlur(each, (5, 5), 0).astype(np.int16) for each in (picture, background)]
    change = np.abs(smooth[0] - smooth[1]).max(axis=2)
    mask = (change > CHANGED).astype(np.uint8)
    size = max(3, round(0.015 * picture.shape[0])) | 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    mask = cv2.morphologyEx(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, kernel), cv2.MORPH_OPEN, kernel)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    if count < 2:
        raise BadInput("Nobody is in the picture: nothing differs from the background.")
    largest = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    if stats[largest, cv2.CC_STAT_AREA] < SMALLEST * mask.size:
        raise BadInput("What differs from the background is too small for a person; come nearer.")
    if stats[1:, cv2.CC_STAT_AREA].sum() > 0.6 * mask.size:
        raise BadInput("Most of the picture differs from the background: did the camera move, or the light change?")
    return np.asarray(labels == largest)


def enrol(name: str, pictures: Sequence[Array], background: Array) -> Enrolled:
    """Pictures of the whole person with different gestures, and one of the background alone → what they look like.

    Hands and legs move and are left out (section 4.2). Raises BadInput.
    """
    if len(pictures) < FEWEST:
        raise BadInput(f"Show at least {FEWEST} pictures with different gestures; these are {len(pictures)}.")
    rows: list[Array] = []
    shapes: list[float] = []
    for picture in pictures:
        mask = contour_of(picture, background)
        upright, inside, shape = _upright(picture, mask)
        rows.append(np.array([shares_of(*region_of(part, upright, inside, 0)) for part in PARTS]))
        shapes.append(shape)
    mean = np.mean(rows, axis=0)
    return Enrolled(name=name, colours=mean, pictures=len(pictures), shape=float(np.median(shapes)))


def _upright(picture: Array, mask: Array) -> tuple[Array, Array, float]:
    """The contour brought to the model's size, its mask, and its height over its width at the shoulders."""
    rows = np.flatnonzero(mask.any(axis=1))
    top, bottom = int(rows[0]), int(rows[-1]) + 1
    tall = bottom - top
    chest = mask[top + round(0.25 * tall) : top + round(0.45 * tall)]
    columns = np.flatnonzero(chest.mean(axis=0) > 0.5)
    if not len(columns) or not SLIMMEST < tall / len(columns) < 2 * STOUTEST:
        raise BadInput("The contour is not that of a standing person; stand upright, whole in the picture.")
    if top <= 1 or bottom >= mask.shape[0] - 1:
        raise BadInput("Head or feet are cut off; step back until all of you is in the picture.")
    crown = _crown(mask, columns, top)
    factor = TALL * SCALE / (bottom - crown)
    width, height = 1.0 * SCALE, CEILING * SCALE
    middle = float(np.median(columns)) + 0.5
    matrix = np.array([[factor, 0, width / 2 - factor * middle], [0, factor, height - factor * bottom]])
    size = (round(width), round(height))
    upright = cv2.warpAffine(picture, matrix, size, flags=cv2.INTER_AREA)
    inside = cv2.warpAffine(mask.astype(np.uint8), matrix, size, flags=cv2.INTER_NEAREST) > 0
    return upright, inside, tall / len(columns)


def _crown(mask: Array, columns: Array, top: int) -> int:
    """The row of the head's top: raised arms beside it do not count."""
    middle = round(float(np.median(columns)))
    reach = max(2, len(columns) // 5)
    rows = np.flatnonzero(mask[:, max(0, middle - reach) : middle + reach + 1].mean(axis=1) > 0.5)
    return int(rows[0]) if len(rows) else top
