"""A model of the user's own as a detector of people: any ONNX file of a known layout."""

from __future__ import annotations

import contextlib
from collections.abc import Generator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from core.errors import BadInput
from core.message import Array
from core.perception.people.body import Box, overlap, weigh
from core.perception.people.body_rules import BodyRules, rectangle_of
from core.perception.people.brightness import levelled
from core.perception.people.detector import Rectangle
from core.perception.people.looking import LookQuestion, PersonDetector
from core.perception.people.onnx.bodies import body_of_box, body_of_points
from core.perception.people.onnx.header import input_shape
from core.perception.people.onnx.layouts import LAYOUTS, Detections, Layout, is_landmark_model, layout_of
from core.perception.people.parts import PeopleSettings
from core.perception.people.pose.clothes import looks_in_boxes
from core.perception.people.pose.detector import PoseDetector
from core.perception.people.pose.networks import LANDMARK_SIDE, first_number
from core.perception.people.pose.view import Viewpoint

MOST_BYTES = 400 * 2**20
MOST_MEMORY = 700 * 2**20  # [bytes] that a network may take
DOUBLE_OVERLAP = 0.45  # overlap from which two boxes are one person
MIN_SCORE = 0.25  # score below which a detection is not looked at
MAX_DETECTIONS = 50  # detections of one picture
KNOWN = ", ".join(layout.name for layout in LAYOUTS)


class OwnModelDetector:
    """Detections in the whole picture; of these the ones that direction, distance and floor allow."""

    name = "pose"

    def __init__(self, net: Any, layout: Layout, side: int, settings: PeopleSettings) -> None:
        """`side` [pixel] of the square that goes in."""
        self._net, self._layout, self._side, self._settings = net, layout, side, settings
        self._rules = BodyRules(settings)

    @property
    def says(self) -> str:
        """A sentence on this detector."""
        return f"Your own model ({self._layout.name}, {self._side} pixels) looks for people."

    def look(self, question: LookQuestion) -> tuple[Rectangle, ...]:
        """Find people, best first. Raises BadInput where the model fails."""
        pixels = levelled(question.pixels)
        height, width = pixels.shape[:2]
        view, factor = Viewpoint(question.camera), max(height, width) / self._side
        distance = question.distances[0] if question.distances else None
        found: list[Rectangle] = []
        for box, score, points in _apart(self._detections(pixels)):
            edges = _scaled(box, factor)
            if points is None:
                body = body_of_box(edges, score)
            else:
                body = body_of_points(edges, score, points * (factor, factor, 1.0))
            weighed = weigh(body, width, height)
            if weighed.value >= self._settings.threshold and self._rules.fits(body, distance, question, view):
                found.append(rectangle_of(weighed, distance, question, view, looks_in_boxes(weighed, pixels)))
        return tuple(sorted(found, key=lambda one: -one.value))

    def _detections(self, pixels: Array) -> Detections:
        outputs = run(self._net, letterboxed(pixels, self._side, self._layout))
        return self._layout.decode(outputs, self._side)


class OwnLandmarkNetwork:
    """MediaPipe's landmark model as an ONNX file, which takes (1, 256, 256, 3)."""

    name = "OpenCV, your own file"
    detects = False

    def __init__(self, net: Any) -> None:
        self._net = net

    def landmarks(self, crop: Array) -> tuple[Array, float]:
        """Run the network."""
        outputs = run(self._net, crop[None, :, :, ::-1].astype(np.float32) / np.float32(255))
        sizes = [one.size for one in outputs]
        return outputs[sizes.index(195)].reshape(39, 5).astype(float), first_number(outputs[sizes.index(1)])

    def faces(self, square: Array) -> tuple[Array, Array]:
        """There is no detector in this file."""
        raise BadInput("The landmark model detects nobody in a whole picture.")


