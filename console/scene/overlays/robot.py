"""The robot where it believes to be, with the way it came; translucent, where the wheels or the other way have it."""

import math

from viser import FrameHandle, SceneApi

from console.scene.drawing.lines import LongLine
from console.scene.drawing.palette import BODY, GHOST, OTHER, POSE, TRAIL, TRIM, TYRE, Colour
from console.scene.drawing.shapes import arrow, place, rounded_disc, turned
from core.pilot.trail import NO_POINTS
from core.robots import Profile
from core.snapshot import Snapshot

WHEEL_RADIUS_M = 0.035
SIDEWAYS_WXYZ = (math.cos(math.pi / 4), math.sin(math.pi / 4), 0.0, 0.0)  # z turned onto y


class RobotBody:
    """As its URDF draws it, else a round body on two wheels, with its laser turret and its camera."""

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
            position = (0.0, side * min(robot.wheelbase / 2 + 0.034, robot.radius), WHEEL_RADIUS_M)
            for part, radius, width, colour in (("tyre", WHEEL_RADIUS_M, 0.018, TYRE), ("hub", 0.018, 0.021, BODY)):
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
    vertices, faces = turned(profile)
    scene.add_mesh_simple(name, vertices, faces, color=colour, side="double")


class TrailLine:
    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._line = LongLine(scene, "/trail", TRAIL, 2.4, 0.006)

    def show(self, snapshot: Snapshot) -> None:
        self._line.draw(snapshot.trail)


class DeadReckoningGhost:
    """The dead-reckoned pose, by the wheels alone, with its trail."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._frame = ghost(scene, "/ghost", robot.radius, GHOST, 0.28)
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


class OtherWayGhost:
    """The other way of a recording, with its trail: what is computed now over what was recorded."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._frame = ghost(scene, "/other", robot.radius, OTHER, 0.4)
        self._frame.visible = False
        self._trail = LongLine(scene, "/other_trail", OTHER, 1.8, 0.006)

    def show(self, snapshot: Snapshot) -> None:
        other = snapshot.other
        self._frame.visible = other is not None
        if other is not None:
            place(self._frame, other.pose)
        self._trail.draw(NO_POINTS if other is None else other.trail)


def ghost(scene: SceneApi, name: str, radius: float, colour: Colour, opacity: float) -> FrameHandle:
    """A translucent body of the robot's size → the frame that moves it."""
    frame = scene.add_frame(name, show_axes=False)
    vertices, faces = turned(rounded_disc(0.98 * radius, 0.014, 0.088, 0.018))
    scene.add_mesh_simple(
        f"{name}/body", vertices, faces, color=colour, opacity=opacity, cast_shadow=False, receive_shadow=False
    )
    return frame
