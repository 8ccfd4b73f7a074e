"""Figure 15 to be turned in the hand: calibrated boards about their camera, as one file of viser's scene."""

import colorsys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import scipy

from console.scene.viser_host.mount import close_viser, open_viser
from core.calibration.board.board import Board
from core.message import Array

CAMERA_SIZE_M = 0.06  # of its drawn pyramid
AXES_LENGTH_M = 0.15
ONLOOKER = ((-0.5, -0.35, -0.3), (0.0, 0.0, 0.35))  # [m] where from and where to, in the camera's frame


def boards_html(boards: Sequence[Mapping[str, Any]], board: Board, fov: float, aspect: float) -> str:
    """Poses {rotation 3x3, translation_m [3]} of the board in the camera's frame → a page without anything outside.

    `fov` [rad] is the camera's angle of view from top to bottom, `aspect` its width over its height. Raises
    Unavailable when viser cannot be started.
    """
    server, _ = open_viser()
    try:
        scene = server.scene
        scene.set_up_direction((0.0, -1.0, 0.0))  # the camera's y looks down
        server.initial_camera.position, server.initial_camera.look_at = ONLOOKER
        scene.add_camera_frustum("/camera", fov=fov, aspect=aspect, scale=CAMERA_SIZE_M, color=(110, 110, 110))
        scene.add_frame(
            "/camera/axes", axes_length=AXES_LENGTH_M, axes_radius=0.03 * AXES_LENGTH_M, origin_radius=0.0
        )
        for number, pose in enumerate(boards):
            name, colour = f"/boards/{number + 1}", colour_of(number / len(boards))
            turn = scipy.spatial.transform.Rotation.from_matrix(np.array(pose["rotation"])).as_quat(scalar_first=True)
            scene.add_frame(name, wxyz=turn, position=np.array(pose["translation_m"]), show_axes=False)
            rim = np.array(board.outline, float)
            sides = np.stack((rim, np.roll(rim, -1, axis=0)), axis=1)
            scene.add_line_segments(f"{name}/rim", points=sides, colors=colour)
            corners, faces = dark_squares(board)
            scene.add_mesh_simple(f"{name}/squares", corners, faces, color=colour, side="double", opacity=0.6)
            scene.add_label(f"{name}/number", str(number + 1), position=tuple(rim.mean(axis=0)))
        return server.get_scene_serializer().as_html()
    finally:
        close_viser(server)


def dark_squares(board: Board) -> tuple[Array, Array]:
    """The dark squares of the print as vertices (V, 3) [m] in the board's frame and faces (F, 3)."""
    places = [(x, y) for x in range(-1, board.columns) for y in range(-1, board.rows) if (x + y) % 2 == 0]
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    corners = np.concatenate([(square + np.array([x, y, 0])) * board.square for x, y in places])
    first = 4 * np.arange(len(places))[:, None]
    return corners, np.concatenate((first + np.array([0, 1, 2]), first + np.array([0, 2, 3])))


def colour_of(share: float) -> tuple[int, int, int]:
    """A colour from red (0) to violet (1)."""
    red, green, blue = colorsys.hsv_to_rgb(0.97 * share, 0.75, 0.7)
    return int(255 * red), int(255 * green), int(255 * blue)
