"""When a body that a model found is someone who may be meant, and the rectangle that is made of it."""

import math
from dataclasses import replace

from core.perception.people.appearance import Appearance
from core.perception.people.body import SeenBody, WeighedBody
from core.perception.people.detector import Rectangle, SeenPart
from core.perception.people.looking import LookQuestion
from core.perception.people.parts import PARTS, PeopleSettings
from core.perception.people.pose.view import STATURE_M, Viewpoint

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
