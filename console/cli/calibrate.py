"""`beckon calibrate`: the camera from pictures, its place on the laser from pairs, the array from claps, a board."""

from __future__ import annotations

import argparse
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import add_command, add_out, add_out_file, answer, number, progress, write, write_json
from core.calibration.board.board import Board
from core.errors import BadInput, BadSettings

if TYPE_CHECKING:
    from core.pipelines.calibrate_microphones import OrientationFigures

SETTINGS = "only its [chapter] mode counts: printed solves and writes as the chapter does (eq. 13, eq. 44)"
MAX_HEIGHT_M = 2.0  # the camera above or below the laser
height = number(
    -MAX_HEIGHT_M,
    MAX_HEIGHT_M,
    f"Give the height of the camera above the laser in metres, between -{MAX_HEIGHT_M:g} and {MAX_HEIGHT_M:g}.",
)
angle = number(-360, 360, "Give angles in degrees with commas between them, as in 0,90,180,-90.")


def add(subcommands: Any) -> None:
    parser = subcommands.add_parser(
        "calibrate", help="the camera from pictures of a board, its place on the laser, the microphones from claps"
    )
    kinds = parser.add_subparsers(dest="kind", metavar="camera|laser|array|board", required=True)
    _add_camera(kinds)
    _add_laser(kinds)
    _add_array(kinds)
    _add_board_page(kinds)


def run_camera(chosen: argparse.Namespace) -> int:
    from console.cli.calibration_words import camera_lines
    from core.pipelines.calibrate import calibrate_camera
    from core.pipelines.calibrate_from_recording import calibrate_camera_recorded
    from core.recording.recorded_senses import is_recording

    board, recorded = board_from(chosen), len(chosen.images) == 1 and is_recording(chosen.images[0])
    if recorded and chosen.corners is not None:
        raise BadSettings("--corners marks pictures; a recording has none with names.")
    with progress() as shown:
        if recorded:
            report = calibrate_camera_recorded(chosen.images[0], board, chosen.out, shown, printed=is_printed(chosen))
        else:
            report = calibrate_camera(
                chosen.images, board, chosen.out, shown, printed=is_printed(chosen), corners=chosen.corners
            )
    return answer(chosen, report, *camera_lines(report, board), warnings=report["warnings"])


def run_laser(chosen: argparse.Namespace) -> int:
    from console.cli.calibration_words import laser_lines
    from core.pipelines.calibrate import calibrate_laser
    from core.pipelines.calibrate_from_recording import calibrate_laser_recorded
    from core.recording.recorded_senses import is_recording

    board = board_or_known(chosen, chosen.camera)
    solve = calibrate_laser_recorded if is_recording(chosen.folder) else calibrate_laser
    with progress() as shown:
        report = solve(
            chosen.folder,
            chosen.camera,
            board,
            chosen.out,
            height=chosen.height,
            with_offset=chosen.offset,
            progress=shown,
            printed=is_printed(chosen),
        )
    return answer(chosen, report, *laser_lines(report, board), warnings=report["warnings"])


def is_printed(chosen: argparse.Namespace) -> bool:
    """Return whether the settings ask for the chapter's own forms. Raises BadInput."""
    from core.settings import load

    return load(chosen.settings).chapter.mode == "printed"


def run_board_page(chosen: argparse.Namespace) -> int:
    """A page to print; the smallest that holds the board unless one was chosen."""
    from core.calibration.board.printing import board_svg, fitting_page, largest_square
    from core.files import save

    board = board_from(chosen)
    page = chosen.page or fitting_page(board)
    svg = board_svg(board, page)
    files = {} if chosen.out is None else {"svg": save(chosen.out, svg)}
    if chosen.json:
        write_json({"board": board.name, "square_m": board.square, "page": page, "svg": svg, "files": files})
    elif chosen.out is None:
        write(svg.rstrip("\n"))
    else:
        write(f"{chosen.out}: a {board.name} board of {board.square * 1e3:g} mm squares on {page}.")
        write("Print it at 100 %, check its rulers, glue it on something stiff and flat.")
        if page != "A4":
            write(f"For A4, {int(largest_square(board, 'A4'))} mm squares fit.")
    return 0


