"""Table 3 reproduced: the paper's camera is calibrated from pictures of a rendered board (figures 13-15).

The paper does not give the picture's size; 320x256 is inferred from its principal point. Its last column was printed
by a toolbox that prints three standard deviations.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict

import numpy as np

from core.calibration.board.board import Board
from core.calibration.board.chessboard import find_board
from core.calibration.board.quality import judge
from core.calibration.camera.intrinsics import Calibration, ViewCorners, calibrate
from core.calibration.practice import held, picture
from core.calibration.projection import PARAMETERS, Poses
from core.errors import Unavailable
from core.experiments.drawing import TEXT, render
from core.experiments.plan import About, ChapterValue, ExperimentPlan, RunBatch
from core.experiments.result import BoardPoseFigures, ExperimentResult
from core.files import save_all
from core.message import Array
from core.optics import TABLE_3, CameraModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BOARD = Board(columns=9, rows=6, square=0.03)  # the paper's squares are 30 mm; it does not count them
VIEWS_PER_RUN = 20
SYMBOLS = ("f_u (pixels)", "f_v (pixels)", "u_0 (pixels)", "v_0 (pixels)", "k1(r)", "k2(r)", "k1(t)", "k2(t)")
PRINTED_SDS_3 = (1.71848, 1.57392, 1.18310, 1.82011, 0.00763, 0.01870, 0.00195, 0.00052)
"""The paper's column "standard dev.": three standard deviations."""

ABOUT = About(
    title="Table 3: the camera's intrinsics",
    reproduces="Table 3 and figures 13-15, from pictures of a rendered board by the chapter's camera.",
    runs=40,
    counts="calibrations",
    base_s=2.4,
    run_s=1.3,
    chapter=tuple(
        ChapterValue(name=symbol, value=getattr(TABLE_3, name), ours=f"table.{row}.value")
        for row, (symbol, name) in enumerate(zip(SYMBOLS, PARAMETERS, strict=False))
    ),
)

BY_CONSTRUCTION = (
    'by construction: the pictures are rendered through the paper\'s own camera, so the column "paper" is the truth'
    " that was put in; what is measured is how closely it comes back",
    "ours: the picture's size of 320×256 is inferred from the principal point, and the board has 9×6 corners;"
    " a standard deviation depends on the noise of our renderer, not on the paper's camera",
)
"""Facts that a reader of Table 3 must know; printed under it."""
CAPTURES_SIZE_PX, CORNERS_SIZE_PX = (1000, 760), (1240, 620)
PICTURE_COLUMNS = 5
BOARDS_PX = (1100, 780)
ELEVATION_DEG, AZIMUTH_DEG = 22.0, -38.0  # [deg] of the onlooker: behind, above and to the right of the camera
PYRAMID_M = 0.1  # from the camera to the base of its drawn pyramid
AXES_LENGTH_M = 0.16
AXES_COLOURS = {"x": "#c02828", "y": "#288c28", "z": "#2850c8"}


class Captured(NamedTuple):
    """The pictures that a person would have taken for one calibration."""

    pictures: list[Array]  # (H, W) uint8
    views: list[ViewCorners]
    shown: int  # boards that were shown until enough had been found


class Table3Row(TypedDict):
    """A row of Table 3, as JSON."""

    parameter: str
    value: float
    standard_dev: float  # three standard deviations, as the paper's
    paper_value: float
    paper_standard_dev: float


class Table3(ExperimentResult):
    """The result, as JSON."""

    runs: int
    views: int
    boards_found_share: float
    rms_px: float
    table: list[Table3Row]
    within_two_sds: dict[str, float]
    within_two_sds_pooled: float
    nees_mean: float  # of the eight parameters together, by their whole covariance; ideal 8
    mean_three_sds: dict[str, float]
    scatter: dict[str, float]
    f_u_within_printed_share: float


class CalibrationErrors(TypedDict):
    """One calibration, as JSON."""

    errors: dict[str, float]  # by parameter
    sds: dict[str, float]  # as the calibration states them
    nees: float
    boards_shown: int


