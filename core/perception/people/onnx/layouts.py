"""Outputs of known layouts → boxes, scores and landmarks in pixels of the input.

YOLOv8 and YOLO11 (detection and pose, with and without their own suppression of doubles), YOLOX, RTMO, and
MediaPipe's person detector. MediaPipe's landmark model is used as the pose networks are.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from core.message import Array
from core.perception.people.pose.faces import anchors
from core.perception.people.pose.landmarks import sigmoid

POINT_COUNT = 17  # of COCO
POSE_ROW = 5 + 3 * POINT_COUNT  # YOLO's: box, score, x, y and visibility of each point
STRIDES_PX = (8, 16, 32)  # of YOLOX
FEWEST_ROWS = 100  # of a layout whose rows are places in the picture
FACE_ROWS = 2254  # of MediaPipe's person detector


@dataclass(frozen=True)
class Detections:
    """Detections of one model, before weighing."""

    boxes: Array  # (N, 4) left, top, right, bottom [pixel of the input]
    scores: Array  # (N,) 0..1
    points: Array | None = None  # (N, 17, 3) x, y [pixel of the input] and visibility 0..1


Decoder = Callable[[Sequence[Array], int], Detections]


@dataclass(frozen=True)
class Layout:
    """A form of output, and how a picture goes in."""

    name: str
    fits: Callable[[Sequence[tuple[int, ...]]], bool]
    decode: Decoder
    scale: float = 1 / 255  # of the pixels
    shift: float = 0.0  # that is added after it
    padding: int = 114  # grey around a picture that is no square
    red_first: bool = True


def layout_of(shapes: Sequence[tuple[int, ...]]) -> Layout | None:
    """The layout with outputs of these shapes; None: it is not known."""
    return next((layout for layout in LAYOUTS if layout.fits(shapes)), None)


def is_landmark_model(shapes: Sequence[tuple[int, ...]]) -> bool:
    """Return whether these are the outputs of MediaPipe's landmark model."""
    sizes = [int(np.prod(shape)) for shape in shapes]
    return 195 in sizes and 1 in sizes


def _corners(boxes: Array) -> Array:
    """(N, 4) middle and size → corners."""
    middles, halves = boxes[:, :2], boxes[:, 2:4] / 2
    with np.errstate(invalid="ignore"):  # a model may answer anything; what is no number is left out later
        return np.concatenate((middles - halves, middles + halves), axis=1)


def _yolo(outputs: Sequence[Array], _: int) -> Detections:
    rows = outputs[0].reshape(outputs[0].shape[-2:]).T
    return Detections(_corners(rows), rows[:, 4])  # class 0 is a person


def _yolo_pose(outputs: Sequence[Array], _: int) -> Detections:
    rows = outputs[0].reshape(outputs[0].shape[-2:]).T
    return Detections(_corners(rows), rows[:, 4], rows[:, 5:POSE_ROW].reshape(-1, POINT_COUNT, 3))


def _sorted_out(outputs: Sequence[Array], _: int) -> Detections:
    rows = outputs[0].reshape(outputs[0].shape[-2:])
    people = rows[np.round(rows[:, 5]) == 0]
    points = people[:, 6:].reshape(-1, POINT_COUNT, 3) if outputs[0].shape[-1] == POSE_ROW + 1 else None
    return Detections(people[:, :4], people[:, 4], points)


def _yolox(outputs: Sequence[Array], side: int) -> Detections:
    rows = outputs[0].reshape(outputs[0].shape[-2:])
    cells: list[Array] = []
    for stride in STRIDES_PX:
        y, x = np.mgrid[0 : side // stride, 0 : side // stride]
        cells.append(np.column_stack((x.ravel(), y.ravel(), np.full(x.size, stride))))
    grid = np.concatenate(cells)
    middles = (rows[:, :2] + grid[:, :2]) * grid[:, 2:]
    sizes = np.exp(np.clip(rows[:, 2:4], -20, 10)) * grid[:, 2:]
    return Detections(_corners(np.concatenate((middles, sizes), axis=1)), rows[:, 4] * rows[:, 5])


def _rtmo(outputs: Sequence[Array], _: int) -> Detections:
    boxes, points = sorted((one.reshape(one.shape[1:]) for one in outputs), key=lambda one: one.ndim)
    return Detections(boxes[:, :4], boxes[:, 4], points)


def _faces(outputs: Sequence[Array], side: int) -> Detections:
    rows, raw = sorted((one.reshape(FACE_ROWS, -1) for one in outputs), key=lambda one: -one.size)
    points = rows.reshape(-1, 6, 2) / side
    points[:, [0, *range(2, 6)]] += anchors()[:, None, :]
    hips, rim = points[:, 2] * side, points[:, 3] * side
    reach = np.hypot(*(rim - hips).T)
    boxes = np.column_stack(
        (hips[:, 0] - 0.45 * reach, hips[:, 1] - reach, hips[:, 0] + 0.45 * reach, hips[:, 1] + reach)
    )
    return Detections(boxes, sigmoid(raw[:, 0]))


def _one(shapes: Sequence[tuple[int, ...]]) -> tuple[int, int] | None:
    """Rows and columns of a single output (1, rows, columns); None for anything else."""
    if len(shapes) != 1 or len(shapes[0]) != 3 or shapes[0][0] != 1:
        return None
    return shapes[0][1], shapes[0][2]


def _wide(shapes: Sequence[tuple[int, ...]], wanted: Callable[[int], bool]) -> bool:
    """Return whether each column is a place: 1 x numbers x places."""
    size = _one(shapes)
    return size is not None and size[0] < size[1] and size[1] >= FEWEST_ROWS and wanted(size[0])


def _long(shapes: Sequence[tuple[int, ...]], *wanted: int) -> bool:
    """Return whether each row is a place or a find: 1 x places x numbers."""
    size = _one(shapes)
    return size is not None and size[1] in wanted


def _sizes(shapes: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
    return sorted((shape[1:] for shape in shapes if shape[:1] == (1,)), key=len)


LAYOUTS = (
    Layout("YOLO pose", lambda shapes: _wide(shapes, lambda count: count == POSE_ROW), _yolo_pose),
    Layout("YOLOX", lambda shapes: _long(shapes, 85), _yolox, scale=1.0, red_first=False),
    Layout("YOLO without doubles", lambda shapes: _long(shapes, 6, POSE_ROW + 1), _sorted_out),
    Layout("YOLO", lambda shapes: _wide(shapes, lambda count: count >= 5), _yolo),
    Layout(
        "RTMO",
        lambda shapes: [one[1:] for one in _sizes(shapes)] == [(5,), (POINT_COUNT, 3)],
        _rtmo,
        scale=1.0,
        red_first=False,
    ),
    Layout(
        "MediaPipe's person detector",
        lambda shapes: sorted(_sizes(shapes)) == [(FACE_ROWS, 1), (FACE_ROWS, 12)],
        _faces,
        scale=1 / 127.5,
        shift=-1.0,
        padding=0,
    ),
)
