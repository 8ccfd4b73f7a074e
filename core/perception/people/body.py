"""A person whom a model found in a picture: head, torso and feet as boxes, and K of those that are in it (eq. 34)."""

import math
from dataclasses import replace

from core.message import message
from core.perception.people.appearance import Appearance
from core.perception.people.detector import Rectangle, SeenPart
from core.perception.people.looking import LookQuestion
from core.perception.people.parts import PARTS, PeopleSettings
from core.perception.people.pose.view import STATURE_M, Viewpoint

Box = tuple[float, float, float, float]  # left, top, right, bottom [pixel]; it may reach out of the picture
MIN_SHOWN_SHARE = 0.3  # share of a part in the picture below which it says nothing


@message
class SeenBody:
    """Someone, as a model found them; nothing is known yet of what the picture's rim cuts off."""

    parts: tuple[Box, Box, Box]  # head, torso, feet
    likelihoods: tuple[float, float, float]  # K1, K2, K3 of eq. 34
    box: Box  # around all of the body
    head_column: float  # [pixel] of the head's middle
    foretold_head: float  # [pixel] row in which the head's middle is by the torso alone
    hips_row: float  # [pixel]
    torso_length: float  # [pixel] from the hips to the shoulders; about 0.29 of the stature
    legs_length: float  # [pixel] from the hips down to the ankles, negative where these are higher
    confidence: float  # 0..1 that someone is there


@message
class WeighedBody:
    """The same in a picture of a certain size."""

    body: SeenBody
    likelihoods: tuple[float | None, float | None, float | None]  # None: not in the picture
    value: float  # K of eq. 34, of the parts that are in the picture
    shown: float  # 0..1: weight of the parts that are in the picture


def weigh(body: SeenBody, width: int, height: int) -> WeighedBody:
    """Weigh the parts as in eq. 34, each by its share in the picture [pixel]; K is 0 where none is in it."""
    shares = [share_inside(box, width, height) for box in body.parts]
    if not 0 <= body.foretold_head < height:
        shares[0] = 0.0  # a model puts a head into the picture all the same
    shares = [share if share >= MIN_SHOWN_SHARE else 0.0 for share in shares]
    weights = [part.weight * share for part, share in zip(PARTS, shares, strict=True)]
    shown = sum(weights)
    value = sum(weight * k for weight, k in zip(weights, body.likelihoods, strict=True)) / max(shown, 1e-9)
    known = [k if share else None for k, share in zip(body.likelihoods, shares, strict=True)]
    return WeighedBody(body=body, likelihoods=(known[0], known[1], known[2]), value=float(value), shown=shown)


def share_inside(box: Box, width: int, height: int) -> float:
    """The share of a box that is in a picture of this size [pixel], 0..1."""
    x0, y0, x1, y1 = box
    across, down = min(x1, width) - max(x0, 0.0), min(y1, height) - max(y0, 0.0)
    return max(across, 0.0) * max(down, 0.0) / max((x1 - x0) * (y1 - y0), 1e-9)


def overlap(one: Box, other: Box) -> float:
    """Intersection over union of two boxes, 0..1."""
    across = min(one[2], other[2]) - max(one[0], other[0])
    down = min(one[3], other[3]) - max(one[1], other[1])
    common = max(across, 0.0) * max(down, 0.0)
    whole = sum((box[2] - box[0]) * (box[3] - box[1]) for box in (one, other)) - common
    return common / max(whole, 1e-9)


SHORTEST_LEGS = 0.6  # torso's lengths from the hips down to the ankles, at least
LOWEST_HIPS, HIGHEST_HIPS = 0.45, 1.4  # [m] above the floor
MAX_DISTANCE_RATIO = 1.3  # times the farthest distance that is searched
MIN_STATURE_RATIO, MAX_STATURE_RATIO = 0.65, 1.5  # stature against the foretold one, from the length of the torso
MAX_WIDTH_RATIO = 1.0  # width of an upright body against its height
HEAD_SD = 0.045  # of its width: sd of the column of a head's middle
TORSO_SD = 0.12  # of its length: the same where the torso stands in for the head
MIN_PERSON_M, MAX_PERSON_M = 1.2, 2.1  # of a person


