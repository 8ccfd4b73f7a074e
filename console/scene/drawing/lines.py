"""Lines in the scene: one node each, made once, redrawn by setting properties."""

from collections.abc import Iterable

import numpy as np
from viser import LineSegmentsHandle, SceneApi

from console.scene.drawing.palette import UNSURE, Colour, as_drawn
from core.message import Array

NOWHERE = np.zeros((1, 2, 3), np.float32)
NOTHING = np.zeros((0, 2, 3))
CROSS = np.array([[[-1.0, 0.0], [1.0, 0.0]], [[0.0, -1.0], [0.0, 1.0]]])  # (2, 2, 2)
CIRCLE = np.linspace(0.0, 2 * np.pi, 33)
CHUNK_POINTS = 500  # points of a long line in one node


class Lines:
    """Segments of one thickness [pixel], in one colour or a colour each; hidden while there are none."""

    def __init__(self, scene: SceneApi, name: str, colour: Colour, thickness: float) -> None:
        self._colour = np.array(colour, np.uint8)
        self._node: LineSegmentsHandle = scene.add_line_segments(
            name,
            NOWHERE,
            np.tile(self._colour, (1, 2, 1)),
            thickness=thickness,
            thickness_units="screen",
            visible=False,
        )

    def draw(self, segments: Array, colours: Array | None = None) -> None:
        """Segments (N, 2, 3) [m], colours (N, 3) of each or None."""
        if len(segments) == 0:
            self._node.visible = False
            return
        each = np.tile(self._colour, (len(segments), 1)) if colours is None else colours
        self._node.points = segments.astype(np.float32)
        self._node.colors = np.repeat(as_drawn(each)[:, None, :], 2, axis=1)
        self._node.visible = True

    def draw_each(self, pieces: Iterable[tuple[Array, Colour]]) -> None:
        """Draw pieces of segments (N, 2, 3) [m], each in one colour."""
        every = [(NOTHING, UNSURE), *pieces]
        colours = [np.tile(np.array(colour, np.uint8), (len(piece), 1)) for piece, colour in every]
        self.draw(np.concatenate([piece for piece, _ in every]), np.concatenate(colours))


class LongLine:
    """A line that grows at its end: nodes of a fixed number of points, of which only the changed ones are sent."""

    def __init__(self, scene: SceneApi, name: str, colour: Colour, thickness: float, height: float) -> None:
        self._scene = scene
        self._name = name
        self._colour = colour
        self._thickness = thickness
        self._height = height
        self._nodes: list[Lines] = []
        self._drawn: list[Array] = []
        self._points: Array | None = None

    def draw(self, points: Array) -> None:
        """Points (K, 2) [m], world."""
        if points is self._points:
            return
        self._points = points
        chunks = [
            points[start : start + CHUNK_POINTS + 1] for start in range(0, max(len(points) - 1, 0), CHUNK_POINTS)
        ]
        while len(self._nodes) < len(chunks):
            name = f"{self._name}/{len(self._nodes)}"
            self._nodes.append(Lines(self._scene, name, self._colour, self._thickness))
            self._drawn.append(points[:0])
        for number, node in enumerate(self._nodes):
            chunk = chunks[number] if number < len(chunks) else points[:0]
            if not np.array_equal(chunk, self._drawn[number]):
                self._drawn[number] = chunk
                node.draw(joined(chunk, self._height))


def joined(points: Array, height: float) -> Array:
    """Points (K, 2) → the segments (K-1, 2, 3) between neighbours, `height` [m] above the floor."""
    if len(points) < 2:
        return NOTHING
    high = lifted(points, height)
    return np.stack((high[:-1], high[1:]), axis=1)


def lifted(points: Array, height: float) -> Array:
    """Points (…, 2) [m] → (…, 3), `height` [m] above the floor."""
    return np.concatenate((points, np.full((*points.shape[:-1], 1), height)), axis=-1)


def ellipses(centres: Array, covariances: Array, sigmas: float, height: float) -> Array:
    """Centres (N, 2), covariances (N, 2, 2) → the outlines (N·32, 2, 3) of `sigmas` standard deviations."""
    if len(centres) == 0:
        return NOTHING
    values, vectors = np.linalg.eigh(0.5 * (covariances + covariances.transpose(0, 2, 1)))
    axes = vectors * (sigmas * np.sqrt(np.maximum(values, 0.0)))[:, None, :]
    ring = np.stack((np.cos(CIRCLE), np.sin(CIRCLE)))
    outline = centres[:, None, :] + (axes @ ring).transpose(0, 2, 1)
    high = lifted(outline, height)
    return np.stack((high[:, :-1], high[:, 1:]), axis=2).reshape(-1, 2, 3)
