"""A data folder as one file and back: whole or not at all, also while a console writes."""

import contextlib
import errno
import io
import json
import os
import sqlite3
import tarfile
import tempfile
from pathlib import Path

import pytest

from console import backup
from console.__main__ import main
from console.backup import MANIFEST, restore_backup, write_backup
from console.data_folder import locked
from core.errors import BadInput, Unavailable, Unwritable

FILES = {
    "maps/lab-1/card.json": b"{}",
    "maps/lab-1/floor/map.npz": bytes(range(256)) * 400,
    "calibration/camera.json": b'{"fx": 1}',
    "people/ann.json": b"[]",
    "settings.toml": b"[ekf]\n",
    "access.json": b"{}",
    "recordings/a.mcap": b"x" * 1000,
    "recordings.json": b'{"a": {"note": "keep"}}',
    "people/.ann.json.0badcafe.new": b"half written",
    "halt.json": b'{"halted": true}',
    "open.html": b"has a key",
    "models/large.bin": b"y" * 1000,
    "notes-of-mine.txt": b"not Beckon's",
}
NOT_KEPT = {"models/large.bin", "notes-of-mine.txt", "people/.ann.json.0badcafe.new", "halt.json", "open.html"}
DATABASE_FILES = ("history.sqlite", "fleet/history.sqlite")


@pytest.fixture
def home(tmp_path: Path) -> Path:
    home = tmp_path / "home"
    for name, content in FILES.items():
        (home / name).parent.mkdir(parents=True, exist_ok=True)
        (home / name).write_bytes(content)
    (home / "fleet").mkdir()
    for name in DATABASE_FILES:
        with contextlib.closing(sqlite3.connect(home / name)) as history:
            history.execute("PRAGMA journal_mode=WAL")
            history.execute("CREATE TABLE commands (words TEXT)")
            history.commit()
    return home


def content_of(folder: Path) -> dict[str, bytes]:
    files = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    return {name: path.read_bytes() for name, path in files.items() if not name.endswith("lock")}


def test_all_that_is_ours_comes_back_on_an_empty_machine(home: Path, tmp_path: Path) -> None:
    writing = [sqlite3.connect(home / name) for name in DATABASE_FILES]  # as a console has it open
    for one in writing:
        one.execute("INSERT INTO commands VALUES ('turn left')")
        one.commit()  # is in its journal alone
        one.execute("INSERT INTO commands VALUES ('not committed')")
    report = write_backup(home, tmp_path / "b" / "all.tar.gz", recordings=True)
    for one in writing:
        one.close()
    assert report.files == len(FILES) - len(NOT_KEPT) + len(DATABASE_FILES)
    restore_backup(report.file, tmp_path / "new" / "home")
    found = content_of(tmp_path / "new" / "home")
    for name in DATABASE_FILES:
        with contextlib.closing(sqlite3.connect(tmp_path / "new" / "home" / name)) as history:
            assert history.execute("SELECT words FROM commands").fetchall() == [("turn left",)]
        del found[name]
    assert found == {name: content for name, content in FILES.items() if name not in NOT_KEPT}
    assert (tmp_path / "new" / "home" / "access.json").stat().st_mode & 0o077 == 0
    assert report.file.stat().st_mode & 0o077 == 0


def test_recordings_are_left_out_unless_they_are_asked_for(home: Path, tmp_path: Path) -> None:
    report = write_backup(home, tmp_path / "b.tar.gz")
    assert report.left_out == ("recordings",)
    with tarfile.open(report.file) as box:
        assert not any(name.startswith("recordings/") for name in box.getnames())
        assert "recordings.json" in box.getnames()


def test_what_is_there_is_kept_and_never_overwritten_unasked(home: Path, tmp_path: Path) -> None:
    packed = write_backup(home, tmp_path / "b.tar.gz").file
    (home / "settings.toml").write_text("newer")
    before = content_of(home)
    with pytest.raises(BadInput, match="not empty"):
        restore_backup(packed, home)
    assert content_of(home) == before
    restore_backup(packed, home, replace=True)
    assert (home / "settings.toml").read_bytes() == FILES["settings.toml"]
    assert (home / "before-restore" / "settings.toml").read_text() == "newer"
    assert (home / "notes-of-mine.txt").exists()
    with pytest.raises(BadInput, match="earlier restore"):
        restore_backup(packed, home, replace=True)