class BodyRules:
    """Decides which bodies count, by the direction, the distance and the floor of a question."""

    def __init__(self, settings: PeopleSettings) -> None:
        self._settings = settings

    def fits(self, body: SeenBody, distance: float | None, question: LookQuestion, view: Viewpoint) -> bool:
        """The body is upright, its size is that of the distance [m], and the sound falls in its head."""
        left, top, right, bottom = body.box
        if right - left > MAX_WIDTH_RATIO * (bottom - top) or body.legs_length < SHORTEST_LEGS * body.torso_length:
            return False
        seen = view.distance(body.torso_length)
        if distance is not None and not MIN_STATURE_RATIO < distance / seen < MAX_STATURE_RATIO:
            return False
        if question.on_floor and not self._stands(body, distance or seen, view):
            return False
        if question.bearing is None:
            return True
        half = (body.parts[0][2] - body.parts[0][0]) / 2
        low, high = view.columns_of(question.bearing, self._settings.wedge * question.sd)
        return low - half <= body.head_column <= high + half

    def _stands(self, body: SeenBody, distance: float, view: Viewpoint) -> bool:
        """The hips are as high above the floor as someone's there: legs alone look like a small person far away."""
        column = (body.parts[1][0] + body.parts[1][2]) / 2
        height = float(view.camera.mounting.translation[2]) + distance * view.elevation(column, body.hips_row)
        near = distance < MAX_DISTANCE_RATIO * self._settings.farthest
        return near and (math.isnan(height) or LOWEST_HIPS < height < HIGHEST_HIPS)


def rectangle_of(
    weighed: WeighedBody, distance: float | None, question: LookQuestion, view: Viewpoint, looks: Appearance | None
) -> Rectangle:
    """Make a rectangle of a weighed body; `distance` [m] from the camera by the laser; None: by the torso's."""
    body = weighed.body
    head, torso, _ = body.parts
    if weighed.likelihoods[0] is None:
        column, row, sd = (torso[0] + torso[2]) / 2, (torso[1] + torso[3]) / 2, TORSO_SD * body.torso_length
    else:
        column, row, sd = body.head_column, (head[1] + head[3]) / 2, HEAD_SD * (head[2] - head[0])
    by_laser = distance is not None
    distance = distance or view.distance(body.torso_length)
    height, width = question.pixels.shape[:2]
    crown = float(question.camera.mounting.translation[2]) + distance * view.elevation(column, head[1])
    measured = (
        by_laser and question.on_floor and weighed.likelihoods[0] is not None and MIN_PERSON_M < crown < MAX_PERSON_M
    )
    if looks is not None and measured:
        looks = replace(looks, height=crown)
    left, top, right, bottom = body.box
    box = max(left, 0.0), max(top, 0.0), min(right, float(width)), min(bottom, float(height))
    bearing = view.bearing(column, row)
    return Rectangle(
        value=float(weighed.value),
        shown=weighed.shown,
        distance=distance,
        bearing=0.0 if math.isnan(bearing) else bearing,
        height=min(max(crown, MIN_PERSON_M), MAX_PERSON_M)
        if question.on_floor and math.isfinite(crown)
        else STATURE_M,
        parts=tuple(
            SeenPart(name=part.name, likelihood=k, box=place)
            for part, k, place in zip(PARTS, weighed.likelihoods, body.parts, strict=True)
        ),
        centre=((box[0] + box[2]) / 2, (box[1] + box[3]) / 2),
        box=box,
        bearing_sd=sd / question.camera.model.fx,
        looks=looks,
        rank=weighed.value,
    )
