"""The dead-reckoned pose, by the wheels alone, translucent, with its trail."""

from viser import SceneApi

from console.scene.drawing.lines import LongLine
from console.scene.drawing.palette import GHOST
from console.scene.drawing.shapes import arrow, place, rounded_disc, turned
from core.robots import Profile
from core.snapshot import Snapshot


class DeadReckoningGhost:
    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._frame = scene.add_frame("/ghost", show_axes=False)
        vertices, faces = turned(rounded_disc(0.98 * robot.radius, 0.014, 0.088, 0.018))
        scene.add_mesh_simple(
            "/ghost/body", vertices, faces, color=GHOST, opacity=0.28, cast_shadow=False, receive_shadow=False
        )
        vertices, faces = arrow(0.42 * robot.radius, 0.34 * robot.radius)
        scene.add_mesh_simple(
            "/ghost/heading",
            vertices,
            faces,
            color=GHOST,
            opacity=0.8,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
            position=(0.4 * robot.radius, 0.0, 0.0895),
        )
        self._trail = LongLine(scene, "/ghost_trail", GHOST, 1.4, 0.004)

    def show(self, snapshot: Snapshot) -> None:
        place(self._frame, snapshot.dead_reckoning.pose)
        self._trail.draw(snapshot.dead_reckoning_trail)
