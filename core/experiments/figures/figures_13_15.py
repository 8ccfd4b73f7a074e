"""Figures 13 to 15: the pictures of the board, the corners found in two of them, the boards in the camera's frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from core.calibration.board.board import Board
from core.calibration.projection import Poses
from core.experiments.figures.drawing import TEXT, render
from core.message import Array
from core.optics import CameraModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CAPTURES_SIZE_PX, CORNERS_SIZE_PX = (1000, 760), (1240, 620)
PICTURE_COLUMNS = 5
BOARDS_PX = (1100, 780)
ELEVATION_DEG, AZIMUTH_DEG = 22.0, -38.0  # [deg] of the onlooker: behind, above and to the right of the camera
PYRAMID_M = 0.1  # from the camera to the base of its drawn pyramid
AXES_LENGTH = 0.16  # [m]
AXES_COLOURS = {"x": "#c02828", "y": "#288c28", "z": "#2850c8"}


def figure_13(pictures: Sequence[Array], conditions: str) -> bytes:
    """Pictures (H, W) uint8 side by side, numbered → a PNG file. Raises Unavailable without matplotlib."""

    def draw(figure: Figure) -> None:
        rows = -(-len(pictures) // PICTURE_COLUMNS)
        for number, picture in enumerate(pictures, start=1):
            axes = figure.add_subplot(rows, PICTURE_COLUMNS, number)
            _show(axes, picture)
            axes.set_title(f"{number}", fontsize=9, pad=3)
            axes.set_axis_off()

    return render("png", CAPTURES_SIZE_PX, f"Figure 13: {len(pictures)} pictures of the board", conditions, draw)


def figure_14(pictures: Sequence[Array], found: Sequence[Array], model: Sequence[Array], conditions: str) -> bytes:
    """Pictures (H, W) uint8, their corners found and projected by the model (N, 2) [px] → a PNG file.

    Raises Unavailable without matplotlib.
    """

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(2, len(pictures), height_ratios=(0.05, 1))
        for column, (picture, corners, projected) in enumerate(zip(pictures, found, model, strict=True)):
            axes = figure.add_subplot(grid[1, column])
            _show(axes, picture)
            axes.plot(*projected.T, "s", markersize=8, markerfacecolor="none", color="#1c9a3c", label="model")
            axes.plot(*corners.T, "+", markersize=6, color="#e02828", label="found")
            rms = float(np.sqrt(np.mean(np.sum((projected - corners) ** 2, axis=1))))
            axes.set_title(f"({'ab'[column]}) picture {column + 1}: rms distance {rms:.3f} px", loc="left")
            axes.set(xlabel="u [px]", ylabel="v [px]")
            axes.grid(visible=False)
        legend = figure.add_subplot(grid[0, :])
        legend.set_axis_off()
        legend.legend(*figure.axes[0].get_legend_handles_labels(), loc="center", ncols=2)

    return render(
        "png", CORNERS_SIZE_PX, "Figure 14: corners found, and where the camera model puts them", conditions, draw
    )


def _show(axes: Axes, picture: Array) -> None:
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255)


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

    return render("png", BOARDS_PX, "Figure 15: the boards in the camera’s frame", conditions, draw)


def _draw_boards(axes: Any, outlines: Array) -> None:
    """Outlines (K, 4, 3) [m], each in its colour and with its number at a corner."""
    from matplotlib import colormaps
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    colours = colormaps["turbo"](np.linspace(0.05, 0.95, len(outlines)))
    axes.add_collection3d(Poly3DCollection(_plotted(outlines), facecolors=colours, edgecolors=colours, alpha=0.3))
    for number, (corner, colour) in enumerate(zip(_plotted(outlines[:, 0]), colours, strict=True), start=1):
        axes.text(*corner, str(number), color=0.7 * colour[:3], fontsize=9, fontweight="bold")


def _draw_camera(axes: Any, model: CameraModel) -> None:
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
