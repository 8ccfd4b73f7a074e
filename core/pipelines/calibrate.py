"""Calibrate from files: what the command line does."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

import msgspec
import numpy as np

from core.calibration import reports
from core.calibration.board.board import Board
from core.calibration.board.chessboard import board_by_hand, find_board
from core.calibration.board.quality import BoardNotSeen, judge, miscount_words, why_none
from core.calibration.camera.intrinsics import ViewCorners, calibrate
from core.calibration.exports import camera_exports, laser_exports
from core.calibration.files.camera_files import read_camera, read_json
from core.calibration.files.pictures import own_names, read_grey, size_words
from core.calibration.files.scan_files import read_scans
from core.calibration.laser import solve, suspicion
from core.calibration.laser.board_line import MeanScan, average
from core.calibration.laser.planes import BoardPose, board_pose
from core.calibration.laser.range_lines import unit_rays
from core.calibration.laser.solve import LaserPose
from core.calibration.laser.suspicion import Rival
from core.calibration.mount import Mount
from core.calibration.printed import equation_44
from core.errors import BadInput
from core.files import save_all, text_of
from core.message import Array
from core.optics import CameraModel
from core.progress import UNSEEN, WorkProgress
from core.sensors.camera import lens_faults
from core.sensors.checks import Fault, UnusableReading, fault, faults_of, found_faults, refusal

PICTURES = {".jpg", ".jpeg", ".png", ".bmp", ".webp", ".pgm", ".ppm"}
SCANS = {".pcd", ".csv"}
MOST_FILES = 2000
NUMBER, WORDS = re.compile(r"\d+"), re.compile(r"(\D*)(\d*)")
Pixel = tuple[float, float]
MarkedCorners = Annotated[list[Pixel], msgspec.Meta(min_length=4, max_length=4)]
SHIFT_PLACES = (-3, -2, -1, 1, 2, 3)  # places by which a list of scans may be off against the pictures


def calibrate_camera(
    files: Sequence[Path],
    board: Board,
    out: Path | None = None,
    progress: WorkProgress = UNSEEN,
    *,
    printed: bool = False,
    corners: Path | None = None,
) -> reports.CameraFilesReport:
    """Pictures of a board → the camera as JSON keys; with `out`, files in every form.

    `printed`: with eq. 44's coefficients. `corners`: a file of extreme corners that were marked by hand. Raises
    BadInput when fewer than three pictures can be used.
    """
    marked = {} if corners is None else marked_corners(corners, [path.name for path in files])
    return camera_from(_views(files, board, progress, marked), len(files), board, out, printed=printed)


def marked_corners(path: Path, pictures: Collection[str]) -> dict[str, Array]:
    """Read `{"picture.png": [[u, v], [u, v], [u, v], [u, v]]}` [pixel] → (4, 2) by picture. Raises BadInput."""
    try:
        read = msgspec.json.decode(text_of(path.read_bytes(), path.name), type=dict[str, MarkedCorners])
    except msgspec.MsgspecError as wrong:
        raise BadInput(
            f'{path.name} should hold the four extreme corners of every picture that was marked, as {{"one.png": '
            f"[[u, v], [u, v], [u, v], [u, v]]}} in pixels ({wrong})."
        ) from None
    strange = sorted(read.keys() - set(pictures))
    if strange:
        raise BadInput(f"{path.name} has corners of {strange[0]}, which is not among the pictures.")
    return {name: np.array(one, float) for name, one in read.items()}


def camera_from(
    looked: LookedAtViews, count: int, board: Board, out: Path | None = None, *, printed: bool = False
) -> reports.CameraFilesReport:
    """Views from any source, of `count` pictures → JSON keys and files. Raises BadInput."""
    views, refused = looked.views, looked.refused
    if len(views) < 3:
        seen = Counter(each["seen"] for each in refused if "seen" in each)
        if seen and 2 * max(seen.values()) >= count:
            name, times = seen.most_common(1)[0]
            what = miscount_words(Board.parse(name, board.square), board)
            raise refusal("board.use_other", seen=name, entered=board.name, count=times, all=count, what=what)
        raise UnusableReading(_too_few(len(views), count, "pictures", refused), looked.faults)
    calibration = calibrate(views, board, looked.size)
    if calibration.undecided:
        raise UnusableReading(calibration.undecided, (*calibration.faults, *looked.faults))
    report = reports.camera_report(calibration)
    dropped: list[reports.RefusedPicture] = [
        {"image": each.name, "reason": each.reason} for each in calibration.verdicts if not each.used
    ]
    answer: reports.CameraFilesReport = {
        **report,
        "faults": report["faults"] + found_faults(looked.faults),
        "warnings": looked.warnings + report["warnings"],
        "views_refused": refused + dropped,
        "correction": reports.correction_report(calibration.model),
        "files": {} if out is None else save_all(out, camera_exports(calibration, report)),
    }
    if printed:
        answer["eq_44"] = equation_44(calibration.model)
    return answer


def calibrate_laser(
    folder: Path,
    camera: Path,
    board: Board | None = None,
    out: Path | None = None,
    *,
    height: float | None = None,
    with_offset: bool = False,
    progress: WorkProgress = UNSEEN,
    printed: bool = False,
) -> reports.LaserFilesReport:
    """A folder of picture-and-scan pairs and a camera file → the mount as JSON keys; with `out`, files.

    `board` defaults to the one in the camera file. `height` [m] of the camera above the laser, measured by ruler,
    chooses the mode for upright boards. `printed`: by eq. 13. Raises BadInput.
    """
    model = read_camera(camera)
    board = board or board_in(camera)
    pairs, refused, background = _pairs(folder)
    seen: list[tuple[int, BoardPose]] = []
    scanned: list[MeanScan | None] = []
    faults: list[Fault] = [*lens_faults(camera.name, model)]
    for number, (picture, scans) in enumerate(progress.each(pairs, "looking for the board")):
        try:
            bearings, ranges = read_scans(scans)
            scanned.append(average(ranges, unit_rays(bearings)))
        except BadInput as wrong:
            scanned.append(None)
            refused.append({"image": picture.name, "reason": str(wrong)})
            faults += faults_of(wrong) or [fault("scan.malformed", scans.name, what=str(wrong).rstrip("."))]
            continue
        try:
            seen.append((number, _board_pose(read_grey(picture)[0], board, model)))
        except BadInput as wrong:
            refused.append({"image": picture.name, "reason": str(wrong)})
            faults += faults_of(wrong, picture.name)
    names = [picture.name for picture, _ in pairs]
    poses = _paired(seen, names, scanned)
    empty = None if background is None or not poses else _background(background, poses)
    mount = None if height is None else Mount.measured(height)
    return mount_from(
        poses,
        refused,
        board,
        model,
        empty,
        rivals=_other_pairings(seen, names, scanned, empty),
        faults=faults,
        mount=mount,
        with_offset=with_offset,
        out=out,
        printed=printed,
    )


def _paired(
    seen: Sequence[tuple[int, BoardPose]], names: Sequence[str], scanned: Sequence[MeanScan | None]
) -> list[LaserPose]:
    """Boards seen in pictures, by number, with the scans (None: unreadable) of the same number."""
    return [
        LaserPose(name=names[number], board=pose, scan=scan)
        for number, pose in seen
        if (scan := scanned[number]) is not None
    ]


def _other_pairings(
    seen: Sequence[tuple[int, BoardPose]],
    names: Sequence[str],
    scanned: Sequence[MeanScan | None],
    background: Array | None,
) -> list[Rival]:
    """The same pictures with other scans: some earlier or later, or in reverse order."""
    every = list(scanned)
    shifted = [
        (f"{abs(shift)} {'later' if shift > 0 else 'earlier'} in the list", every[shift:] + every[:shift])
        for shift in SHIFT_PLACES
        if abs(shift) < len(every) - 2
    ]
    return [
        Rival("laser.other_pairing", what, tuple(_paired(seen, names, scans)), background)
        for what, scans in (*shifted, ("at the same place from the end", every[::-1]))
    ]


def _board_pose(grey: Array, board: Board, model: CameraModel) -> BoardPose:
    """A picture (H, W) of a board → its pose. Raises BadInput."""
    if grey.shape != (model.height, model.width):
        raise BadInput(f"it is {size_words(grey)}, the camera file is for {model.width}x{model.height}")
    return board_pose(model, board, _corners(grey, board)[0])


def mount_from(
    poses: Sequence[LaserPose],
    refused: Sequence[reports.RefusedPicture],
    board: Board,
    model: CameraModel,
    background: Array | None = None,
    *,
    rivals: Sequence[Rival] = (),
    faults: Sequence[Fault] = (),
    mount: Mount | None = None,
    with_offset: bool = False,
    out: Path | None = None,
    printed: bool = False,
) -> reports.LaserFilesReport:
    """Poses from any source, the pairs refused so far, the empty room (B,) [m] → JSON keys and files.

    `rivals`: other ways in which the scans may belong to the boards; `faults`: of the camera file and of the refused
    pairs. Raises BadInput, with the cause where one of the rivals, or another unit or sense of the scans, explains
    the poses far better.
    """
    if len(poses) < 3:
        count = len(poses) + len(refused)
        raise UnusableReading(_too_few(len(poses), count, "pairs", refused), faults)
    found, trouble = None, ""
    try:
        found = solve.calibrate_laser(poses, board, background, mount, with_offset=with_offset, printed=printed)
    except BadInput as wrong:
        trouble = str(wrong)
    doubt = suspicion.doubt_of(found, poses, rivals, board, background, mount)
    if doubt is not None:
        raise doubt
    if found is None:
        raise BadInput(trouble)
    report = reports.laser_report(found, [pose.name for pose in poses], board, model)
    return {
        **report,
        "poses_refused": [*refused, *report["poses_refused"]],
        "faults": found_faults(faults),
        "warnings": [*(one.sentence for one in faults if one.used), *report["warnings"]],
        "files": {} if out is None else save_all(out, laser_exports(found, board, model)),
    }


def _too_few(used: int, count: int, what: str, refused: Sequence[reports.RefusedPicture]) -> str:
    reasons = "; ".join(f"{each['image']}: {each['reason']}" for each in refused[:3])
    return f"Only {used} of {count} {what} can be used; at least 3 are needed. {reasons}".strip()


def board_in(camera: Path) -> Board:
    """The board that stands in our own camera file. Raises BadInput where there is none."""
    text = text_of(camera.read_bytes(), camera.name)
    entry = read_json(text).get("board") if text.lstrip().startswith("{") else None
    try:
        columns, rows = entry["inner_corners"]  # type: ignore[index]
        panel = entry.get("panel_m")  # type: ignore[union-attr]
        return Board(
            columns=int(columns),
            rows=int(rows),
            square=float(entry["square_m"]),  # type: ignore[index]
            panel=None if panel is None else (float(panel[0]), float(panel[1])),
        )
    except (TypeError, KeyError, ValueError):
        raise BadInput(
            'The camera file does not say which board was used; give it, as in "9x6" and 0.025 m.'
        ) from None


class LookedAtViews(NamedTuple):
    """The outcome of all pictures."""

    views: list[ViewCorners]
    refused: list[reports.RefusedPicture]
    faults: tuple[Fault, ...]
    warnings: list[str]
    size: tuple[int, int]  # [pixel] that most have


def _views(files: Sequence[Path], board: Board, progress: WorkProgress, marked: Mapping[str, Array]) -> LookedAtViews:
    """Look at every picture; the extreme corners of some are marked by hand."""
    if len(files) > MOST_FILES:
        raise BadInput(f"{len(files)} pictures are too many; at most {MOST_FILES} are read at once.")
    found: list[tuple[ViewCorners, tuple[int, int]]] = []
    refused: list[reports.RefusedPicture] = []
    faults: list[Fault] = []
    warnings: list[str] = []
    twins: dict[bytes, str] = {}
    for name, path in progress.each(list(zip(own_names(files), files, strict=True)), "looking for the board"):
        try:
            grey, remark = read_grey(path)
            corners, remarks = _corners(grey, board, marked.get(path.name))
            if (twin := twins.get(corners.tobytes())) is not None:
                raise BadInput(f"it is the same picture as {twin}; every picture counts once")
            twins[corners.tobytes()] = name
        except BadInput as wrong:
            progress.tell(f"{name}: {wrong}")
            refused.append({"image": name, "reason": str(wrong)})
            faults += faults_of(wrong, name)
            if isinstance(wrong, BoardNotSeen) and wrong.seen:
                refused[-1]["seen"] = wrong.seen
            continue
        found.append((ViewCorners(name=name, corners=corners), (grey.shape[1], grey.shape[0])))
        warnings += [f"{name}: {each}" for each in (remark, *remarks) if each]
    if not found:
        return LookedAtViews([], refused, tuple(faults), warnings, (0, 0))
    counts = Counter(each for _, each in found)
    size = max(counts, key=lambda each: (counts[each], each[0] * each[1]))
    for view, own in found:
        if own != size:
            many = "most" if counts[size] > counts[own] else "as many"
            reason = f"it is {own[0]}x{own[1]}, {many} pictures are {size[0]}x{size[1]}; one camera setting at a time"
            refused.append({"image": view.name, "reason": reason})
    return LookedAtViews([view for view, own in found if own == size], refused, tuple(faults), warnings, size)


def _corners(grey: Array, board: Board, extreme: Array | None = None) -> tuple[Array, tuple[str, ...]]:
    """A grey picture, perhaps with four corners marked by hand → corners (N, 2) and remarks.

    Raises BadInput with the reason to refuse it.
    """
    view = find_board(grey, board) if extreme is None else board_by_hand(grey, board, extreme)
    if view is None:
        raise why_none(grey, board)
    quality = judge(grey, view, board)
    if quality.refusals:
        raise BadInput(quality.refusals[0])
    return view.corners, quality.warnings


def _pairs(folder: Path) -> tuple[list[tuple[Path, Path]], list[reports.RefusedPicture], Path | None]:
    """images/ next to scans/ or lasers/ → pairs, pictures without a scan, and a file named background, if any.

    Files pair by the number in their names where one folder has all numbers of the other, else in natural order.
    """
    if not folder.is_dir():
        raise BadInput(f"There is no folder {folder}.")
    if not (folder / "images").is_dir():
        raise BadInput(f"{folder.name} needs a folder images/ and next to it scans/ or lasers/.")
    pictures = sorted_by_number(path for path in (folder / "images").iterdir() if path.suffix.lower() in PICTURES)
    places = [folder / name for name in ("scans", "lasers") if (folder / name).is_dir()]
    scans = sorted_by_number(path for place in places for path in place.iterdir() if path.suffix.lower() in SCANS)
    background = next((path for path in (*scans, *folder.glob("background.*")) if path.stem == "background"), None)
    scans = [path for path in scans if path.stem != "background"]
    own, theirs = _numbered(pictures), _numbered(scans)
    common = [number for number in own if number in theirs]
    if common and len(common) == min(len(pictures), len(scans)):
        refused: list[reports.RefusedPicture] = [
            {"image": path.name, "reason": "no scan has its number"}
            for number, path in own.items()
            if number not in theirs
        ]
        return [(own[number], theirs[number]) for number in common], refused, background
    if not pictures or len(pictures) != len(scans):
        raise BadInput(
            f"{folder.name} has {len(pictures)} pictures and {len(scans)} scans; they must pair up one to one."
        )
    return list(zip(pictures, scans, strict=True)), [], background


def sorted_by_number(files: Iterable[Path]) -> list[Path]:
    """Files in natural order: img2 before img10."""
    return sorted(
        files, key=lambda path: ([(word, int(digits or 0)) for word, digits in WORDS.findall(path.stem)], path.name)
    )


def _numbered(files: Sequence[Path]) -> dict[int, Path]:
    """Files by the last number in their names; empty where one has none or two have the same."""
    numbers = [NUMBER.findall(path.stem) for path in files]
    found = {int(each[-1]): path for each, path in zip(numbers, files, strict=True) if each}
    return found if len(found) == len(files) else {}


def _background(path: Path, poses: Sequence[LaserPose]) -> Array:
    """The empty room (B,) [m] on the beams of the poses."""
    bearings, ranges = read_scans(path)
    scan = average(ranges, unit_rays(bearings))
    if any(pose.scan.rays.shape != scan.rays.shape for pose in poses):
        raise BadInput("The background scan has other beams than the scans; record it with the same settings.")
    return scan.ranges
