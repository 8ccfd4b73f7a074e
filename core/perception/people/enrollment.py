"""Enrollment: how one person looks, from pictures with different gestures, by background subtraction."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import cv2
import numpy as np

from core.errors import BadInput
from core.message import Array, message
from core.perception.people.appearance import NO_LIMBS, Appearance, PersonProfile, mean_of, region_of, tones_of
from core.perception.people.body import MAX_PERSON_M, MIN_PERSON_M
from core.perception.people.brightness import levelled
from core.perception.people.camera_geometry import LEGS_BESIDE_M, from_eye
from core.perception.people.legs import LegCluster
from core.perception.people.parts import (
    CEILING_M,
    CELL_PX,
    CELLS_PER_METRE,
    MODEL_HEIGHT_M,
    PARTS,
    PIXELS_PER_METRE,
    BodySegment,
)
from core.perception.people.pose.view import Viewpoint
from core.sensors import Camera

MIN_CHANGE_GREY = 24.0  # grey levels that a pixel must differ from the background
MIN_AREA_SHARE, MIN_HEIGHT_SHARE = 0.008, 0.3  # share of the picture, and of its height, that a person must fill
MIRRORED_SHARE = 0.5  # a floor mirrors legs: what changed by less than this share of what legs would change is none
LEG_ROWS_SHARES = (0.5, 0.65)  # rows of a contour, with its mirror image below or without, that are surely legs
MIN_SLIMNESS, MAX_SLIMNESS = 1.6, 7.0  # height of the contour against the torso's width
BRIGHT_QUANTILE, DARK_GREY = 0.95, 45  # share of the pixels that may not all be darker than this grey level
MAX_ELSEWHERE_SHARE = 0.06  # share of the picture that may change next to the person
SAME_OVERLAP = 0.85  # overlap of two figures from which they are one gesture
MIN_PICTURES = 3  # pictures
TOO_SMALL = "What differs from the background is too small for a person; come nearer, in clothes unlike the wall."

Box = tuple[float, float, float, float]  # left, top, right, bottom [pixel]


@message
class HeightGauge:
    """Measures how tall someone is, by the laser's distance of the legs and the height of the camera."""

    camera: Camera
    standers: tuple[LegCluster, ...]

    def height(self, column: float, crown: float) -> float:
        """The pixel of the head's top → [m]; NaN where the laser sees no legs below it."""
        view = Viewpoint(self.camera)
        bearing = view.bearing(column, crown)
        best, least = math.nan, LEGS_BESIDE_M
        for one in self.standers:
            far, angle = from_eye(one, self.camera)
            aside = far * abs(math.sin(angle - bearing))
            if aside < least:
                least, best = aside, float(self.camera.mounting.translation[2]) + far * view.elevation(column, crown)
        return best if MIN_PERSON_M < best < MAX_PERSON_M else math.nan


@message
class PersonImage:
    """Features of a person from one picture."""

    looks: Appearance
    figure: Array  # (H, W) bool: the contour at the model's size
    outline: Array  # (K, 2) [pixel] of the picture
    boxes: tuple[Box, ...]  # head, torso, feet in the picture


def check_light(picture: Array) -> None:
    """Picture (H, W, 3) uint8. Raises BadInput where it is too dark to learn from."""
    if float(np.quantile(picture.max(axis=2), BRIGHT_QUANTILE)) < DARK_GREY:
        raise BadInput("It is too dark to learn from; switch a light on.")


def contour_of(picture: Array, background: Array) -> Array:
    """Picture and background (H, W, 3) uint8 → the body's mask (H, W) bool. Raises BadInput with a sentence."""
    if picture.shape != background.shape:
        raise BadInput("The picture and the background are of different size; take both with the same camera.")
    smooth = [cv2.GaussianBlur(each, (5, 5), 0).astype(np.int16) for each in (picture, background)]
    mask = (np.abs(smooth[0] - smooth[1]).max(axis=2) > MIN_CHANGE_GREY).astype(np.uint8)
    size = max(3, round(0.015 * picture.shape[0])) | 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    mask = cv2.morphologyEx(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, kernel), cv2.MORPH_OPEN, kernel)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    if count < 2:
        raise BadInput("Nobody is in the picture: nothing differs from the background.")
    largest = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    own, all_of_it = int(stats[largest, cv2.CC_STAT_AREA]), int(stats[1:, cv2.CC_STAT_AREA].sum())
    if all_of_it > 0.6 * mask.size:
        raise BadInput("Most of the picture differs from the background: did the camera move, or the light change?")
    if all_of_it - own > MAX_ELSEWHERE_SHARE * mask.size:
        raise BadInput(
            "More than you has changed since the background: did the camera move? Is a second person there?"
        )
    if own < MIN_AREA_SHARE * mask.size:
        raise BadInput(TOO_SMALL)
    return _without_mirror(np.asarray(labels == largest), *smooth)


