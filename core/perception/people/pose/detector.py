"""Find people by the landmarks of their bodies: look at a square, look again around the hips, weigh by eq. 34."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from core.message import Array
from core.perception.people.appearance import Appearance
from core.perception.people.body import Box, WeighedBody, overlap, weigh
from core.perception.people.body_rules import BodyRules, rectangle_of
from core.perception.people.brightness import levelled
from core.perception.people.detector import Rectangle
from core.perception.people.looking import LookQuestion
from core.perception.people.parts import PeopleSettings
from core.perception.people.pose.clothes import looks_of
from core.perception.people.pose.landmarks import BodyLandmarks, body_of, landmarks_of
from core.perception.people.pose.networks import PoseNetworks, open_networks
from core.perception.people.pose.search import Candidate, candidates
from core.perception.people.pose.squares import FIRST_SIDE, ImagePyramid, Square, around_hips, picture_from_crop
from core.perception.people.pose.view import Viewpoint

MIN_JOINT_CONFIDENCE = 0.55  # of the first look times K after the second; less is not worth a second look
SURE_CONFIDENCE = 0.9  # K from which nobody surer is looked for in a direction
SAME_OVERLAP = 0.45  # overlap of two boxes from which they are one person
MOST_PEOPLE = 12


class PoseDetector:
    """MediaPipe's pose networks."""

    name = "pose"

    def __init__(self, networks: PoseNetworks, settings: PeopleSettings | None = None) -> None:
        self._networks = networks
        self._settings = settings or PeopleSettings()
        self._rules = BodyRules(self._settings)

    @property
    def says(self) -> str:
        """A sentence on this detector."""
        return f"MediaPipe's pose networks look for people, real ones and drawn ones, by {self._networks.name}."

    def look(self, question: LookQuestion) -> tuple[Rectangle, ...]:
        """Find people, best first; in a direction only the one in whose head it falls (section 4.2)."""
        view, picture = Viewpoint(question.camera), ImagePyramid(levelled(question.pixels))
        found: list[tuple[WeighedBody, BodyLandmarks, Candidate]] = []
        for candidate in candidates(question, view, picture, self._networks):
            if question.bearing is None and _seen_already(candidate.square, found):
                continue
            first = self._landmarks(picture, candidate.square)
            if first.confidence < MIN_JOINT_CONFIDENCE:
                continue
            landmarks = self._landmarks(picture, around_hips(first))
            weighed = weigh(body_of(landmarks), picture.width, picture.height)
            least = max(self._settings.threshold, candidate.least, MIN_JOINT_CONFIDENCE / first.confidence)
            if weighed.value < least or not self._rules.fits(weighed.body, candidate.distance, question, view):
                continue
            if candidate.guessed and self._mirrored(picture, landmarks) < MIN_JOINT_CONFIDENCE:
                continue
            found.append((weighed, landmarks, candidate))
            if len(found) >= MOST_PEOPLE or (question.bearing is not None and weighed.value >= SURE_CONFIDENCE):
                break
        found.sort(key=lambda one: -one[0].value)
        return tuple(self._rectangle(one, question, view, picture) for one in _apart(found))

    def looks_in(self, pixels: Array, box: Box) -> Appearance | None:
        """The looks of someone around whom a box is known [pixel], whole in the picture; None: nobody is seen."""
        picture = ImagePyramid(levelled(pixels))
        left, top, right, bottom = box
        square = Square(x=(left + right) / 2, y=(top + bottom) / 2, side=FIRST_SIDE * (bottom - top))
        landmarks = self._landmarks(picture, around_hips(self._landmarks(picture, square)))
        weighed = weigh(body_of(landmarks), picture.width, picture.height)
        seen = weighed.value >= self._settings.threshold
        return looks_of(landmarks, weighed, picture.pixels) if seen else None

    def _rectangle(
        self,
        found: tuple[WeighedBody, BodyLandmarks, Candidate],
        question: LookQuestion,
        view: Viewpoint,
        picture: ImagePyramid,
    ) -> Rectangle:
        weighed, landmarks, candidate = found
        looks = looks_of(landmarks, weighed, picture.pixels)
        return replace(rectangle_of(weighed, candidate.distance, question, view, looks), landmarks=landmarks.seen)

    def _mirrored(self, picture: ImagePyramid, landmarks: BodyLandmarks) -> float:
        """Confidence in a body when its square is seen in a mirror: what only looks like one is surer one way."""
        square = picture.cut(around_hips(landmarks))
        return self._networks.landmarks(np.ascontiguousarray(square[:, ::-1]))[1]

    def _landmarks(self, picture: ImagePyramid, square: Square) -> BodyLandmarks:
        rows, confidence = self._networks.landmarks(picture.cut(square))
        return landmarks_of(rows, confidence, picture_from_crop(square))


def open_pose(folder: Path, settings: PeopleSettings | None = None) -> PoseDetector:
    """Open the networks in a folder. Raises BadInput."""
    return PoseDetector(open_networks(folder), settings)


def _seen_already(square: Square, found: list[tuple[WeighedBody, BodyLandmarks, Candidate]]) -> bool:
    """Return whether the hips around which a square lies are those of someone who was found."""
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
        if all(overlap(one[0].body.box, other[0].body.box) < SAME_OVERLAP for other in kept):
            kept.append(one)
    return kept
