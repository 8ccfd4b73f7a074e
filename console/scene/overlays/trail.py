"""The way the robot believes to have come."""

from viser import SceneApi

from console.scene.drawing.lines import LongLine
from console.scene.drawing.palette import TRAIL
from core.robots import Profile
from core.snapshot import Snapshot


class TrailLine:
    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._line = LongLine(scene, "/trail", TRAIL, 2.4, 0.006)

    def show(self, snapshot: Snapshot) -> None:
        self._line.draw(snapshot.trail)
