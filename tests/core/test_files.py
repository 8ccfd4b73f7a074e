"""Files that must last: whole or not at all, on the disk before it is said, and a disk that refuses is told."""

import errno
import os
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from console.cli.speech_quality import read_text
from core.calibration.files.camera_files import read_camera
from core.errors import BadInput, Unwritable
from core.files import (
    SEAL,
    UNFINISHED,
    check_file,
    check_folder,
    is_intact,
    remove_unfinished,
    replacing,
    saving,
    sealed,
    write_atomic,
)
from core.pipelines.calibrate import marked_corners
from core.pipelines.look import read_questions
from core.robots.robot_file import load_robot_file
from core.robots.urdf import load_body
from core.sensors.microphones import load_array
from core.settings import load
from core.speech.understanding.own_phrases import own_phrases


def calls(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is asked of the disk, in order."""
    told: list[str] = []
    sync, replace = os.fsync, Path.replace

    def note(file: int) -> None:
        told.append("sync folder" if stat.S_ISDIR(os.fstat(file).st_mode) else "sync file")
        sync(file)

    def rename(self: Path, target: Path) -> Path:
        told.append("rename")
        return replace(self, target)

    monkeypatch.setattr(os, "fsync", note)
    monkeypatch.setattr(Path, "replace", rename)
    return told


def test_a_file_is_on_the_disk_before_it_gets_its_name_and_the_name_before_it_returns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = calls(monkeypatch)
    write_atomic(tmp_path / "new" / "folder" / "map.json", "all of it")
    assert told == ["sync file", "rename", "sync folder"]
    assert [path.name for path in (tmp_path / "new" / "folder").iterdir()] == ["map.json"]
    assert (tmp_path / "new" / "folder" / "map.json").read_text() == "all of it"


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_write_that_fails_leaves_the_former_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    path = tmp_path / "camera.json"
    write_atomic(path, "former")

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(*((os, "fsync") if step == "fsync" else (Path, "replace")), full)
    words = r"^The camera could not be saved: No space left on device\. Free some space"
    with pytest.raises(Unwritable, match=words), saving("The camera could not be saved"):
        write_atomic(path, "newer")
    assert path.read_text() == "former" and list(tmp_path.iterdir()) == [path]


def test_a_writer_that_breaks_off_half_way_leaves_the_former_file(tmp_path: Path) -> None:
    path = tmp_path / "map.npz"
    write_atomic(path, b"former")
    with pytest.raises(ZeroDivisionError), replacing(path) as file:
        file.write(b"half of")
        raise ZeroDivisionError
    assert path.read_bytes() == b"former" and list(tmp_path.iterdir()) == [path]


KILLED = """
import itertools, sys
from pathlib import Path
from core.files import write_atomic
print("ready", flush=True)
for number in itertools.count(1):
    write_atomic(Path(sys.argv[1]), f"{number:09d}" * 2000)
    print(number, flush=True)
"""


def test_who_is_killed_while_writing_leaves_a_whole_file_no_older_than_what_was_acknowledged(tmp_path: Path) -> None:
    path = tmp_path / "camera.json"
    for kill in range(4):
        with subprocess.Popen([sys.executable, "-c", KILLED, str(path)], stdout=subprocess.PIPE, text=True) as writer:
            assert writer.stdout is not None
            for _ in range(4 + 3 * kill):
                writer.stdout.readline()
            writer.kill()
            said = writer.stdout.read().rpartition("\n")[0].split()
        content = path.read_text()
        numbers = {content[begin : begin + 9] for begin in range(0, len(content), 9)}
        assert len(content) == 18_000 and len(numbers) == 1, "half a file"
        assert int(numbers.pop()) >= max(map(int, said), default=0)
    assert {left.suffix for left in tmp_path.iterdir() if left != path} <= {UNFINISHED}


def test_a_link_stays_a_link_and_a_device_a_device(tmp_path: Path) -> None:
    target, link, pipe = tmp_path / "target", tmp_path / "link", tmp_path / "pipe"
    link.symlink_to(target)
    write_atomic(link, "through the link")
    assert link.is_symlink() and target.read_text() == "through the link"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_atomic(pipe, "through the pipe")
    assert os.read(reader, 100) == b"through the pipe" and stat.S_ISFIFO(pipe.stat().st_mode)
    os.close(reader)


def in_the_way(folder: Path) -> Path:
    (folder / "file").write_text("")
    return folder / "file" / "results"


def a_file(folder: Path) -> Path:
    (folder / "file").write_text("")
    return folder / "file"


def a_dead_link(folder: Path) -> Path:
    (folder / "link").symlink_to(folder / "nowhere")
    return folder / "link" / "results"


@pytest.mark.parametrize(
    ("place", "why"),
    [
        (in_the_way, "cannot be made: Not a directory"),
        (a_file, "cannot be written to: Not a directory"),
        (a_dead_link, "cannot be made: It is a link to nothing"),
        (lambda folder: folder / ("x" * 300), "cannot be made: File name too long"),
        (lambda folder: Path("/proc/results"), "cannot be made: "),
    ],
    ids=["a file in the way", "a file", "a link to nothing", "a long name", "no disk"],
)
def test_a_folder_that_cannot_be_written_is_told_beforehand(
    tmp_path: Path, place: Callable[[Path], Path], why: str
) -> None:
    before = place(tmp_path)
    there = sorted(tmp_path.iterdir())
    with pytest.raises(Unwritable, match=why):
        check_folder(before)
    assert sorted(tmp_path.iterdir()) == there


def test_looking_whether_a_folder_can_be_written_leaves_nothing(tmp_path: Path) -> None:
    check_folder(tmp_path)
    check_folder(tmp_path / "a" / "b")
    check_file(tmp_path / "a" / "board.svg")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(Unwritable, match="it is a folder"):
        check_file(tmp_path)


def test_a_checksum_is_of_the_values_not_of_the_layout() -> None:
    document = sealed({"fx": 510.25, "names": ["é", "b"], "more": {"b": 1, "a": None}})
    assert is_intact(dict(reversed(list(document.items())))) is True
    assert is_intact(document | {"fx": 910.25}) is False
    assert is_intact({key: value for key, value in document.items() if key != SEAL}) is None


def test_what_a_crash_left_is_removed_and_nothing_else(tmp_path: Path) -> None:
    inner = tmp_path / "people"
    inner.mkdir()
    for name in (f".card.json.0a1b2c3d{UNFINISHED}", "card.json", ".hidden", f"mine{UNFINISHED}"):
        (inner / name).write_text("")
        os.utime(inner / name, (0, 0))
    (inner / f".fresh{UNFINISHED}").write_text("someone writes this now")
    remove_unfinished(tmp_path)
    assert sorted(path.name for path in inner.iterdir()) == [
        f".fresh{UNFINISHED}",
        ".hidden",
        "card.json",
        f"mine{UNFINISHED}",
    ]


ARRAY_TOML = "positions_m = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]\n"
CAMERA_YAML = (
    "image_width: 640\nimage_height: 480\ndistortion_model: plumb_bob\n"
    "camera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}\n"
    "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n"
)
CORNERS_JSON = '{"one.png": [[0, 0], [9, 0], [9, 9], [0, 9]]}\n'
TEXT_READERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "settings": ("[ekf]\ngate = 9.0\n", load),
    "robot file": ('url = "sim:lab"\n', load_robot_file),
    "array profile": (ARRAY_TOML, load_array),
    "phrases": ('turn_left = ["swing over there"]\n', lambda path: own_phrases(str(path))),
    "URDF": ('<robot name="r"><link name="base_link"/></robot>\n', load_body),
    "camera": (CAMERA_YAML, read_camera),
    "marked corners": (CORNERS_JSON, lambda path: marked_corners(path, ["one.png"])),
    "questions": ('[{"picture": "one.png"}]\n', read_questions),
    "what was said": ("turn left\n", read_text),
}


@pytest.mark.parametrize("kind", TEXT_READERS)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_every_reader_takes_text_as_editors_of_all_systems_write_it(tmp_path, kind, encoding):
    text, read = TEXT_READERS[kind]
    file = tmp_path / "file.txt"
    file.write_bytes(text.replace("\n", "\r\n").encode(encoding))
    assert read(file) is not None


@pytest.mark.parametrize("kind", TEXT_READERS)
@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be", "latin-1"])
def test_no_reader_takes_what_is_no_text(tmp_path, kind, encoding):
    text, read = TEXT_READERS[kind]
    file = tmp_path / "file.txt"
    file.write_bytes(f"{text}ÿÿ\n".encode(encoding))
    with pytest.raises(BadInput, match=r"file\.txt is not a text file in UTF-8"):
        read(file)