def plan(*, runs: int | None = None, seed: int = 0) -> ExperimentPlan:
    """Plan `runs` calibrations (40) from 20 rendered pictures each → the first one's table and figures over all."""
    batch = RunBatch(partial(_work, seed), runs or ABOUT.runs, CalibrationErrors)
    return ExperimentPlan((batch,), partial(_result, seed))


def _work(seed: int, number: int) -> CalibrationErrors:
    calibration, captured = _calibrated(seed, number)
    errors = {name: getattr(calibration.model, name) - getattr(TABLE_3, name) for name in PARAMETERS[:8]}
    sds = {name: calibration.sds[name] for name in PARAMETERS[:8]}
    off = np.array([getattr(calibration.model, name) - getattr(TABLE_3, name) for name in calibration.free])
    nees = float(off @ np.linalg.solve(calibration.covariance, off))
    return {"errors": errors, "sds": sds, "nees": nees, "boards_shown": captured.shown}


@lru_cache(maxsize=1)
def _calibrated(seed: int, number: int) -> tuple[Calibration, Captured]:
    captured = capture(np.random.default_rng((seed, number)))
    return calibrate(captured.views, BOARD, (TABLE_3.width, TABLE_3.height)), captured


def _result(seed: int, out: Path | None, done: list[CalibrationErrors]) -> Table3:
    first = _calibrated(seed, 0)
    wanted, shown = len(done), sum(one["boards_shown"] for one in done)
    off = np.array([[one["errors"][name] for name in PARAMETERS[:8]] for one in done])
    stated = np.array([[one["sds"][name] for name in PARAMETERS[:8]] for one in done])
    within = np.abs(off) < 2 * stated
    result: Table3 = {
        "runs": wanted,
        "seed": seed,
        "views": VIEWS_PER_RUN,
        "boards_found_share": wanted * VIEWS_PER_RUN / shown,
        "rms_px": first[0].rms,
        "table": table(first[0]),
        "within_two_sds": dict(zip(PARAMETERS, within.mean(axis=0).tolist(), strict=False)),
        "within_two_sds_pooled": float(within.mean()),
        "nees_mean": float(np.mean([one["nees"] for one in done])),
        "mean_three_sds": dict(zip(PARAMETERS, (3 * stated.mean(axis=0)).tolist(), strict=False)),
        "scatter": dict(zip(PARAMETERS, off.std(axis=0).tolist(), strict=False)),
        "f_u_within_printed_share": float(np.mean(np.abs(off[:, 0]) <= PRINTED_SDS_3[0])),
        "text": "\n".join(layout(first[0])),
        "boards": boards(first[0]),
        "files": {},
    }
    if out is not None:
        result["files"] = save(out, result, *first)
    return result


def capture(rng: np.random.Generator) -> Captured:
    """Show the board until VIEWS pictures are fit to be used."""
    pictures: list[Array] = []
    views: list[ViewCorners] = []
    shown = 0
    while len(views) < VIEWS_PER_RUN:
        shown += 1
        grey = picture(rng, TABLE_3, held(rng, 1, TABLE_3, BOARD), BOARD)
        found = find_board(grey, BOARD)
        if found is not None and not judge(grey, found, BOARD).refusals:
            pictures.append(grey)
            views.append(ViewCorners(name=f"view {len(views) + 1}", corners=found.corners))
    return Captured(pictures, views, shown)


def table(calibration: Calibration) -> list[Table3Row]:
    """The rows of Table 3, ours next to the paper's."""
    return [
        {
            "parameter": symbol,
            "value": getattr(calibration.model, name),
            "standard_dev": 3 * calibration.sds[name],
            "paper_value": getattr(TABLE_3, name),
            "paper_standard_dev": printed,
        }
        for symbol, name, printed in zip(SYMBOLS, PARAMETERS, PRINTED_SDS_3, strict=False)
    ]