def _add_camera(kinds: Any) -> None:
    parser = add_command(kinds, "camera", run_camera, "intrinsic parameters from pictures of a board")
    parser.add_argument(
        "images",
        nargs="+",
        type=Path,
        metavar="IMAGE",
        help="pictures of the board, best 10 to 20; or one recording in which it is shown",
    )
    add_board(parser, required=True)
    parser.add_argument(
        "--corners",
        type=Path,
        metavar="FILE.json",
        help="the four extreme inner corners of pictures in which the board is not found, marked by hand: "
        '{"one.png": [[u, v], [u, v], [u, v], [u, v]]} in pixels, in any order (figure 3)',
    )
    parser.add_argument("--settings", type=Path, metavar="FILE.toml", help=SETTINGS)
    add_out(parser, "where the camera files go")


def _add_laser(kinds: Any) -> None:
    parser = add_command(
        kinds, "laser", run_laser, "where the camera sits on the laser, from pictures and scans of a board"
    )
    parser.add_argument(
        "folder",
        type=Path,
        metavar="FOLDER",
        help="images/ and beside it scans/ or lasers/; or a recording with both (MCAP, ROS bag)",
    )
    parser.add_argument("--camera", type=Path, required=True, metavar="CAMERA.json", help="the calibrated camera")
    add_board(parser, required=False)
    parser.add_argument(
        "--height",
        type=height,
        metavar="M",
        help="the camera above the laser by ruler [m], for boards that stand upright",
    )
    parser.add_argument("--offset", action="store_true", help="also estimate a constant error of the laser's ranges")
    parser.add_argument("--settings", type=Path, metavar="FILE.toml", help=SETTINGS)
    add_out(parser, "where the mount's files go")


def _add_board_page(kinds: Any) -> None:
    parser = add_command(kinds, "board", run_board_page, "a board to print, as SVG in real size")
    add_board(parser, required=True)
    parser.add_argument(
        "--page", choices=("A4", "letter", "A3"), help="the smallest of these that fits, unless chosen"
    )
    add_out_file(parser, "FILE.svg", "without it: standard output")


SIDES_DEG = (0.0, 90.0, 180.0, -90.0)  # [deg]


def _add_array(kinds: Any) -> None:
    parser = add_command(
        kinds,
        "array",
        run_array,
        "how the microphones are turned on the robot, from claps or words of known direction",
    )
    parser.add_argument(
        "sounds", nargs="+", type=Path, metavar="SOUND", help="one recording a direction, WAV, FLAC or Ogg"
    )
    parser.add_argument("--array", required=True, metavar="ARRAY.toml", help="a profile or the name of a known board")
    parser.add_argument(
        "--azimuths",
        type=degrees,
        default=",".join(f"{side:g}" for side in SIDES_DEG),
        metavar="DEG,DEG,…",
        help="where each was recorded from, 0 ahead and 90 left (default 0,90,180,-90)",
    )
    add_out(parser, "where the turned profile goes")


def run_array(chosen: argparse.Namespace) -> int:
    from core.pipelines.calibrate_microphones import TURNED_PROFILE, calibrate_array  # scipy takes a moment
    from core.sensors.microphones import load_array

    profile, turned = Path(chosen.array), None if chosen.out is None else chosen.out / TURNED_PROFILE
    if turned is not None and profile.exists() and turned.exists() and turned.samefile(profile):
        raise BadInput(f"The turned profile would take the place of {profile}; give another folder with --out.")
    azimuths = [math.radians(azimuth) for azimuth in chosen.azimuths]
    with progress() as shown:
        report = calibrate_array(chosen.sounds, azimuths, load_array(chosen.array), chosen.out, progress=shown)
    return answer(chosen, report, *array_lines(report), warnings=report["warnings"])


