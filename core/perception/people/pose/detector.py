"""Find people by the landmarks of their bodies: look at a square, look again around the hips, weigh by eq. 34."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from core.message import Array, message
from core.perception.people.appearance import Appearance
from core.perception.people.body import BodyRules, Box, WeighedBody, overlap, rectangle_of, weigh
from core.perception.people.brightness import levelled
from core.perception.people.detector import Rectangle
from core.perception.people.looking import LookQuestion
from core.perception.people.parts import PeopleSettings
from core.perception.people.pose.clothes import looks_of
from core.perception.people.pose.faces import find_faces
from core.perception.people.pose.landmarks import BodyLandmarks, body_of, landmarks_of
from core.perception.people.pose.networks import PoseNetworks, open_networks
from core.perception.people.pose.squares import FIRST_SIDE, ImagePyramid, Square, around_hips, picture_from_crop
from core.perception.people.pose.view import HIPS_HEIGHT_M, STATURE_M, Viewpoint

# Squares in which the landmark network is asked to look: foretold by direction and distance, or the detector's.

GUESSED_DISTANCES_M = (1.2, 1.8, 2.7, 4.0)  # without a laser
ASIDE_SDS = 1.5  # sd of the direction that are added to a square's side
# Statures from the picture's middle down to the hips, where the camera's height is unknown.
HIP_HEIGHT_SHARES = (0.15, 0.45, -0.15)
FEW_HEIGHTS = (0.25, -0.1)  # the same where many squares are looked at
# Rows in which hips may be: from this share of the picture's height down to so many statures under the picture.
LOW_STATURES, HIGH_SHARE = 0.45, 0.1
STATURE_SHARES = (1.1, 0.75, 0.5, 0.33)  # statures in heights of the picture, where the distance is unknown as well
WINDOW_SHARES = (1.0, 0.6)  # sides of the detector's windows, in heights of the picture
WINDOW_STATURES = 2.5  # statures: side of the one window in which the detector looks after all squares failed
STRIDE_SHARE = 0.5  # of a window's side
MOST_TILES = 8  # side by side: nobody searches a picture that is a strip
MEASURED_CONFIDENCE = 0.75  # K, at least, in a square by the distance alone: its height in the picture is not known
LIKELY_CONFIDENCE = 0.8  # the same in one that only the detector or the floor foretold
UNLIKELY_CONFIDENCE = 0.9  # and where nothing did


@message
class Candidate:
    """A square in which someone may be."""

    square: Square
    distance: float | None = None  # [m] from the camera, where it was given
    least: float = 0.0  # K of who is found there, at least: the less foretold the square, the more
    guessed: bool = False  # nothing foretold it: a body there must be one in a mirror, too


def candidates(
    question: LookQuestion, view: Viewpoint, picture: ImagePyramid, networks: PoseNetworks
) -> Iterator[Candidate]:
    """Squares, likeliest first."""
    if question.bearing is None:
        return _detected(networks, picture, _tiles(picture)) if networks.detects else _grid(picture)
    if question.on_floor:
        return _on_floor(question, question.bearing, view)
    column = view.column(question.bearing)
    if math.isnan(column):
        return iter(())
    if question.distances:
        foretold = _at_distances(question, column, view, picture)
        if not networks.detects:
            return foretold
        distance = question.distances[0]
        side = min(WINDOW_STATURES * view.stature(distance) + _doubt(question, view), float(picture.height))
        window = Square(x=column, y=picture.height / 2, side=side)
        return itertools.chain(foretold, _detected(networks, picture, iter((window,)), distance))
    if networks.detects:
        return _detected(networks, picture, _windows(picture, column))
    return _statures(picture, column, _doubt(question, view))


def _doubt(question: LookQuestion, view: Viewpoint) -> float:
    """[pixel] that are added to a square's side for the doubt of the direction."""
    return ASIDE_SDS * question.sd * view.camera.model.fx


def _on_floor(question: LookQuestion, bearing: float, view: Viewpoint) -> Iterator[Candidate]:
    """One square for each distance: the middle of a body that stands on the floor there."""
    for distance in question.distances or GUESSED_DISTANCES_M:
        place, metre = view.pixel(bearing, distance, HIPS_HEIGHT_M)
        if np.isfinite(place).all():
            side = FIRST_SIDE * STATURE_M * metre + _doubt(question, view)
            square = Square(x=float(place[0]), y=float(place[1]), side=side)
            given = distance if question.distances else None
            yield Candidate(square=square, distance=given, least=0.0 if given else LIKELY_CONFIDENCE)