def layout(calibration: Calibration) -> list[str]:
    """Table 3 as the paper sets it; the column "standard dev." holds three standard deviations, as there."""
    lines = [f"{'Parameter':16}{'Value':>12}{'standard dev.':>16}{'paper':>14}{'its dev.':>10}"]
    for row in table(calibration):
        numbers = (row["value"], row["standard_dev"], row["paper_value"], row["paper_standard_dev"])
        lines.append("{:16}{:12.5f}{:16.5f}{:14.5f}{:10.5f}".format(row["parameter"], *numbers))
    return [*lines, "", *BY_CONSTRUCTION]


def boards(calibration: Calibration) -> list[BoardPoseFigures]:
    """Poses of the boards in the camera's frame: `rotation` 3x3 and `translation_m` [3]."""
    poses = calibration.poses.take(calibration.used)
    return [
        {"rotation": rotation.tolist(), "translation_m": translation.tolist()}
        for rotation, translation in zip(poses.rotations, poses.translations, strict=True)
    ]


def save(out: Path, result: Table3, calibration: Calibration, captured: Captured) -> dict[str, str]:
    """Figures 13 (pictures), 14 (corners) and 15 (boards about the camera) → what lies where. Raises Unwritable.

    Without matplotlib there are none, and the result says so under `not_drawn`.
    """
    conditions = (
        f"rendered chessboard {BOARD.name} of {BOARD.square:g} m squares  ·  camera of Table 3  ·  "
        f"{VIEWS_PER_RUN} pictures of {TABLE_3.width}×{TABLE_3.height} px  ·  "
        f"calibrated to {calibration.rms:.3f} px rms  ·  seed {result['seed']}, run 0"
    )
    found = [view.corners for view in captured.views[:2]]
    model = [corners + calibration.residuals[number] for number, corners in enumerate(found)]
    poses = calibration.poses.take(calibration.used)
    try:
        figures = {
            "figure_13": ("figure_13.png", figure_13(captured.pictures, conditions)),
            "figure_14": ("figure_14.png", figure_14(captured.pictures[:2], found, model, conditions)),
            "figure_15": ("figure_15.png", figure_15(poses, BOARD, TABLE_3, conditions)),
        }
    except Unavailable as missing:
        result["not_drawn"] = str(missing)
        return {}
    return save_all(out, figures)


def figure_13(pictures: Sequence[Array], conditions: str) -> bytes:
    """Pictures (H, W) uint8 side by side, numbered → a PNG file. Raises Unavailable without matplotlib."""

    def draw(figure: Figure) -> None:
        rows = -(-len(pictures) // PICTURE_COLUMNS)
        for number, pixels in enumerate(pictures, start=1):
            axes = figure.add_subplot(rows, PICTURE_COLUMNS, number)
            _show(axes, pixels)
            axes.set_title(f"{number}", fontsize=9, pad=3)
            axes.set_axis_off()

    return render("png", CAPTURES_SIZE_PX, f"Figure 13: {len(pictures)} pictures of the board", conditions, draw)


def figure_14(pictures: Sequence[Array], found: Sequence[Array], model: Sequence[Array], conditions: str) -> bytes:
    """Pictures (H, W) uint8, their corners found and projected by the model (N, 2) [px] → a PNG file.

    Raises Unavailable without matplotlib.
    """

    def draw(figure: Figure) -> None:
        grid = figure.add_gridspec(2, len(pictures), height_ratios=(0.05, 1))
        for column, (pixels, corners, projected) in enumerate(zip(pictures, found, model, strict=True)):
            axes = figure.add_subplot(grid[1, column])
            _show(axes, pixels)
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
    for axis, (name, colour) in zip(AXES_LENGTH_M * np.eye(3), AXES_COLOURS.items(), strict=True):
        axes.plot(*_plotted(np.stack((np.zeros(3), axis))).T, color=colour, linewidth=2)
        axes.text(*_plotted(1.15 * axis), name, color=colour, fontsize=11, fontweight="bold")


def _plotted(points: Array) -> Array:
    return points[..., [0, 2, 1]]