def array_lines(report: OrientationFigures) -> list[str]:
    yaw, doubt = math.degrees(report["yaw_rad"]), math.degrees(2 * report["sd_yaw_rad"])
    down = ", and hangs upside down" if report["mirrored"] else ""
    found = [f"The array is turned by {yaw:.1f}° ± {doubt:.1f}° (95 %){down}."]
    for one in report["claps"]:
        asked, heard, gap = map(math.degrees, (one["asked_rad"], one["heard_rad"], one["gap_rad"]))
        found.append(
            f"  {one['sound']}: from {asked:.0f}°, heard at {heard:.1f}° of the array, misses by {gap:+.1f}°"
        )
    found += [f"  {one['sound']} is left out: {one['reason']}" for one in report["claps_refused"]]
    return found + [f"note: {warning}" for warning in report["warnings"]] + list(report["files"].values())


def degrees(text: str) -> list[float]:
    """'0,90' → angles [deg]."""
    return [angle(part) for part in text.split(",")]


# `--board 9x6 --square 0.025 --panel 0.34x0.25` of a command line → a board.


def add_board(parser: argparse.ArgumentParser, *, required: bool) -> None:
    """Give a subcommand `--board`, `--square` and `--panel`, and its own way to complain about them."""
    parser.add_argument(
        "--board",
        type=corner_counts,
        required=required,
        metavar="9x6",
        help="inner corners in a row x rows: the points where four squares meet",
    )
    parser.add_argument(
        "--square", type=side, required=required, metavar="METRES", help="side of one square, as in 0.025"
    )
    parser.add_argument(
        "--panel",
        type=panel_size,
        metavar="WxH",
        help="the stiff panel that carries the print, in metres; the laser sees the panel",
    )
    parser.set_defaults(wrong_usage=parser.error)


def corner_counts(text: str) -> tuple[int, int]:
    """'9x6' → columns and rows."""
    try:
        board = Board.parse(text, square=0.025)
    except BadInput as wrong:
        raise argparse.ArgumentTypeError(str(wrong)) from None
    return board.columns, board.rows


def side(text: str) -> float:
    """'0.025' → the side of a square [m]."""
    try:
        return Board(columns=3, rows=3, square=float(text)).square
    except ValueError:
        raise argparse.ArgumentTypeError("Give the side of a square in metres, as in 0.025.") from None
    except BadInput as wrong:
        raise argparse.ArgumentTypeError(str(wrong)) from None


def panel_size(text: str) -> tuple[float, float]:
    """'0.34x0.25' → width and height [m]."""
    found = re.fullmatch(r"\s*(\d*\.?\d+)\s*[xX×]\s*(\d*\.?\d+)\s*", text, re.ASCII)
    if found is None or not all(0 < float(each) <= 10 for each in found.groups()):
        raise argparse.ArgumentTypeError("Write the panel as width x height in metres, as in 0.34x0.25.")
    return float(found[1]), float(found[2])


def board_from(chosen: argparse.Namespace) -> Board:
    return _assembled(chosen, chosen.board, chosen.square, chosen.panel)


def board_or_known(chosen: argparse.Namespace, camera: Path) -> Board:
    """The board as described, completed by what the camera file says. Raises BadInput where neither says it all."""
    if chosen.board is not None and chosen.square is not None:
        return board_from(chosen)
    from core.calibration.files.camera_files import read_camera  # OpenCV and scipy take a moment: only where needed
    from core.pipelines.calibrate import board_in

    read_camera(camera)
    known = board_in(camera)
    counts = chosen.board or (known.columns, known.rows)
    return _assembled(chosen, counts, chosen.square or known.square, chosen.panel or known.panel)


def _assembled(
    chosen: argparse.Namespace, counts: tuple[int, int], square: float, panel: tuple[float, float] | None
) -> Board:
    try:
        return Board(columns=counts[0], rows=counts[1], square=square, panel=panel)
    except BadInput as wrong:
        chosen.wrong_usage(str(wrong))
        raise
