"""Saved maps: names, half-written ones, replacing, and the journey that goes with them."""

from __future__ import annotations

import json
import math
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from console.maps.export import known_part, preview
from console.maps.store import ASIDE, CARD, MapInfo, MapStore, NameTaken, checked_name, slug
from console.maps.trajectory import ROW_FIELDS, Trajectory, laid_out
from core.errors import BadInput, Unwritable
from core.files import SEAL
from core.gate import ZERO
from core.geometry import Pose
from core.slam.estimate import Estimate, SlamHealth
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.status import MapStatus, SubmapView
from core.slam.motion import Increment
from core.snapshot import Snapshot


def named(name: str, saved: float = 100.0) -> MapInfo:
    return MapInfo(name, saved, "Ada", "robot", 0.05, 5.0, 4.0, 2, 11, 1)


def saying(words: str):
    return lambda folder: (folder / "words.txt").write_text(words)


def words_of(store: MapStore, name: str) -> str:
    kept = store.find(name)
    assert kept is not None
    return (kept.folder / "words.txt").read_text()


@pytest.fixture
def store(tmp_path: Path) -> MapStore:
    return MapStore(tmp_path / "maps")


def test_a_saved_map_is_found_again_by_another_console(store: MapStore, tmp_path: Path) -> None:
    store.keep(named("Großes Büro"), saying("all of it"), replace=False)
    again = MapStore(tmp_path / "maps")
    again.clean()
    assert [kept.card.name for kept in again.all()] == ["Großes Büro"]
    assert words_of(again, "grosses büro") == "all of it"  # large and small letters are the same


def test_a_name_that_is_taken_is_refused_unless_it_shall_be_replaced(store: MapStore) -> None:
    store.keep(named("lab"), saying("first"), replace=False)
    with pytest.raises(NameTaken, match="“lab” already"):
        store.keep(named("Lab", 200.0), saying("second"), replace=False)
    assert words_of(store, "lab") == "first"
    store.keep(named("Lab", 200.0), saying("second"), replace=True)
    assert words_of(store, "lab") == "second" and len(store.all()) == 1


def test_a_map_whose_writing_breaks_off_never_was_and_the_former_stays(store: MapStore, tmp_path: Path) -> None:
    store.keep(named("lab"), saying("whole"), replace=False)

    def breaks(folder: Path) -> None:
        (folder / "words.txt").write_text("ha")
        raise OSError(28, "No space left on device")

    with pytest.raises(Unwritable, match=r"nothing was changed: No space left on device\. Free some space"):
        store.keep(named("lab", 200.0), breaks, replace=True)
    assert words_of(store, "lab") == "whole"
    assert len(list((tmp_path / "maps").iterdir())) == 1


def test_what_a_crash_left_behind_is_cleared_away(store: MapStore, tmp_path: Path) -> None:
    store.keep(named("lab", 100.0), saying("older"), replace=False)
    older = store.find("lab")
    assert older is not None
    half = tmp_path / "maps" / f"{ASIDE}1234"
    half.mkdir()
    (half / CARD).write_bytes((older.folder / CARD).read_bytes())  # died before the rename
    twin = tmp_path / "maps" / "lab-newer"
    twin.mkdir()  # died after the rename, before the older one went
    (twin / CARD).write_text((older.folder / CARD).read_text().replace("100.0", "300.0"))
    (twin / "words.txt").write_text("newer")
    assert words_of(store, "lab") == "newer"
    store.clean()
    assert [path.name for path in (tmp_path / "maps").iterdir()] == ["lab-newer"]


@pytest.mark.parametrize("damage", [b"", b"{", b"[]", b'{"name": "x"}', b"\xff" * 80_000])
def test_a_card_that_cannot_be_read_hides_its_map_and_no_other(store: MapStore, damage: bytes) -> None:
    store.keep(named("lab"), saying("fine"), replace=False)
    store.keep(named("hall"), saying("lost"), replace=False)
    hall = store.find("hall")
    assert hall is not None
    (hall.folder / CARD).write_bytes(damage)
    assert [kept.card.name for kept in store.all()] == ["lab"]


def test_a_map_goes_for_good_and_is_packed_with_everything(store: MapStore) -> None:
    store.keep(named("lab"), saying("packed"), replace=False)
    kept = store.find("lab")
    assert kept is not None
    with store.packed(kept) as packed, zipfile.ZipFile(packed) as box:
        assert sorted(box.namelist()) == [CARD, "words.txt"]
    store.remove(kept)
    assert store.all() == [] and store.find("lab") is None


def damage(path: Path) -> None:
    """Change one digit, as a disk or an editor may."""
    raw = bytearray(path.read_bytes())
    place = max(number for number, byte in enumerate(raw) if byte in b"0123456789")
    raw[place] = ord(b"1") if raw[place] != ord(b"1") else ord(b"2")
    path.write_bytes(bytes(raw))


