"""The robot's own map and pose, as its own navigation has them: ochre, and never mixed with Beckon's own map."""

import itertools
from collections.abc import Callable

import numpy as np
from viser import ImageHandle, SceneApi

from console.control.own_navigation import DecodedMap, OwnMapView
from console.scene.drawing.palette import OWN_MAP
from console.scene.drawing.shapes import arrow, place
from core.message import Array
from core.robots import Profile
from core.snapshot import Snapshot

HEIGHT_M = -0.008  # [m], under Beckon's own map
OCCUPIED_LEVEL, FREE_LEVEL = 50, 25  # of 0..100, as Nav2 has them: above is a wall, below is floor
WALL_OPACITY, FLOOR_OPACITY = 200, 40


class RobotsOwnMap:
    """A picture on the floor with a label, and an arrow for the pose; nothing at all for most robots."""

    def __init__(self, scene: SceneApi, robot: Profile, newest: Callable[[], OwnMapView | None]) -> None:
        """`newest`: the map while it is shown, from any thread."""
        self._scene, self._newest = scene, newest
        self._radius = robot.radius
        self._frame = scene.add_frame("/own_map", show_axes=False, visible=False)
        vertices, faces = arrow(1.2 * robot.radius, robot.radius)
        self._arrow = scene.add_mesh_simple("/own_pose", vertices, faces, color=OWN_MAP, side="double", visible=False)
        self._numbers = itertools.count(1)
        self._label = scene.add_label("/own_map/label", "Robot's own map", visible=False)
        self._image: ImageHandle | None = None
        self._shown = 0  # number of the map that is drawn

    def show(self, snapshot: Snapshot) -> None:
        """Draw what is newest, whatever the snapshot."""
        view = self._newest()
        self._frame.visible = self._label.visible = view is not None
        self._arrow.visible = view is not None and view.robot is not None
        if view is None:
            return
        if view.map.number != self._shown:
            self._shown = view.map.number
            self._draw(view.map)
        self._label.text = "Robot's own map" if view.aligned else "Robot's own map (place not known)"
        place(self._frame, view.corner)
        if view.robot is not None:
            place(self._arrow, view.robot, 0.1)

    def _draw(self, view: DecodedMap) -> None:
        if self._image is not None:
            self._image.remove()
        self._image = self._scene.add_image(
            f"/own_map/{next(self._numbers)}",
            paint(view.cells),
            render_width=view.width,
            render_height=view.height,
            format="png",
            wxyz=(0.0, 1.0, 0.0, 0.0),
            position=(view.width / 2, view.height / 2, HEIGHT_M),
            cast_shadow=False,
            receive_shadow=False,
        )
        self._label.position = (0.0, view.height, 0.2)


def paint(cells: Array) -> Array:
    """Cells (H, W) uint8 → picture (H, W, 4) uint8; unknown ones are transparent."""
    picture = np.zeros((*cells.shape, 4), np.uint8)
    picture[..., :3] = OWN_MAP
    picture[..., 3] = np.where(
        cells > OCCUPIED_LEVEL + 1, WALL_OPACITY, np.where((cells > 0) & (cells <= FREE_LEVEL + 1), FLOOR_OPACITY, 0)
    )
    return picture
