"""The landmarks of the table L: an ellipse of two standard deviations each, and a post, taller the better known."""

import numpy as np
from viser import SceneApi

from console.scene.drawing.lines import NOTHING, Lines, ellipses, lifted
from console.scene.drawing.palette import CONCAVE, CONVEX, UNSURE, mix
from core.message import Array
from core.robots import Profile
from core.slam.estimate import Landmark
from core.snapshot import Snapshot

ELLIPSE_SDS = 2.0
WELL_KNOWN = 60  # hits after which a landmark has its full colour and height
MIN_POST_M, MAX_POST_M = 0.03, 0.22
HEIGHT_M = 0.008  # of the ellipses
MIN_VARIANCE_M2 = 1e-6


class Landmarks:
    """One node for all ellipses, one for all posts; sent only when something of them has changed."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._ellipses = Lines(scene, "/landmarks/ellipses", UNSURE, 1.8)
        self._posts = Lines(scene, "/landmarks/posts", UNSURE, 3.0)
        self._shown: tuple[tuple[float, ...], ...] = ()

    def show(self, snapshot: Snapshot) -> None:
        rows = snapshot.landmarks
        seen = tuple(fingerprint(row) for row in rows)
        if seen == self._shown:
            return
        self._shown = seen
        if not rows:
            self._ellipses.draw(NOTHING)
            self._posts.draw(NOTHING)
            return
        centres = np.array([row.position for row in rows])
        covariances = np.array([row.covariance for row in rows]) + MIN_VARIANCE_M2 * np.eye(2)
        colours = np.array([colour(row) for row in rows], np.uint8)
        outlines = ellipses(centres, covariances, ELLIPSE_SDS, HEIGHT_M)
        self._ellipses.draw(outlines, np.repeat(colours, len(outlines) // len(rows), axis=0))
        self._posts.draw(posts(centres, np.array([knowledge(row) for row in rows])), colours)


def fingerprint(row: Landmark) -> tuple[float, ...]:
    """Return the visible state of a landmark: its place to a millimetre, its size, how well it is known."""
    x, y = row.position.tolist()
    spread = float(np.trace(row.covariance))
    return row.id, round(x, 3), round(y, 3), float(f"{spread:.1e}"), round(50 * knowledge(row))


def knowledge(row: Landmark) -> float:
    """0 for a landmark just met, 1 for one seen often."""
    return min(row.hits / WELL_KNOWN, 1.0)


def colour(row: Landmark) -> tuple[int, int, int]:
    """By kind; paler while it is little known."""
    full = {"convex": CONVEX, "concave": CONCAVE}.get(row.kind, CONVEX)
    return mix(full, UNSURE, 0.35 + 0.65 * knowledge(row))


def posts(centres: Array, known: Array) -> Array:
    """Centres (N, 2), knowledge (N,) → upright segments (N, 2, 3)."""
    tops = MIN_POST_M + (MAX_POST_M - MIN_POST_M) * known
    return np.stack((lifted(centres, HEIGHT_M), np.column_stack((centres, tops))), axis=1)