def open_own_model(path: Path, settings: PeopleSettings) -> PersonDetector:
    """Open an ONNX file, whose layout is recognised from its outputs. Raises BadInput with a sentence."""
    try:
        if not path.is_file():
            raise BadInput("there is no such file")
        if path.stat().st_size > MOST_BYTES:
            raise BadInput(f"it is larger than {MOST_BYTES // 2**20} MB")
        content = path.read_bytes()
        shape = input_shape(content)
        with at_most(MOST_MEMORY):
            net = _network(content)
            outputs = run(net, np.zeros(shape, np.float32))
    except OSError as trouble:
        raise BadInput(f"The model {path.name[:60]!r} cannot be read: {trouble.strerror or trouble}.") from None
    except BadInput as wrong:
        raise BadInput(f"The model {path.name[:60]!r} cannot be used: {wrong}.") from None
    shapes = [one.shape for one in outputs]
    if is_landmark_model(shapes) and shape == (1, LANDMARK_SIDE, LANDMARK_SIDE, 3):
        return PoseDetector(OwnLandmarkNetwork(net), settings)
    layout = layout_of(shapes)
    if layout is None or shape[2] != shape[3]:
        sizes = ", ".join("x".join(map(str, one)) for one in shapes)
        raise BadInput(f"The model {path.name[:60]!r} has outputs {sizes}, which are none of those known: {KNOWN}.")
    return OwnModelDetector(net, layout, shape[2], settings)


@contextlib.contextmanager
def at_most(more: int) -> Generator[None]:
    """Let this process take at most `more` bytes more, where the system can say so: a small file may ask for any."""
    try:
        import resource  # not on Windows

        taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    except (ImportError, OSError, ValueError):
        yield
        return
    before = resource.getrlimit(resource.RLIMIT_AS)
    least = min((one for one in before if one != resource.RLIM_INFINITY), default=taken + more)
    resource.setrlimit(resource.RLIMIT_AS, (min(least, taken + more), before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def run(net: Any, given: Array) -> list[Array]:
    """Run a network → its outputs. Raises BadInput."""
    try:
        net.setInput(given)
        return [np.asarray(one) for one in net.forward(net.getUnconnectedOutLayersNames())]
    except (cv2.error, MemoryError):
        raise BadInput("OpenCV cannot run it") from None


def letterboxed(pixels: Array, side: int, layout: Layout) -> Array:
    """A picture (H, W, 3) → (1, 3, side, side) float32, in the upper left corner."""
    factor = side / max(pixels.shape[:2])
    size = max(1, round(pixels.shape[1] * factor)), max(1, round(pixels.shape[0] * factor))
    square = np.full((side, side, 3), layout.padding, np.uint8)
    square[: size[1], : size[0]] = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    if layout.red_first:
        square = square[:, :, ::-1]
    return (square.transpose(2, 0, 1)[None].astype(np.float32) * layout.scale + layout.shift).astype(np.float32)


def _network(content: bytes) -> Any:
    try:
        return cv2.dnn.readNetFromONNX(np.frombuffer(content, np.uint8))
    except (cv2.error, MemoryError):
        raise BadInput("OpenCV cannot read it") from None


def _apart(found: Detections) -> list[tuple[Box, float, Array | None]]:
    """The best of those who are one person."""
    usable = np.isfinite(found.boxes).all(axis=1) & np.isfinite(found.scores) & (found.scores >= MIN_SCORE)
    kept: list[tuple[Box, float, Array | None]] = []
    for row in np.flatnonzero(usable)[np.argsort(-found.scores[usable])][: 20 * MAX_DETECTIONS]:
        left, top, right, bottom = found.boxes[row].tolist()
        box = (left, top, right, bottom)
        if right - left < 2 or bottom - top < 2 or any(overlap(box, other) > DOUBLE_OVERLAP for other, _, _ in kept):
            continue
        points = None if found.points is None else np.nan_to_num(found.points[row].astype(float))
        kept.append((box, min(float(found.scores[row]), 1.0), points))
        if len(kept) == MAX_DETECTIONS:
            break
    return kept


def _scaled(box: Box, factor: float) -> Box:
    left, top, right, bottom = (edge * factor for edge in box)
    return left, top, right, bottom