def _at_distances(
    question: LookQuestion, column: float, view: Viewpoint, picture: ImagePyramid
) -> Iterator[Candidate]:
    for distance in question.distances:
        stature = view.stature(distance)
        for square in _rows(
            picture, column, stature, FIRST_SIDE * stature + _doubt(question, view), HIP_HEIGHT_SHARES
        ):
            yield Candidate(square=square, distance=distance, least=MEASURED_CONFIDENCE)


def _statures(picture: ImagePyramid, column: float, doubt: float) -> Iterator[Candidate]:
    for share in STATURE_SHARES:
        stature = share * picture.height
        for square in _rows(picture, column, stature, FIRST_SIDE * stature + doubt, FEW_HEIGHTS):
            yield Candidate(square=square, least=UNLIKELY_CONFIDENCE, guessed=True)


def _rows(
    picture: ImagePyramid, column: float, stature: float, side: float, heights: tuple[float, ...]
) -> Iterator[Square]:
    """Squares one under the other, where someone's hips may be in the picture or a little under it."""
    for height in heights:
        row = picture.height / 2 + height * stature
        if HIGH_SHARE * picture.height <= row <= picture.height + LOW_STATURES * stature:
            yield Square(x=column, y=row, side=side)


def _grid(picture: ImagePyramid) -> Iterator[Candidate]:
    """Squares everywhere: slow, where there is no detector."""
    for share in STATURE_SHARES[:3]:
        stature = share * picture.height
        count = min(MOST_TILES, max(1, math.ceil(picture.width / (0.5 * stature))))
        for column in (np.arange(count) + 0.5) * picture.width / count:
            for square in _rows(picture, float(column), stature, FIRST_SIDE * stature, FEW_HEIGHTS):
                yield Candidate(square=square, least=UNLIKELY_CONFIDENCE, guessed=True)


def _detected(
    networks: PoseNetworks, picture: ImagePyramid, windows: Iterator[Square], distance: float | None = None
) -> Iterator[Candidate]:
    for window in windows:
        for square in find_faces(networks, picture, window):
            yield Candidate(square=square, distance=distance, least=LIKELY_CONFIDENCE)


def _windows(picture: ImagePyramid, column: float) -> Iterator[Square]:
    for share in WINDOW_SHARES:
        side = share * picture.height
        count = 1 if share >= 1 else math.ceil((picture.height - side) / (STRIDE_SHARE * side)) + 1
        for row in np.linspace(side / 2, picture.height - side / 2, count) if count > 1 else [picture.height / 2]:
            yield Square(x=column, y=float(row), side=side)


def _tiles(picture: ImagePyramid) -> Iterator[Square]:
    """The whole picture, then tiles of it."""
    whole = max(picture.width, picture.height)
    yield Square(x=picture.width / 2, y=picture.height / 2, side=float(whole))
    for share in WINDOW_SHARES:
        side = share * picture.height
        if side >= 0.95 * whole:
            continue
        count = min(MOST_TILES, max(1, math.ceil((picture.width - side) / (STRIDE_SHARE * side)) + 1))
        first, last = min(side, picture.width) / 2, picture.width - min(side, picture.width) / 2
        rows = [picture.height / 2] if side >= picture.height else [side / 2, picture.height - side / 2]
        for column in np.linspace(first, last, count):
            for row in rows:
                yield Square(x=float(column), y=row, side=side)


MIN_JOINT_CONFIDENCE = 0.55  # of the first look, of it times K after the second, and of a look in a mirror
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
    for _, landmarks, _ in found:
        apart = float(np.hypot(*(landmarks.hips - (square.x, square.y))))
        if apart < 0.1 * square.side:
            return True
    return False


def _apart(
    found: list[tuple[WeighedBody, BodyLandmarks, Candidate]],
) -> list[tuple[WeighedBody, BodyLandmarks, Candidate]]:
    kept: list[tuple[WeighedBody, BodyLandmarks, Candidate]] = []
    for one in found:
        if all(overlap(one[0].body.box, other[0].body.box) < SAME_OVERLAP for other in kept):
            kept.append(one)
    return kept
