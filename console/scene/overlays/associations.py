"""The newest sightings: a ray to each match, a broken ray with a cross to each rejected one."""

import numpy as np
from viser import SceneApi

from console.scene.drawing.lines import Lines, lifted
from console.scene.drawing.palette import CONVEX, DOUBT, UNSURE
from core.message import Array
from core.robots import Profile
from core.slam.estimate import Association
from core.snapshot import Snapshot

CROSS_ARM_M = 0.045  # of a cross
HEIGHT_M = 0.014
RAY_DASHES = 10  # of a broken ray
REJECTED, ON_TRIAL = ("ignored",), ("tentative", "new")


class Associations:
    """Rays and crosses of the newest update: matched green, rejected amber, on trial grey."""

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
        self._rays.draw(lifted(rays(here, matched), HEIGHT_M))
        broken = np.concatenate((dashes(here, rejected), crosses(rejected)))
        self._rejected.draw(lifted(broken, HEIGHT_M))
        self._trial.draw(lifted(crosses(places(self._shown, ON_TRIAL)), HEIGHT_M))


def places(associations: tuple[Association, ...], fates: tuple[str, ...]) -> Array:
    """Return the places (N, 2) [m] of the sightings that had one of these fates."""
    chosen = [seen.position for seen in associations if seen.fate in fates]
    return np.array(chosen).reshape(-1, 2)


def rays(start: Array, ends: Array) -> Array:
    """From one place (2,) to others (N, 2) → segments (N, 2, 2)."""
    return np.stack((np.broadcast_to(start, ends.shape), ends), axis=1)


def dashes(start: Array, ends: Array) -> Array:
    """The same, broken → segments (N·DASHES, 2, 2)."""
    part = np.linspace(0.0, 1.0, 2 * RAY_DASHES + 1)[:-1]
    points = start + part[None, :, None] * (ends - start)[:, None, :]
    return points.reshape(-1, 2, 2)


def crosses(centres: Array) -> Array:
    """Centres (N, 2) → the two strokes of each (2N, 2, 2)."""
    one, other = np.array([CROSS_ARM_M, CROSS_ARM_M]), np.array([CROSS_ARM_M, -CROSS_ARM_M])
    starts, ends = np.vstack((centres - one, centres - other)), np.vstack((centres + one, centres + other))
    return np.stack((starts, ends), axis=1)
