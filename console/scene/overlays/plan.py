"""The planned path, and a marker at its goal."""

import numpy as np
from viser import SceneApi

from console.scene.drawing.lines import CIRCLE, Lines, joined
from console.scene.drawing.palette import PLAN
from console.scene.drawing.shapes import turned
from core.message import Array
from core.robots import Profile
from core.snapshot import Snapshot

HEIGHT_M = 0.012
RING_RADII_M = (0.05, 0.11)
PIN = [(0.002, 0.012), (0.004, 0.03), (0.024, 0.15), (0.030, 0.17), (0.024, 0.19), (0.001, 0.20)]


class Plan:
    """A line to a pin with two rings."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._path = Lines(scene, "/path", PLAN, 3.2)
        self._goal = scene.add_frame("/goal", show_axes=False, visible=False)
        vertices, faces = turned(PIN)
        scene.add_mesh_simple("/goal/pin", vertices, faces, color=PLAN, side="double")
        for number, radius in enumerate(RING_RADII_M):
            ring = radius * np.column_stack((np.cos(CIRCLE), np.sin(CIRCLE)))
            Lines(scene, f"/goal/ring{number}", PLAN, 2.6 - number).draw(joined(ring, HEIGHT_M))
        self._shown: tuple[Array | None, Array | None] = (None, None)

    def show(self, snapshot: Snapshot) -> None:
        if self._shown[0] is snapshot.path and self._shown[1] is snapshot.goal:
            return
        self._shown = (snapshot.path, snapshot.goal)
        self._path.draw(joined(snapshot.path, HEIGHT_M))
        if snapshot.goal is not None:
            self._goal.position = np.array([snapshot.goal[0], snapshot.goal[1], 0.0])
        self._goal.visible = snapshot.goal is not None
