"""Figure 15: the calibrated boards in the camera's frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from core.calibration.board.board import Board
from core.calibration.projection import Poses
from core.experiments.figures.drawing import TEXT, render
from core.message import Array
from core.optics import CameraModel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE_PX = (1100, 780)  # [px]
ELEVATION_DEG, AZIMUTH_DEG = 22.0, -38.0  # [deg] of the onlooker: behind, above and to the right of the camera
PYRAMID_M = 0.1  # from the camera to the base of its drawn pyramid
AXES_LENGTH = 0.16  # [m]
AXES_COLOURS = {"x": "#c02828", "y": "#288c28", "z": "#2850c8"}


def figure_15(poses: Poses, board: Board, model: CameraModel, conditions: str) -> bytes:
    """Boards (K) and the camera's view as a pyramid → a PNG file. Raises Unavailable without matplotlib."""
    outlines = board.outline @ np.swapaxes(poses.rotations, 1, 2) + poses.translations[:, None]

    def draw(figure: Figure) -> None:
        axes: Any = figure.add_subplot(projection="3d")  # its class has no types
        _draw_boards(axes, outlines)
        _draw_camera(axes, model)
        axes.set(xlabel="x, right [m]", ylabel="z, forward [m]", zlabel="y, down [m]")
        axes.invert_zaxis()
        axes.set_box_aspect(
            [abs(high - low) for low, high in (axes.get_xlim(), axes.get_ylim(), axes.get_zlim())], zoom=1.15
        )
        axes.view_init(ELEVATION_DEG, AZIMUTH_DEG)

    return render("png", SIZE_PX, "Figure 15: the boards in the camera’s frame", conditions, draw)


def _draw_boards(axes: Any, outlines: Array) -> None:
    """Outlines (K, 4, 3) [m], each in its colour and with its number at a corner."""
    from matplotlib import colormaps
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    colours = colormaps["turbo"](np.linspace(0.05, 0.95, len(outlines)))
    axes.add_collection3d(Poly3DCollection(_plotted(outlines), facecolors=colours, edgecolors=colours, alpha=0.3))
    for number, (corner, colour) in enumerate(zip(_plotted(outlines[:, 0]), colours, strict=True), start=1):
        axes.text(*corner, str(number), color=0.7 * colour[:3], fontsize=9, fontweight="bold")


def _draw_camera(axes: Any, model: CameraModel) -> None:
    """The camera's view as a pyramid, and its axes."""
    half = np.array([model.width / model.fx, model.height / model.fy]) / 2 * PYRAMID_M
    base = np.array([[x * half[0], y * half[1], PYRAMID_M] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    for corner, following in zip(base, np.roll(base, -1, axis=0), strict=True):
        axes.plot(*_plotted(np.stack((np.zeros(3), corner, following))).T, color=TEXT, linewidth=1)
    for axis, (name, colour) in zip(AXES_LENGTH * np.eye(3), AXES_COLOURS.items(), strict=True):
        axes.plot(*_plotted(np.stack((np.zeros(3), axis))).T, color=colour, linewidth=2)
        axes.text(*_plotted(1.15 * axis), name, color=colour, fontsize=11, fontweight="bold")


def _plotted(points: Array) -> Array:
    """Points (…, 3) of the camera's frame → in the order of the drawing's axes: right, forward, down."""
    return points[..., [0, 2, 1]]
