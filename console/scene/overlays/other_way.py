"""The other way of a recording, translucent, with its trail: what is computed now over what was recorded."""

from viser import SceneApi

from console.scene.drawing.lines import LongLine
from console.scene.drawing.palette import OTHER
from console.scene.drawing.shapes import place, rounded_disc, turned
from core.pilot.trail import NO_POINTS
from core.robots import Profile
from core.snapshot import Snapshot


class OtherWayGhost:
    """The robot where the other way has it; nothing where only one is shown."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._frame = scene.add_frame("/other", show_axes=False, visible=False)
        vertices, faces = turned(rounded_disc(0.98 * robot.radius, 0.014, 0.088, 0.018))
        scene.add_mesh_simple(
            "/other/body", vertices, faces, color=OTHER, opacity=0.4, cast_shadow=False, receive_shadow=False
        )
        self._trail = LongLine(scene, "/other_trail", OTHER, 1.8, 0.006)

    def show(self, snapshot: Snapshot) -> None:
        other = snapshot.other
        self._frame.visible = other is not None
        if other is not None:
            place(self._frame, other.pose)
        self._trail.draw(NO_POINTS if other is None else other.trail)