@pytest.mark.parametrize("name", ["words.txt", CARD])
def test_a_map_with_a_changed_digit_is_neither_loaded_nor_packed_and_the_file_is_named(
    store: MapStore, name: str
) -> None:
    store.keep(named("lab"), saying("71 landmarks"), replace=False)
    sound = store.find("lab")
    assert sound is not None and store.checked(sound) == sound.folder
    damage(sound.folder / name)
    kept = store.find("lab")
    assert kept is not None, "it is still listed, so that it can be deleted"
    for use in (store.packed, store.checked):
        with pytest.raises(BadInput, match=rf"{name} is not as it was saved\. Restore this file"):
            use(kept)
    (kept.folder / "words.txt").unlink()
    with pytest.raises(BadInput, match="is not as it was saved"):
        store.checked(kept)


def test_a_map_of_an_earlier_console_has_no_checksums_and_is_taken(store: MapStore) -> None:
    store.keep(named("lab"), saying("71 landmarks"), replace=False)
    kept = store.find("lab")
    assert kept is not None and kept.card.files.keys() == {"words.txt"}
    card = json.loads((kept.folder / CARD).read_text())
    del card["files"], card[SEAL]
    (kept.folder / CARD).write_text(json.dumps(card))
    (kept.folder / "words.txt").write_text("72 landmarks")
    old = store.find("lab")
    assert old is not None and store.checked(old) == old.folder and old.card.files == {}


@pytest.mark.parametrize("name", ["lab", "Ground floor", "Büro 2", "a-b_c", "  two   words ", "地図", "x" * 40])
def test_names_of_people_are_taken(name: str) -> None:
    assert checked_name(name) == " ".join(name.split())
    assert slug(checked_name(name))


@pytest.mark.parametrize(
    "name", ["", " ", "..", "../lab", "a/b", "a\\b", "a\x00b", ".hidden", "a.b", "x" * 41, "-a", "a%2fb"]
)
def test_names_that_could_be_something_else_are_refused(name: str) -> None:
    with pytest.raises(BadInput, match="letters"):
        checked_name(name)


# the journey

ROOMS = MapStatus(
    submaps=(
        SubmapView(id=0, pose=Pose(), extent=np.array([[-1, -1], [1, 1]]), active=False),
        SubmapView(id=1, pose=Pose(2, 0, math.pi / 2), extent=np.array([[-1, -1], [1, 1]]), active=True),
    )
)


def snapshot(stamp: float, pose: Pose, floor: MapStatus = ROOMS) -> Snapshot:
    estimate = Estimate(pose=pose, covariance=np.eye(3))
    none = np.zeros((0, 2))
    return Snapshot(
        increment=Increment(),
        stamp=stamp, estimate=estimate, dead_reckoning=estimate, velocity=ZERO, setpoint=ZERO, scan_points=none,
        slam=SlamHealth(),
        grid=OccupancyGrid(revision=0, resolution=0.05, origin=np.zeros(2), log_odds=np.zeros((0, 0))),
        trail=none, dead_reckoning_trail=none, path=none, floor=floor,
    )  # fmt: skip


def test_a_closure_that_moves_a_room_moves_the_way_that_was_gone_in_it() -> None:
    trajectory = Trajectory()
    trajectory.add(snapshot(1.0, Pose(2, 1, 0)))
    stamps, [pose] = laid_out(trajectory.rows(), ROOMS)
    assert stamps == [1.0]
    assert pose.vector == pytest.approx([2, 1, 0])
    shift = Pose(0.5, -0.25, 0.1)
    moved = replace(ROOMS, submaps=(ROOMS.submaps[0], replace(ROOMS.submaps[1], pose=shift @ ROOMS.submaps[1].pose)))
    _, [pose] = laid_out(trajectory.rows(), moved)
    assert pose.vector == pytest.approx((shift @ Pose(2, 1, 0)).vector)


def test_without_rooms_the_poses_are_the_worlds_and_rooms_that_are_gone_are_left_out() -> None:
    trajectory = Trajectory()
    trajectory.add(snapshot(0.0, Pose(1, 2, 3), MapStatus()))
    trajectory.add(snapshot(1.0, Pose(4, 5, 0.6)))
    stamps, poses = laid_out(trajectory.rows(), MapStatus())
    assert stamps == [0.0] and poses[0].vector == pytest.approx([1, 2, 3])


def test_a_journey_is_thinned_when_it_is_full_and_begins_anew_with_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.maps.trajectory.MAX_POSES", 1000)
    trajectory = Trajectory()
    still = snapshot(0.0, Pose())
    for number in range(1010):
        trajectory.add(replace(still, stamp=0.1 * number))
    assert 500 < len(trajectory) < 520
    stamps = trajectory.rows()[:, 0]
    assert trajectory.rows().shape[1] == ROW_FIELDS and stamps[0] == 0.0 and (np.diff(stamps) > 0).all()
    trajectory.add(replace(still, stamp=5.0))
    assert len(trajectory) == 1


def test_the_preview_shows_what_is_known_and_nothing_around_it() -> None:
    odds = np.zeros((60, 80), np.float32)
    odds[20:31, 10:41] = -2.0
    grid = OccupancyGrid(revision=1, resolution=0.1, origin=np.array([-3.0, 1.0]), log_odds=odds)
    part = known_part(grid)
    assert part.log_odds.shape == (11, 31) and part.origin == pytest.approx([-2.0, 3.0])
    assert preview(grid).startswith(b"\x89PNG")
