"""The newest scan, at the height of the laser."""

import numpy as np
from viser import SceneApi

from console.scene.drawing.palette import SCAN
from core.message import Array
from core.robots import Profile
from core.snapshot import Snapshot


class ScanPoints:
    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._height = robot.laser.height if robot.laser is not None else 0.1
        self._cloud = scene.add_point_cloud(
            "/scan",
            np.zeros((1, 3), np.float32),
            SCAN,
            point_size=0.018,
            point_shape="circle",
            point_shading="flat",
            precision="float32",
            visible=False,
        )
        self._shown: Array | None = None

    def show(self, snapshot: Snapshot) -> None:
        points = snapshot.scan_points
        if points is self._shown:
            return
        self._shown = points
        if len(points):
            self._cloud.points = np.column_stack((points, np.full(len(points), self._height))).astype(np.float32)
        self._cloud.visible = bool(len(points))
