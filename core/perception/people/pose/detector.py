"""Find people by the landmarks of their bodies: look at a square, look again around the hips, weigh by eq. 34."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from core.perception.people.body import SeenBody, WeighedBody, overlap, weigh
from core.perception.people.brightness import levelled
from core.perception.people.detector import Rectangle, SeenPart
from core.perception.people.looking import LookQuestion
from core.perception.people.parts import PARTS, PeopleSettings
from core.perception.people.pose.clothes import colours_of
from core.perception.people.pose.landmarks import BodyLandmarks, body_of, landmarks_of
from core.perception.people.pose.networks import PoseNetworks, open_networks
from core.perception.people.pose.search import Candidate, candidates
from core.perception.people.pose.squares import ImagePyramid, Square, around_hips, picture_from_crop
from core.perception.people.pose.view import STATURE, Viewpoint

WORTH = 0.4  # confidence of a first look from which a second one is worth its time
BOTH = 0.55  # confidence of the first look times K after the second, at least
SHORTEST_LEGS = 0.6  # torso's lengths from the hips down to the ankles, at least
LOWEST_HIPS, HIGHEST_HIPS = 0.45, 1.4  # [m] above the floor
BEYOND = 1.3  # times the farthest distance that is searched
NARROWEST, WIDEST = 0.65, 1.5  # stature against the foretold one, from the length of the torso
BROADEST = 1.0  # width of an upright body against its height
SURE = 0.9  # K from which nobody surer is looked for in a direction
SAME = 0.45  # overlap of two boxes from which they are one person
HEAD_SD = 0.045  # of its width: sd of the column of a head's middle
TORSO_SD = 0.12  # of its length: the same where the torso stands in for the head
SHORTEST, TALLEST = 1.2, 2.1  # [m] of a person
MOST_PEOPLE = 12


class PoseDetector:
    """MediaPipe's pose networks."""

    name = "pose"

    def __init__(self, networks: PoseNetworks, settings: PeopleSettings | None = None) -> None:
        self._networks = networks
        self._settings = settings or PeopleSettings()

    @property
    def says(self) -> str:
        """What it is."""
        return f"MediaPipe's pose networks look for people, real ones and drawn ones, by {self._networks.name}."

    def look(self, question: LookQuestion) -> tuple[Rectangle, ...]:
        """Find people, best first; in a direction only the one in whose head it falls (section 4.2)."""
        view, picture = Viewpoint(question.camera), ImagePyramid(levelled(question.pixels))
        found: list[tuple[WeighedBody, BodyLandmarks, Candidate]] = []
        for candidate in candidates(question, view, picture, self._networks):
            if question.bearing is None and _seen_already(candidate.square, found):
                continue
            first = self._landmarks(picture, candidate.square)
            if first.confidence < WORTH:
                continue
            landmarks = self._landmarks(picture, around_hips(first))
            weighed = weigh(body_of(landmarks), picture.width, picture.height)
            least = max(self._settings.threshold, candidate.least, BOTH / first.confidence)
            if weighed.value < least or not self._fits(weighed.body, candidate, question, view):
                continue
            found.append((weighed, landmarks, candidate))
            if len(found) >= MOST_PEOPLE or (question.bearing is not None and weighed.value >= SURE):
                break
        found.sort(key=lambda one: -one[0].value)
        people = [_rectangle(*one, question, view, picture) for one in _apart(found)]
        return tuple(people)

    def _landmarks(self, picture: ImagePyramid, square: Square) -> BodyLandmarks:
        rows, confidence = self._networks.landmarks(picture.cut(square))
        return landmarks_of(rows, confidence, picture_from_crop(square))

    def _fits(self, body: SeenBody, candidate: Candidate, question: LookQuestion, view: Viewpoint) -> bool:
        """The body is upright, its size is that of the distance, and the sound falls in its head."""
        left, top, right, bottom = body.box
        if right - left > BROADEST * (bottom - top) or body.legs_length < SHORTEST_LEGS * body.torso_length:
            return False
        seen = view.distance(body.torso_length)
        if candidate.distance is not None and not NARROWEST < candidate.distance / seen < WIDEST:
            return False
        if question.on_floor and not self._stands(body, candidate.distance or seen, view):
            return False
        if question.bearing is None:
            return True
        half = (body.parts[0][2] - body.parts[0][0]) / 2
        low, high = view.columns_of(question.bearing, self._settings.wedge * question.sd)
        return low - half <= body.head_column <= high + half

    def _stands(self, body: SeenBody, distance: float, view: Viewpoint) -> bool:
        """The hips are as high above the floor as somebody's there: legs alone look like a small person far away."""
        column = (body.parts[1][0] + body.parts[1][2]) / 2
        height = float(view.camera.mounting.translation[2]) + distance * view.elevation(column, body.hips_row)
        near = distance < BEYOND * self._settings.farthest
        return near and (math.isnan(height) or LOWEST_HIPS < height < HIGHEST_HIPS)


def open_pose(folder: Path, settings: PeopleSettings | None = None) -> PoseDetector:
    """Open the networks in a folder. Raises BadInput."""
    return PoseDetector(open_networks(folder), settings)


def _seen_already(square: Square, found: list[tuple[WeighedBody, BodyLandmarks, Candidate]]) -> bool:
    """Return whether the hips around which a square lies are those of somebody who was found."""
    for _, landmarks, _ in found:
        apart = float(np.hypot(*(landmarks.hips - (square.x, square.y))))
        if apart < 0.1 * square.side:
            return True
    return False


def _apart(
    found: list[tuple[WeighedBody, BodyLandmarks, Candidate]],
) -> list[tuple[WeighedBody, BodyLandmarks, Candidate]]:
    """The best of those who are one person."""
    kept: list[tuple[WeighedBody, BodyLandmarks, Candidate]] = []
    for one in found:
        if all(overlap(one[0].body.box, other[0].body.box) < SAME for other in kept):
            kept.append(one)
    return kept


def _rectangle(
    weighed: WeighedBody,
    landmarks: BodyLandmarks,
    candidate: Candidate,
    question: LookQuestion,
    view: Viewpoint,
    picture: ImagePyramid,
) -> Rectangle:
    body = weighed.body
    head, torso, _ = body.parts
    if weighed.likelihoods[0] is None:
        column, row, sd = (torso[0] + torso[2]) / 2, (torso[1] + torso[3]) / 2, TORSO_SD * body.torso_length
    else:
        column, row, sd = body.head_column, (head[1] + head[3]) / 2, HEAD_SD * (head[2] - head[0])
    distance = candidate.distance or view.distance(body.torso_length)
    crown = float(question.camera.mounting.translation[2]) + distance * view.elevation(column, head[1])
    left, top, right, bottom = body.box
    box = max(left, 0.0), max(top, 0.0), min(right, float(picture.width)), min(bottom, float(picture.height))
    bearing = view.bearing(column, row)
    return Rectangle(
        value=float(weighed.value),
        shown=weighed.shown,
        distance=distance,
        bearing=0.0 if math.isnan(bearing) else bearing,
        height=min(max(crown, SHORTEST), TALLEST) if question.on_floor and math.isfinite(crown) else STATURE,
        parts=tuple(
            SeenPart(name=part.name, likelihood=k, box=place)
            for part, k, place in zip(PARTS, weighed.likelihoods, body.parts, strict=True)
        ),
        centre=((box[0] + box[2]) / 2, (box[1] + box[3]) / 2),
        box=box,
        bearing_sd=sd / question.camera.model.fx,
        colours=colours_of(landmarks, weighed, picture.pixels),
        rank=weighed.value,
    )
