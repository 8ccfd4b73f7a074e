"""A model of the user's own as a detector of people: any ONNX file of a known layout."""

import contextlib
from collections.abc import Generator, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from core.errors import BadInput
from core.message import Array
from core.perception.people.body import BodyRules, Box, SeenBody, overlap, rectangle_of, weigh
from core.perception.people.brightness import levelled
from core.perception.people.detector import Rectangle
from core.perception.people.looking import LookQuestion, PersonDetector
from core.perception.people.onnx.layouts import LAYOUTS, Detections, Layout, is_landmark_model, layout_of
from core.perception.people.parts import PeopleSettings
from core.perception.people.pose.clothes import looks_in_boxes
from core.perception.people.pose.detector import PoseDetector
from core.perception.people.pose.landmarks import body_around
from core.perception.people.pose.networks import LANDMARK_SIDE, first_number
from core.perception.people.pose.view import Viewpoint

# The size of the picture that an ONNX file takes, read without running it (protobuf, field by field).

GRAPH_FIELD, INPUT_FIELD, INITIALIZER_FIELD = 7, 11, 5  # fields of ModelProto and GraphProto
VALUE_NAME, VALUE_TYPE, TENSOR_NAME = 1, 2, 8  # of ValueInfoProto and TensorProto
TENSOR_TYPE, SHAPE_FIELD, DIMENSION_FIELD, DIMENSION_VALUE = 1, 2, 1, 1
VARINT_KIND, LONG_KIND, BYTES_KIND, WORD_KIND = 0, 1, 2, 5  # wire types
BROKEN = "this is no ONNX file, or it is damaged"
USUAL_SHAPE = (1, 3, 640, 640)  # where the file leaves its size open
MAX_SIDE_PX = 1920


def input_shape(content: bytes) -> tuple[int, int, int, int]:
    """An ONNX file → the four dimensions of the picture that goes in. Raises BadInput."""
    graph = next(
        (value for field, value in fields(content) if field == GRAPH_FIELD and isinstance(value, bytes)), None
    )
    if graph is None:
        raise BadInput(BROKEN)
    weights: set[bytes] = set()
    inputs: list[bytes] = []
    for field, value in fields(graph):
        if field == INITIALIZER_FIELD and isinstance(value, bytes):
            weights |= {name for number, name in fields(value) if number == TENSOR_NAME and isinstance(name, bytes)}
        elif field == INPUT_FIELD and isinstance(value, bytes):
            inputs.append(value)
    for one in inputs:
        names = [value for number, value in fields(one) if number == VALUE_NAME]
        shape = _shape(one)
        if names and names[0] not in weights and len(shape) == 4:
            return _whole(shape)
    raise BadInput("the model takes no picture: none of its inputs has four dimensions")


def fields(content: bytes) -> Iterator[tuple[int, int | bytes]]:
    """The fields of a protobuf message: number, and a whole number or bytes. Raises BadInput."""
    at = 0
    while at < len(content):
        key, at = _varint(content, at)
        kind = key & 7
        if kind == VARINT_KIND:
            value, at = _varint(content, at)
        elif kind == BYTES_KIND:
            length, at = _varint(content, at)
            value, at = content[at : at + length], at + length
        elif kind in (LONG_KIND, WORD_KIND):
            width = 8 if kind == LONG_KIND else 4
            value, at = content[at : at + width], at + width
        else:
            raise BadInput(BROKEN)
        if at > len(content):
            raise BadInput(BROKEN)
        yield key >> 3, value