def person_image(
    picture: Array,
    background: Array,
    landmarks: Callable[[Array, Box], Appearance | None] = lambda *_: None,
    gauge: HeightGauge | None = None,
) -> PersonImage:
    """A picture of the whole person and one of the background alone, both (H, W, 3) uint8 → what it teaches.

    `landmarks`: the looks of who is in a box of the picture, where networks are here to see them; else the contour
    tells the colours. `gauge`: measures the height. Raises BadInput with what to do better.
    """
    check_light(picture)
    mask = contour_of(picture, background)
    columns, top, bottom = _stand(mask)
    crown = _crown(mask, columns, top)
    factor = MODEL_HEIGHT_M * PIXELS_PER_METRE / (bottom - crown)
    middle = float(np.median(columns)) + 0.5
    width, height = 1.0 * PIXELS_PER_METRE, CEILING_M * PIXELS_PER_METRE
    matrix = np.array([[factor, 0, width / 2 - factor * middle], [0, factor, height - factor * bottom]])
    size = (round(width), round(height))
    upright = cv2.warpAffine(levelled(picture), matrix, size, flags=cv2.INTER_AREA)
    inside = cv2.warpAffine(mask.astype(np.uint8), matrix, size, flags=cv2.INTER_NEAREST) > 0
    reach = MODEL_HEIGHT_M / 2 * PIXELS_PER_METRE / factor
    looks = landmarks(picture, (middle - reach, float(crown), middle + reach, float(bottom)))
    if looks is None:
        colours = np.array([tones_of(*region_of(part, upright, inside, 0)) for part in PARTS])
        looks = Appearance(colours=colours, proportions=NO_LIMBS)
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    outline = cv2.approxPolyDP(max(outlines, key=len), 1.0, closed=True)[:, 0]
    return PersonImage(
        looks=replace(looks, height=math.nan if gauge is None else gauge.height(middle, crown)),
        figure=inside,
        outline=outline.astype(float),
        boxes=tuple(_box(part, factor, middle, bottom) for part in PARTS),
    )


def too_like(one: PersonImage, other: PersonImage) -> bool:
    """Return whether two pictures show the same gesture, so that the second adds nothing."""
    either = np.count_nonzero(one.figure | other.figure)
    return bool(np.count_nonzero(one.figure & other.figure) > SAME_OVERLAP * either)


def learn(name: str, images: Sequence[PersonImage]) -> PersonProfile:
    """Learn a profile from pictures with different gestures. Hands and legs move and are left out
    (section 4.2). Raises BadInput.
    """
    if len(images) < MIN_PICTURES:
        raise BadInput(f"Show at least {MIN_PICTURES} pictures with different gestures; these are {len(images)}.")
    return PersonProfile(name=name, looks=mean_of([each.looks for each in images]), pictures=len(images))


def _without_mirror(mask: Array, picture: Array, background: Array) -> Array:
    """The mask (H, W) bool without the dim image of the legs in the floor; both pictures (H, W, 3) int16."""
    rows = np.flatnonzero(mask.any(axis=1))
    upper, lower = (int(rows[0]) + round(share * len(rows)) for share in LEG_ROWS_SHARES)
    if not mask[upper:lower].any():
        return mask
    legs = np.median(picture[upper:lower][mask[upper:lower]], axis=0)
    wanted = np.abs(legs - background[lower:]).max(axis=2)
    kept = mask.copy()
    kept[lower:] &= np.abs(picture[lower:] - background[lower:]).max(axis=2) > MIRRORED_SHARE * wanted
    _, labels, stats, _ = cv2.connectedComponentsWithStats(kept.astype(np.uint8))
    return np.asarray(labels == 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())) if kept.any() else mask


def _stand(mask: Array) -> tuple[Array, int, int]:
    """Bounds of the person: columns at the shoulders, the top row and the row below the lowest. Raises BadInput."""
    rows, across = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    top, bottom = int(rows[0]), int(rows[-1]) + 1
    if top <= 1 or bottom >= mask.shape[0] - 1:
        raise BadInput("Head or feet are cut off; step back until all of you is in the picture.")
    if across[0] <= 1 or across[-1] >= mask.shape[1] - 2:
        raise BadInput("A side of you is cut off; stand in the middle of the picture.")
    tall = bottom - top
    if tall < MIN_HEIGHT_SHARE * mask.shape[0]:
        raise BadInput(TOO_SMALL)
    chest = mask[top + round(0.25 * tall) : top + round(0.45 * tall)]
    columns = np.flatnonzero(chest.mean(axis=0) > 0.5)
    if not len(columns) or not MIN_SLIMNESS < tall / len(columns) < 2 * MAX_SLIMNESS:
        raise BadInput("The contour is not that of a standing person; stand upright, whole in the picture.")
    return columns, top, bottom


def _crown(mask: Array, columns: Array, top: int) -> int:
    """The row of the head's top: raised arms next to it do not count."""
    middle = round(float(np.median(columns)))
    reach = max(2, len(columns) // 5)
    rows = np.flatnonzero(mask[:, max(0, middle - reach) : middle + reach + 1].mean(axis=1) > 0.5)
    return int(rows[0]) if len(rows) else top


def _box(part: BodySegment, factor: float, middle: float, bottom: int) -> Box:
    """Bounds of a part in the picture; the floor ends it."""
    half = part.columns / 2 / CELLS_PER_METRE * PIXELS_PER_METRE / factor
    ends = (part.top * CELL_PX, min((part.top + part.rows) * CELL_PX, CEILING_M * PIXELS_PER_METRE))
    upper, lower = (bottom - (CEILING_M * PIXELS_PER_METRE - end) / factor for end in ends)
    return middle - half, upper, middle + half, lower
