"""The landmarks of the table L, and the newest sightings of them."""

import numpy as np
from viser import SceneApi

from console.scene.drawing.lines import NOTHING, Lines, ellipses, lifted
from console.scene.drawing.palette import CONCAVE, CONVEX, DOUBT, UNSURE, faded
from core.message import Array
from core.robots import Profile
from core.slam.estimate import Association, Landmark
from core.snapshot import Snapshot

ELLIPSE_SDS = 2.0
WELL_KNOWN = 60  # hits after which a landmark has its full colour and height
MIN_POST_M, MAX_POST_M = 0.03, 0.22
HEIGHT_M = 0.008  # of the ellipses
MIN_VARIANCE_M2 = 1e-6
CROSS_ARM_M = 0.045  # of a cross
RAY_HEIGHT_M = 0.014
RAY_DASHES = 10  # of a broken ray
REJECTED, ON_TRIAL = ("ignored",), ("tentative", "new")


class Landmarks:
    """An ellipse of two standard deviations each, and a post, taller the better known; sent when changed."""

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
    return faded(full, 0.35 + 0.65 * knowledge(row))


def posts(centres: Array, known: Array) -> Array:
    """Centres (N, 2), knowledge (N,) → upright segments (N, 2, 3)."""
    tops = MIN_POST_M + (MAX_POST_M - MIN_POST_M) * known
    return np.stack((lifted(centres, HEIGHT_M), np.column_stack((centres, tops))), axis=1)


class Associations:
    """A ray to each match, green; a broken one with a cross to each rejected sighting, amber; on trial grey."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._rays = Lines(scene, "/associations/rays", CONVEX, 1.0)
        self._rejected = Lines(scene, "/associations/rejected", DOUBT, 1.8)
        self._trial = Lines(scene, "/associations/trial", UNSURE, 1.8)
        self._shown: tuple[Association, ...] | None = None

    def show(self, snapshot: Snapshot) -> None:
        if snapshot.associations is self._shown:
            return
        self._shown = snapshot.associations
        pose = snapshot.estimate.pose
        here = np.array([pose.x, pose.y])
        matched, rejected = places(self._shown, ("matched",)), places(self._shown, REJECTED)
        self._rays.draw(lifted(rays(here, matched), RAY_HEIGHT_M))
        broken = np.concatenate((dashes(here, rejected), crosses(rejected)))
        self._rejected.draw(lifted(broken, RAY_HEIGHT_M))
        self._trial.draw(lifted(crosses(places(self._shown, ON_TRIAL)), RAY_HEIGHT_M))


def places(associations: tuple[Association, ...], fates: tuple[str, ...]) -> Array:
    """Return the places (N, 2) [m] of the sightings that had one of these fates."""
    return np.array([seen.position for seen in associations if seen.fate in fates]).reshape(-1, 2)


def rays(start: Array, ends: Array) -> Array:
    """From one place (2,) to others (N, 2) → segments (N, 2, 2)."""
    return np.stack((np.broadcast_to(start, ends.shape), ends), axis=1)


def dashes(start: Array, ends: Array) -> Array:
    """The same, broken → segments (N·DASHES, 2, 2)."""
    part = np.linspace(0.0, 1.0, 2 * RAY_DASHES + 1)[:-1]
    return (start + part[None, :, None] * (ends - start)[:, None, :]).reshape(-1, 2, 2)


def crosses(centres: Array) -> Array:
    """Centres (N, 2) → the two strokes of each (2N, 2, 2)."""
    one, other = np.array([CROSS_ARM_M, CROSS_ARM_M]), np.array([CROSS_ARM_M, -CROSS_ARM_M])
    starts, ends = np.vstack((centres - one, centres - other)), np.vstack((centres + one, centres + other))
    return np.stack((starts, ends), axis=1)