def _varint(content: bytes, at: int) -> tuple[int, int]:
    value = shift = 0
    while at < len(content) and shift < 70:
        byte = content[at]
        value |= (byte & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if byte < 0x80:
            return value, at
    raise BadInput(BROKEN)


def _inner(content: bytes, wanted: int) -> bytes:
    found = [value for number, value in fields(content) if number == wanted and isinstance(value, bytes)]
    return found[0] if found else b""


def _shape(value_info: bytes) -> list[int]:
    shape = _inner(_inner(_inner(value_info, VALUE_TYPE), TENSOR_TYPE), SHAPE_FIELD)
    sizes: list[int] = []
    for number, dimension in fields(shape):
        if number == DIMENSION_FIELD and isinstance(dimension, bytes):
            values = [value for field, value in fields(dimension) if field == DIMENSION_VALUE]
            sizes.append(values[0] if values and isinstance(values[0], int) else 0)
    return sizes


def _whole(shape: list[int]) -> tuple[int, int, int, int]:
    """The shape with what it leaves open; channels may come last. Raises BadInput."""
    last = shape[3] == 3 and shape[1] != 3
    usual = (USUAL_SHAPE[0], USUAL_SHAPE[2], USUAL_SHAPE[3], USUAL_SHAPE[1]) if last else USUAL_SHAPE
    batch, *rest = (size or plain for size, plain in zip(shape, usual, strict=True))
    sides = rest[:2] if last else rest[1:]
    if batch != 1 or 3 not in (rest[0], rest[2]) or not all(32 <= side <= MAX_SIDE_PX for side in sides):
        raise BadInput(f"the model takes {'x'.join(map(str, shape))} numbers; a colour picture is 1x3xHxW")
    return batch, rest[0], rest[1], rest[2]


# A detection of a model → head, torso and feet.

FACE_ROWS = (0, 1, 2, 3, 4)
JOINT_ROWS = ((5, 6), (11, 12), (13, 14, 15, 16), (15, 16))  # shoulders, hips, legs, ankles
HEAD_SHARE, TORSO_SHARE = 0.16, 0.5  # of the box's height, where there are no landmarks
TORSO_LENGTH = 0.29  # statures


def body_of_box(box: Box, score: float) -> SeenBody:
    """A person of whom only the box is known."""
    left, top, right, bottom = box
    tall, middle = bottom - top, (left + right) / 2
    half = min(0.5 * HEAD_SHARE * tall, (right - left) / 2)
    neck, hips = top + HEAD_SHARE * tall, top + TORSO_SHARE * tall
    return SeenBody(
        parts=((middle - half, top, middle + half, neck), (left, neck, right, hips), (left, hips, right, bottom)),
        likelihoods=(score, score, score),
        box=box,
        head_column=middle,
        foretold_head=top + 0.5 * HEAD_SHARE * tall,
        hips_row=hips,
        torso_length=max(TORSO_LENGTH * tall, 1e-3),
        legs_length=0.45 * tall,
        confidence=score,
    )


def body_of_points(box: Box, score: float, points: Array) -> SeenBody:
    """A person with COCO's 17 landmarks (17, 3): x, y [pixel] and visibility 0..1."""
    shoulders, hips, legs, _ = JOINT_ROWS
    shown = np.clip(points[:, 2], 0, 1)
    shares = [float(shown[list(group)].mean()) for group in (FACE_ROWS, (*shoulders, *hips), legs)]
    joints = [points[list(rows), :2] for rows in JOINT_ROWS]
    return replace(body_around(points[list(FACE_ROWS), :2].mean(axis=0), joints, shares, score, 0.15), box=box)


MOST_BYTES = 400 * 2**20
MAX_MEMORY_BYTES = 700 * 2**20  # that a network may take
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
        outputs = run(self._net, letterboxed(pixels, self._side, self._layout))
        for box, score, points in _apart(self._layout.decode(outputs, self._side)):
            edges = _scaled(box, factor)
            if points is None:
                body = body_of_box(edges, score)
            else:
                body = body_of_points(edges, score, points * (factor, factor, 1.0))
            weighed = weigh(body, width, height)
            if weighed.value >= self._settings.threshold and self._rules.fits(body, distance, question, view):
                found.append(rectangle_of(weighed, distance, question, view, looks_in_boxes(weighed, pixels)))
        return tuple(sorted(found, key=lambda one: -one.value))


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
        with at_most(MAX_MEMORY_BYTES):
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
