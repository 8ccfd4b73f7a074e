"""What became of the newest sightings: a ray to each that was matched, a cross for each that was not."""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from console.scene.palette import CONVEX, UNSURE
from console.scene.strokes import Strokes
from core.message import Array
from core.robots import Profile
from core.slam.estimate import Association
from core.snapshot import Snapshot

ARM = 0.035  # [m] of a cross
HEIGHT = 0.014  # [m]


class Associations:
    """Rays and crosses of the newest update."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._rays = Strokes(scene, "/associations/rays", CONVEX, 1.0)
        self._crosses = Strokes(scene, "/associations/crosses", UNSURE, 1.8)
        self._shown: tuple[Association, ...] | None = None

    def show(self, snapshot: Snapshot) -> None:
        """Draw them when they are new."""
        if snapshot.associations is self._shown:
            return
        self._shown = snapshot.associations
        pose = snapshot.estimate.pose
        matched = places(self._shown, matched=True)
        here = np.broadcast_to([pose.x, pose.y], matched.shape)
        self._rays.draw(np.stack((lifted(here), lifted(matched)), axis=1))
        loose = places(self._shown, matched=False)
        one, other = np.array([ARM, ARM]), np.array([ARM, -ARM])
        starts = lifted(np.vstack((loose - one, loose - other)))
        self._crosses.draw(np.stack((starts, lifted(np.vstack((loose + one, loose + other)))), axis=1))


def places(associations: tuple[Association, ...], *, matched: bool) -> Array:
    """Where the sightings lie (N, 2) [m] that were matched, or that were not."""
    chosen = [seen.position for seen in associations if (seen.fate == "matched") is matched]
    return np.array(chosen).reshape(-1, 2)


def lifted(points: Array) -> Array:
    """Points (N, 2) → (N, 3) just above the floor."""
    return np.column_stack((points, np.full(len(points), HEIGHT)))
