"""Figures 13 and 14: the pictures of the board, and the corners found in two of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from core.experiments.figures.drawing import render
from core.message import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CAPTURES, CORNERS = (1000, 760), (1240, 620)  # [px]
PICTURE_COLUMNS = 5


def figure_13(pictures: Sequence[Array], conditions: str) -> bytes:
    """Pictures (H, W) uint8 side by side, numbered → a PNG file. Raises Unavailable without matplotlib."""

    def draw(figure: Figure) -> None:
        rows = -(-len(pictures) // PICTURE_COLUMNS)
        for number, picture in enumerate(pictures, start=1):
            axes = figure.add_subplot(rows, PICTURE_COLUMNS, number)
            _show(axes, picture)
            axes.set_title(f"{number}", fontsize=9, pad=3)
            axes.set_axis_off()

    return render("png", CAPTURES, f"Figure 13: {len(pictures)} pictures of the board", conditions, draw)


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

    return render("png", CORNERS, "Figure 14: corners found, and where the camera model puts them", conditions, draw)


def _show(axes: Axes, picture: Array) -> None:
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255)
