"""Recordings: one reader per form of file, one shape for all of them."""

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from core.errors import BadInput
from core.recording import archives, carmen, json_scan, mcap_file, mrclam, ros1_bag, ros2_bag, victoria_park
from core.recording.npz import run_number
from core.recording.read_report import ReadReport
from core.recording.recording import (
    LogSettings,
    Recording,
    RecordingReport,
    ScanRecording,
    SightingRecording,
    SightingStep,
    logged_stamp,
)
from core.recording.ros import Envelope, RosMessages
from core.recording.sightings import Ids
from core.recording.source import TextLog, first_bytes, is_packed, unpacked_file

__all__ = [
    "Ids",
    "LogSettings",
    "Recording",
    "RecordingReport",
    "ScanRecording",
    "SightingRecording",
    "SightingStep",
    "logged_stamp",
    "open_log",
]

Messages = Callable[[Path, LogSettings, ReadReport], Iterator[Envelope]]

ROS_FORMS: dict[str, tuple[str, Messages]] = {
    ".mcap": ("MCAP", mcap_file.messages),
    ".bag": ("ROS 1 bag", ros1_bag.messages),
    ".db3": ("ROS 2 bag", ros2_bag.messages),
}
"""By the end of a file's name, for one that does not begin as any of them: it may be damaged there."""
MAGIC: dict[bytes, str] = {
    mcap_file.MAGIC: ".mcap",
    b"#ROSBAG V2.0": ".bag",
    b"SQLite format 3\0": ".db3",
    b"PK\x03\x04": ".npz",
}
"""How the forms begin; the name of a file may say anything: .bag.active, .db, nothing."""
AS_LOGGED = LogSettings()
MAX_PACKED = 3  # times that a file is packed
TAR = b"ustar"  # 257 bytes from the beginning
FORMS = ".mcap, .bag, .db3 and bag folders, CARMEN text, .jsonl, .npz, MRCLAM folders, Victoria Park text"


def open_log(
    path: str | Path,
    settings: LogSettings = AS_LOGGED,
    ids: Ids = "given",
    still: bool = False,
    *,
    whole: bool = False,
) -> Recording:
    """Read a log whole, whatever its form. Raises BadInput with a sentence when nothing in it can be used.

    `path` may end in `#number`: the run of an archive of runs, the robot of an MRCLAM folder. With ids "hidden" the
    identities in a sightings log are not shown; `still` takes in the still frames where a log has them;
    `whole`: the pictures of the first camera of a ROS log and its sound, too.
    """
    place, number, folder = _split(str(path))
    if folder:
        return _folder(place, number, ids, settings, whole=whole)
    with contextlib.ExitStack() as stack:
        content = place
        for _ in range(MAX_PACKED):
            if is_packed(content):
                content = stack.enter_context(unpacked_file(content, settings.largest_file))
        read = _file(content, number, ids, still, settings, whole=whole)
        return read if content == place else replace(read, path=place)


def ros_form(path: Path) -> tuple[str, Messages] | None:
    """The form of a file or folder of ROS messages, by how it begins or else by its name; None where it is none."""
    if path.is_dir():
        holds = any(each.suffix in (".db3", ".mcap") for each in path.iterdir())
        return ("ROS 2 bag", ros2_bag.folder_messages) if holds else None
    return ROS_FORMS.get(_form_of(path))


def _form_of(place: Path) -> str:
    head = first_bytes(place, 16)
    return next((form for magic, form in MAGIC.items() if head.startswith(magic)), place.suffix.lower())


def _file(place: Path, number: int | None, ids: Ids, still: bool, settings: LogSettings, *, whole: bool) -> Recording:
    suffix = _form_of(place)
    if suffix == ".npz":
        return archives.read(place, number, ids, still, settings)
    if number is not None:
        raise BadInput(f"{place.name} is one recording; leave out #{number}.")
    if suffix in ROS_FORMS:
        form, messages = ROS_FORMS[suffix]
        return _ros(place, form, messages, settings, whole=whole)
    return _text(place, ids, settings)


def _split(path: str) -> tuple[Path, int | None, bool]:
    before, mark, after = path.rpartition("#")
    try:
        if not mark or Path(path).exists():
            return Path(path), None, Path(path).is_dir()
        return Path(before), run_number(after, Path(before).name), Path(before).is_dir()
    except (OSError, ValueError) as problem:
        raise BadInput("The path of the log cannot be used on this machine.") from problem


def _folder(folder: Path, number: int | None, ids: Ids, settings: LogSettings, *, whole: bool) -> Recording:
    if any((folder / name).exists() for name in ("Barcodes.dat", "Barcodes.dat.gz")):
        return mrclam.read(folder, 1 if number is None else number, ids, settings)
    return _ros(folder, "ROS 2 bag", ros2_bag.folder_messages, settings, whole=whole)


def _ros(path: Path, form: str, messages: Messages, settings: LogSettings, *, whole: bool) -> ScanRecording:
    tally = ReadReport(path)
    collected = RosMessages(settings, tally, whole=whole)
    collected.take_all(messages(path, settings, tally))
    return collected.finish(path, form)


def _text(path: Path, ids: Ids, settings: LogSettings) -> Recording:
    """Read a text log; the first line that begins as a known form does decides which one it is."""
    begun, keys = False, set[str]()
    if first_bytes(path, 262).endswith(TAR):
        raise BadInput(f"{path.name} is an archive of files. Unpack it (tar -xf), and give the recording in it.")
    for number, line in TextLog(path, settings.largest_file):
        if "\0" in line:
            break
        if line.startswith("{") and not begun:
            return json_scan.read_json_lines(path, settings)
        begun = begun or bool(line)
        if line.split(maxsplit=1)[:1] in (["ODOMETRY"], ["LANDMARK"]):
            return victoria_park.read(path, ids, settings)
        if carmen.is_known(line):
            return carmen.read(path, settings)
        keys.add(line.partition(":")[0])
        if number >= 10_000:
            break
    if "rosbag2_bagfile_information" in keys:
        raise BadInput(f"{path.name} describes a bag folder. Give the folder it lies in.")
    if {"image", "resolution", "origin"} <= keys:
        raise BadInput(
            f"{path.name} is a map of Nav2, not a recording: there is nothing in it to estimate from. "
            "Give a recording of the drive."
        )
    raise BadInput(f"{path.name} is no known form of log. Known are: {FORMS}.")
