"""The figure of what eyes and ears add: the error by place and sensors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from core.experiments.figures.drawing import render

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE_PX = (1240, 560)  # [px]
COLOURS = ("#435567", "#c8671b", "#0b7fb0", "#7a5ea8", "#2f8f5b")


def audio_visual_figure(places: Sequence[Any], runs: int) -> bytes:
    """Places with their rows → an SVG file. Raises Unavailable without matplotlib."""

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        names = list(places[0]["rows"])
        width = 0.8 / len(names)
        at = np.arange(len(places))
        for k, (name, colour) in enumerate(zip(names, COLOURS, strict=True)):
            mean, worst = (
                np.array([place["rows"][name][key] for place in places]) for key in ("mean_error_m", "worst_error_m")
            )
            reach = np.vstack((np.zeros(len(at)), worst - mean))
            axes.bar(at + width * (k - (len(names) - 1) / 2), mean, width, yerr=reach, color=colour, label=name)
        axes.set_xticks(at, [place["place"] for place in places], rotation=15)
        axes.set_yscale("log")
        axes.set_ylabel("mean position error [m]")
        axes.legend(ncols=len(names), loc="upper center")

    conditions = f"mean of {runs} drives; the line above a bar ends at the worst"
    return render("svg", SIZE_PX, "What eyes and ears add to the laser", conditions, draw)
