"""The robot: as its URDF draws it, else a round body on two wheels, with its laser turret and its camera."""

import math

from viser import SceneApi

from console.scene.drawing.palette import BODY, POSE, TRIM, TYRE, Colour
from console.scene.drawing.shapes import arrow, place, rounded_disc, turned
from core.robots import Profile
from core.snapshot import Snapshot

WHEEL_RADIUS = 0.035  # [m]
SIDEWAYS_WXYZ = (math.cos(math.pi / 4), math.sin(math.pi / 4), 0.0, 0.0)  # z turned onto y


class RobotBody:
    """Built once, then moved."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._frame = scene.add_frame("/robot", show_axes=False)
        if robot.shapes:
            for number, shape in enumerate(robot.shapes):
                scene.add_mesh_simple(
                    f"/robot/part{number}", shape.vertices, shape.faces, color=shape.colour, side="double"
                )
            return
        self._build_body(scene, robot.radius)
        self._build_wheels(scene, robot)
        self._build_turret(scene, robot)
        self._build_camera(scene, robot)

    def show(self, snapshot: Snapshot) -> None:
        place(self._frame, snapshot.estimate.pose)

    def _build_body(self, scene: SceneApi, radius: float) -> None:
        solid(scene, "/robot/chassis", rounded_disc(0.94 * radius, 0.014, 0.040, 0.010), TRIM)
        solid(scene, "/robot/shell", rounded_disc(0.98 * radius, 0.038, 0.088, 0.018), BODY)
        solid(scene, "/robot/ring", rounded_disc(0.99 * radius, 0.050, 0.055, 0.0024), POSE)
        vertices, faces = arrow(0.30 * radius, 0.24 * radius)
        scene.add_mesh_simple(
            "/robot/heading", vertices, faces, color=POSE, side="double", position=(0.62 * radius, 0.0, 0.0892)
        )

    def _build_wheels(self, scene: SceneApi, robot: Profile) -> None:
        for side, name in ((1, "left"), (-1, "right")):
            position = (0.0, side * min(robot.wheelbase / 2 + 0.034, robot.radius), WHEEL_RADIUS)
            for part, radius, width, colour in (("tyre", WHEEL_RADIUS, 0.018, TYRE), ("hub", 0.018, 0.021, BODY)):
                scene.add_cylinder(
                    f"/robot/{name}/{part}",
                    radius,
                    width,
                    colour,
                    radial_segments=40,
                    position=position,
                    wxyz=SIDEWAYS_WXYZ,
                )

    def _build_turret(self, scene: SceneApi, robot: Profile) -> None:
        if robot.laser is None:
            return
        at, height = robot.laser.mounting, robot.laser.height
        turret = scene.add_frame("/robot/laser", show_axes=False)
        turret.position = (at.x, at.y, 0.0)
        solid(scene, "/robot/laser/foot", rounded_disc(0.030, 0.086, height - 0.008, 0.006), TRIM)
        solid(scene, "/robot/laser/window", rounded_disc(0.025, height - 0.009, height + 0.009, 0.003), POSE)
        solid(scene, "/robot/laser/cap", rounded_disc(0.029, height + 0.008, height + 0.024, 0.006), TRIM)

    def _build_camera(self, scene: SceneApi, robot: Profile) -> None:
        if robot.camera is None:
            return
        x, y, z = (float(value) for value in robot.camera.mounting.translation)
        scene.add_box("/robot/mast", TRIM, (0.010, 0.012, max(z - 0.086, 0.01)), position=(x, y, (z + 0.086) / 2))
        scene.add_box("/robot/camera/case", BODY, (0.030, 0.052, 0.026), position=(x, y, z))
        scene.add_cylinder(
            "/robot/camera/lens", 0.009, 0.014, TYRE, position=(x + 0.017, y, z), wxyz=(0.7071, 0.0, 0.7071, 0.0)
        )


def solid(scene: SceneApi, name: str, profile: list[tuple[float, float]], colour: Colour) -> None:
    """A turned part of the body."""
    vertices, faces = turned(profile)
    scene.add_mesh_simple(name, vertices, faces, color=colour, side="double")