def test_a_disk_that_fails_on_the_way_leaves_all_as_it_was(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    report = write_backup(home, tmp_path / "all.tar.gz")
    assert report.file.stat().st_mode & 0o777 == 0o600
    before = content_of(home)
    moves: list[Path] = []

    def failing(path: Path, target: Path) -> Path:
        moves.append(path)
        if len(moves) == 11:  # behind the first of those that come in
            raise OSError(errno.EIO, "Input/output error")
        return rename(path, target)

    rename = Path.rename
    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(Unwritable, match="could not be put back"):
        restore_backup(report.file, home, replace=True)
    assert content_of(home) == before and not (home / "before-restore").exists()


def test_a_halt_is_neither_lifted_nor_brought_back(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as former:
        former.setattr(backup, "HALT", "of no file")  # a backup of an earlier version
        packed = write_backup(home, tmp_path / "b.tar.gz").file
    restore_backup(packed, home, replace=True)
    assert (home / "halt.json").exists() and not (home / "before-restore" / "halt.json").exists()
    restore_backup(packed, tmp_path / "new")
    assert "settings.toml" in content_of(tmp_path / "new") and not (tmp_path / "new" / "halt.json").exists()


def test_a_halt_of_a_fleet_is_neither_lifted_nor_brought_back(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    halt = home / "fleet" / "halt.json"
    halt.write_bytes(b"earlier")
    with monkeypatch.context() as former:
        former.setattr(backup, "HALT", "of no file")  # a backup of an earlier version
        packed = write_backup(home, tmp_path / "b.tar.gz").file
    restore_backup(packed, tmp_path / "new")
    assert (tmp_path / "new" / "fleet").is_dir() and not (tmp_path / "new" / "fleet" / "halt.json").exists()
    halt.unlink()
    packed = write_backup(home, tmp_path / "b.tar.gz").file
    halt.write_bytes(b"now")
    restore_backup(packed, home, replace=True)
    assert halt.read_bytes() == b"now" and not (home / "before-restore" / "fleet" / "halt.json").exists()
    with tarfile.open(write_backup(home, tmp_path / "b.tar.gz").file) as box:
        assert not any("halt" in name for name in box.getnames())


def test_a_folder_that_a_fleet_uses_is_left_alone(home: Path, tmp_path: Path) -> None:
    packed = write_backup(home, tmp_path / "b.tar.gz").file
    with locked(home / "fleet"), pytest.raises(Unavailable, match="Another console"):
        restore_backup(packed, home, replace=True)
    assert not (home / "before-restore").exists()


def test_a_folder_that_a_console_uses_is_left_alone(home: Path, tmp_path: Path) -> None:
    packed = write_backup(home, tmp_path / "b.tar.gz").file
    with locked(home), pytest.raises(Unavailable, match="Another console"):
        restore_backup(packed, home, replace=True)


def test_nothing_is_written_beside_the_folder(home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As a container's volume and a service's folder are: what lies around them belongs to root."""
    packed = write_backup(home, tmp_path / "b.tar.gz").file
    volume = tmp_path / "root" / "data"
    volume.mkdir(parents=True)
    written: list[str] = []
    made = tempfile.mkdtemp
    monkeypatch.setattr(tempfile, "mkdtemp", lambda *of: written.append(str(of[-1])) or made(*of))
    restore_backup(packed, volume)
    assert written == [str(volume)]
    assert content_of(volume)["settings.toml"] == FILES["settings.toml"]
    assert not list(volume.glob(".restore-*"))


def test_files_come_back_with_their_dates(home: Path, tmp_path: Path) -> None:
    """By them the oldest recording goes first, and pictures are in order."""
    os.utime(home / "recordings" / "a.mcap", (1e9, 1e9))
    restore_backup(write_backup(home, tmp_path / "b.tar.gz", recordings=True).file, tmp_path / "new")
    assert (tmp_path / "new" / "recordings" / "a.mcap").stat().st_mtime == 1e9


def test_a_backup_that_is_interrupted_leaves_the_former_and_nothing_else(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(_: Path) -> None:
        raise KeyboardInterrupt

    former = write_backup(home, tmp_path / "b" / "b.tar.gz").file.read_bytes()
    monkeypatch.setattr(backup, "_content", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_backup(home, tmp_path / "b" / "b.tar.gz")
    assert content_of(tmp_path / "b") == {"b.tar.gz": former}, "keys of logins would lie in what is left"


def test_a_map_that_is_saved_again_while_it_is_packed_is_packed_again(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read, gone = backup._content, []

    def saved_again(path: Path) -> contextlib.AbstractContextManager[io.BufferedIOBase]:
        if path.name == "map.npz" and not gone:
            gone.append((home / "maps" / "lab-1").rename(home / "maps" / "lab-2"))
        return read(path)

    monkeypatch.setattr(backup, "_content", saved_again)
    restore_backup(write_backup(home, tmp_path / "b.tar.gz").file, tmp_path / "new")
    found = content_of(tmp_path / "new")
    assert found["maps/lab-2/floor/map.npz"] == FILES["maps/lab-1/floor/map.npz"] and len(gone) == 1
    assert not any(name.startswith("maps/lab-1/") for name in found)


def test_a_backup_that_cannot_be_read_says_so(tmp_path: Path) -> None:
    (tmp_path / "b.tar.gz").mkdir()
    with pytest.raises(BadInput, match="cannot be read: Is a directory"):
        restore_backup(tmp_path / "b.tar.gz", tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_no_damage_is_put_back(home: Path, tmp_path: Path) -> None:
    """A law over places: wherever a byte was changed or the file ends early, nothing of it reaches the folder."""
    packed = write_backup(home, tmp_path / "b.tar.gz").file.read_bytes()
    damaged = tmp_path / "damaged.tar.gz"
    for step in range(1, 24):
        place = step * len(packed) // 24
        for content in (packed[:place], packed[:place] + bytes([packed[place] ^ 0x55]) + packed[place + 1 :]):
            damaged.write_bytes(content)
            with contextlib.suppress(BadInput):
                restore_backup(damaged, tmp_path / f"new{step}")
                kept = content_of(tmp_path / f"new{step}")  # a byte that means nothing was changed
                assert all(kept[name] == FILES[name] for name in kept.keys() & FILES.keys())
                continue
            assert not (tmp_path / f"new{step}").exists() or content_of(tmp_path / f"new{step}") == {}


@pytest.mark.parametrize("name", ["../outside", "/etc/passwd", "maps/../../x", "elsewhere.txt"])
def test_what_would_lie_elsewhere_is_refused(name: str, tmp_path: Path) -> None:
    with tarfile.open(tmp_path / "b.tar.gz", "w:gz") as box:
        entry = tarfile.TarInfo(name)
        entry.size = 1
        box.addfile(entry, io.BytesIO(b"x"))
    with pytest.raises(BadInput, match="no file of Beckon's"):
        restore_backup(tmp_path / "b.tar.gz", tmp_path / "new")


@pytest.mark.parametrize(
    ("manifest", "says"),
    [
        (b"", "list of files"),
        (b"{}", "list of files"),
        (b'{"format": 9, "beckon": "7", "files": []}', "update Beckon"),
    ],
)
def test_another_manifest_is_told_in_a_sentence(manifest: bytes, says: str, tmp_path: Path) -> None:
    with tarfile.open(tmp_path / "b.tar.gz", "w:gz") as box:
        entry = tarfile.TarInfo(MANIFEST)
        entry.size = len(manifest)
        box.addfile(entry, io.BytesIO(manifest))
    with pytest.raises(BadInput, match=says):
        restore_backup(tmp_path / "b.tar.gz", tmp_path / "new")


def test_a_disk_that_takes_nothing_is_told_and_leaves_nothing_behind(home: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(Unwritable, match="could not be written"):
        write_backup(home, tmp_path / "file" / "b.tar.gz")
    with pytest.raises(BadInput, match="no data folder"):
        write_backup(tmp_path / "nowhere", tmp_path / "b.tar.gz")


def test_the_command_line_tells_it_in_either_form(
    home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    packed = str(tmp_path / "b.tar.gz")
    assert main(["backup", packed, "--data", str(home), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["left_out"] == ["recordings"]
    assert main(["restore", packed, "--data", str(tmp_path / "new")]) == 0
    assert "files of" in capsys.readouterr().out
    assert main(["restore", str(tmp_path / "none"), "--data", str(tmp_path / "new2")]) == 1
