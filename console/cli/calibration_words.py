"""Calibrations for people who read a terminal: tables in the layout of Table 3, and sentences."""

import shutil
import textwrap
from collections.abc import Iterable

from core.calibration.board.board import Board
from core.calibration.reports import CameraFilesReport, CorrectedPictures, CorrectionReport, LaserFilesReport

SYMBOLS = {
    "fx": "f_u (pixels)",
    "fy": "f_v (pixels)",
    "cx": "u_0 (pixels)",
    "cy": "v_0 (pixels)",
    "k1": "k1(r)",
    "k2": "k2(r)",
    "p1": "k1(t)",
    "p2": "k2(t)",
    "k3": "k3(r)",
}
"""The chapter's letters."""
NOT_KNOWN = "not known"
MAX_COLUMNS = 110  # columns of text


def camera_lines(report: CameraFilesReport, board: Board) -> list[str]:
    width, height = report["image_size"]
    shown = report["views_used"] + len(report["views_refused"])
    known = report["uncertainty"]
    rows = [(symbol, report[name], report["sd"][name]) for name, symbol in SYMBOLS.items() if name in report["sd"]]
    remarks = [(view["image"], view["remark"]) for view in report["views"] if view["used"] and view["remark"]]
    return [
        f"Camera {width}x{height} from {report['views_used']} of {shown} pictures of {_board(board)}",
        "",
        *_table("Parameter", rows),
        "",
        f"RMS {report['rms_px']:.3f} px; 95 % of the picture is known to ±{known['p95_px']:.2f} px "
        f"(wanted {known['target_px']:.2f}).",
        _inverse_words(report["correction"]),
        *_equation_44(report),
        *_notes("Not used", ((each["image"], each["reason"]) for each in report["views_refused"])),
        *_notes("Remarks", remarks),
        *_ending(report),
    ]


def _equation_44(report: CameraFilesReport) -> list[str]:
    """The coefficients as eq. 44 has them, where the settings ask for that."""
    if "eq_44" not in report:
        return []
    form = report["eq_44"]
    values = ", ".join(f"{name} = {form[name]:.4g}" for name in ("k1", "k2", "p1", "p2"))
    return [f"As printed (eq. 44, f = {form['f_px']:.2f} px): {values}, so that k1(r) = f³ k1, k2(r) = f⁵ k2, …"]


def laser_lines(report: LaserFilesReport, board: Board) -> list[str]:
    """The report of a mount → lines. A value that is unknown, or measured beforehand, gets words, not a number."""
    used = report["poses_used"]
    values = [*report["turn_deg"], *report["translation_m"]]
    sds = [*report["sd_rotation_deg"], *report["sd_translation_m"]]
    units = ["degrees"] * 3 + ["metres"] * 3
    worded = report["from_ruler"] | dict.fromkeys(report["not_known"], NOT_KNOWN)
    rows: list[tuple[str, float | str, float]] = [
        (f"{name} ({unit})", worded.get(name, value), sd)
        for name, unit, value, sd in zip(report["axes"], units, values, sds, strict=True)
    ]
    if report["range_offset_m"] is not None:
        rows.append(("range offset (metres)", report["range_offset_m"]["value"], report["range_offset_m"]["sd"]))
    complete = not report["not_known"]
    return [
        f"Camera on the laser from {used} of {used + len(report['poses_refused'])} poses of {_board(board)}",
        "",
        *_table("P_laser = R P_camera + t", rows),
        "",
        *_wrapped(
            f"RMS {report['residual_rms_m'] * 1e3:.1f} mm. {report['laser_offset_words']} {report['square_words']}."
        ),
        *_notes("Not known", (("", each) for each in report["weak_directions"])),
        *_notes("Not used", ((each["image"], each["reason"]) for each in report["poses_refused"])),
        *_ending(report),
        *(["", report["static_transform"]] if complete else []),
    ]


def correction_lines(report: CorrectedPictures) -> list[str]:
    count = len(report["pictures"]) + len(report["pictures_refused"])
    way = "exactly" if report["method"] == "exact" else "by Table 1's inverse"
    return [
        f"{len(report['pictures'])} of {count} pictures straightened {way}.",
        _inverse_words(report["error"]),
        *_notes("Not used", ((each["image"], each["reason"]) for each in report["pictures_refused"])),
        *_notes("Warnings", (("", each) for each in report["warnings"])),
        *_notes("Files", ((each["image"], each["file"]) for each in report["pictures"])),
    ]


def _board(board: Board) -> str:
    article = "an" if board.columns in (8, 11, 18) else "a"
    return f"{article} {board.name} board with {board.square * 1e3:g} mm squares"


def _table(heading: str, rows: Iterable[tuple[str, float | str, float]]) -> list[str]:
    """Names, values and one standard deviation each, as Table 3 sets them."""
    lines = [f"{heading:<26}{'Value':>12}{'standard dev.':>16}"]
    for name, value, sd in rows:
        lines.append(f"{name:<26}{value:>12}" if isinstance(value, str) else f"{name:<26}{value:12.5f}{sd:16.5f}")
    return lines


def _inverse_words(error: CorrectionReport) -> str:
    table_1, exact = error["table_1"], error["exact"]
    return (
        f"Straightening: Table 1's inverse is off by {table_1['rms_px']:.3f} px RMS, {table_1['max_px']:.2f} px at "
        f"most; the exact way by {exact['max_px']:.1g} px."
    )


def _ending(report: CameraFilesReport | LaserFilesReport) -> list[str]:
    files = _notes("Files", report["files"].items())
    warnings = _notes("Warnings", (("", each) for each in report["warnings"]))
    return [*warnings, *(files or ["", "Nothing was saved; --out DIR keeps it."])]


def _notes(heading: str, notes: Iterable[tuple[str, str]]) -> list[str]:
    """A heading and under it names and sentences, wrapped; nothing where there is none."""
    every = list(notes)
    if not every:
        return []
    widest = max(len(name) for name, _ in every)
    lines = ["", heading]
    for name, words in every:
        lines += _wrapped(words, f"  {name:<{widest}}  " if widest else "  ")
    return lines


def _wrapped(words: str, start: str = "") -> list[str]:
    columns = max(60, min(MAX_COLUMNS, shutil.get_terminal_size((MAX_COLUMNS, 24)).columns))
    indent = " " * len(start)
    return textwrap.wrap(
        words, columns, initial_indent=start, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
