"""Saved maps: names, half-written ones, replacing, the one in use, and the trajectory that goes with them."""

import asyncio
import io
import json
import math
import threading
import zipfile
from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

import msgspec
import numpy as np
import pytest

from console.control.history import History
from console.control.lease import Lease
from console.http.problems import Problem
from console.maps import marks
from console.maps.edits import MAX_EDITS, EditService
from console.maps.export import FLOOR, known_part, preview
from console.maps.join_worker import JoinedMap, TwoMaps
from console.maps.marks import EditMark, MapMarks, PlaceMark, read_marks
from console.maps.places import PlaceService
from console.maps.service import ITSELF, LAST_BUT_ONE, LAST_BUT_TWO, LAST_MAP, JoinProposal, MapService
from console.maps.store import ASIDE, CARD, MapInfo, MapStore, NameTaken, checked_name, slug
from console.maps.trajectory import ROW_FIELDS, Trajectory, laid_out
from core.errors import BadInput, Refused, Unwritable
from core.files import SEAL
from core.gate import ZERO
from core.geometry import Pose
from core.navigation.zones import KeepOuts, MapZone, SlowZones
from core.pilot import Pilot
from core.pilot.pilot import parts_of
from core.robots import Profile
from core.robots.connect import connect
from core.sensors import SensorFrame
from core.settings import Settings
from core.slam.estimate import Estimate, SlamHealth
from core.slam.map.edits import MapEdit, MapEdits
from core.slam.map.map_file import SavedMap
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.status import MapStatus, SubmapView
from core.slam.map_join import MapMatch
from core.slam.motion import Increment
from core.snapshot import Snapshot
from tests.console.live import until


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


def test_a_map_that_is_replaced_is_gone_at_once_for_who_reads_it(
    store: MapStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    store.keep(named("lab"), saying("one"), replace=False)
    former = store.find("lab")
    monkeypatch.setattr("console.maps.store.shutil.rmtree", lambda *_, **__: None)  # it takes its time
    store.keep(named("lab", 200.0), saying("two"), replace=True)
    assert former is not None and words_of(store, "lab") == "two"
    for read in (store.checked, store.packed):
        with pytest.raises(FileNotFoundError):  # half of it would be called damaged
            read(former)


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
    packed = store.unpacked(store.packed(old).read())
    assert packed is not None and packed[1] == {"words.txt": b"72 landmarks"}, "nor by another robot"
    (kept.folder / CARD).write_text(json.dumps({**card, "files": {"words.txt": "0"}}))  # its seal was taken away
    with zipfile.ZipFile(box := io.BytesIO(), "w") as packing:
        for path in kept.folder.iterdir():
            packing.write(path, path.name)
    with pytest.raises(BadInput, match="is no saved map"):
        store.unpacked(box.getvalue())


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


def test_a_journey_grows_while_it_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """A report reads it in a thread, and the event loop adds to it at any moment."""
    trajectory, frombuffer = Trajectory(), np.frombuffer
    trajectory.add(snapshot(1.0, Pose()))

    def grown(memory: Any) -> np.ndarray:
        lent = frombuffer(memory)
        trajectory.add(snapshot(2.0, Pose()))
        return lent

    monkeypatch.setattr(np, "frombuffer", grown)
    assert trajectory.rows().shape == (1, ROW_FIELDS) and len(trajectory) == 2


def test_the_preview_shows_what_is_known_and_nothing_around_it() -> None:
    odds = np.zeros((60, 80), np.float32)
    odds[20:31, 10:41] = -2.0
    grid = OccupancyGrid(revision=1, resolution=0.1, origin=np.array([-3.0, 1.0]), log_odds=odds)
    part = known_part(grid)
    assert part.log_odds.shape == (11, 31) and part.origin == pytest.approx([-2.0, 3.0])
    assert preview(grid).startswith(b"\x89PNG")


@cache
def seen() -> tuple[Profile, list[SensorFrame]]:
    """A robot in the lab, and its first frames, of which a map is made."""
    robot = connect("sim:lab", seed=1, settings=Settings())
    frames = [robot.read() for _ in range(3)]
    robot.close()
    return robot.profile, frames


class Turns(asyncio.Lock):
    """A lock that tells how often it was asked for."""

    asked = 0

    async def acquire(self) -> Literal[True]:
        self.asked += 1
        return await super().acquire()


class InUse:
    """The maps of a console without its page, on a robot that has looked around."""

    def __init__(self, home: Path) -> None:
        profile, _ = seen()
        self.pilot, history = Pilot(profile), History(home, print)
        history.open()
        link: Any = SimpleNamespace(profile=profile)
        dispatcher: Any = SimpleNamespace(pilot=self.pilot, cancel=lambda *_: None)
        self.maps = MapService(home, Settings(), link, dispatcher, Lease(), history)
        self.maps._turn = self.turns = Turns()
        self.store = MapStore(home / "maps")
        self.look()

    def look(self) -> None:
        """Take the frames; once more, it is a robot whose clock began again."""
        for frame in seen()[1]:
            self.maps.on_snapshot(self.pilot.step(frame), frame)

    async def go_on(self) -> None:
        """Take the last frame again and again, a tenth of a second later each time."""
        frame = seen()[1][-1]
        while True:
            frame = replace(frame, stamp=frame.stamp + 0.1)
            self.maps.on_snapshot(await asyncio.to_thread(self.pilot.step, frame), frame)
            await asyncio.sleep(0.01)

    async def in_line(self, change: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
        """Begin this, which is to change the map in use, and go on as soon as it has asked for its turn."""
        asked, task = self.turns.asked, asyncio.create_task(change)
        await until(lambda: self.turns.asked > asked)
        return task

    async def autosave(self) -> None:
        self.maps._unsaved = True  # it drove
        assert await self.maps.autosaved()

    async def mark(self, *, whole: bool = False, **marks: object) -> None:
        await self.maps.mark(lambda kept: msgspec.structs.replace(kept, **marks), "mark", ITSELF, whole=whole)

    def kept(self, name: str) -> tuple[Path, str, MapMarks]:
        """Folder, frame and marks of a saved map."""
        found = self.store.find(name)
        assert found is not None, name
        return found.folder, found.card.frame, read_marks(found.folder)


DESK_MARKS, ERASED_CELLS = (PlaceMark("desk", 0.3, 0.1),), (EditMark(1, "free", ((0.3, 0.1),), 0.2),)


def in_use(work: Callable[[InUse], Awaitable[None]], home: Path) -> None:
    async def whole() -> None:
        await work(InUse(home))

    asyncio.run(whole())


def test_a_robot_whose_clock_began_again_is_on_no_saved_map_any_more(tmp_path: Path) -> None:
    async def work(console: InUse) -> None:
        maps, pilot = console.maps, console.pilot
        await maps.save("Office", ITSELF, replace=False)
        await console.mark(places=DESK_MARKS, edits=ERASED_CELLS)
        saved = console.kept("Office")
        corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
        hole = MapZone(name="hole", kind="keep_out", points=corners)
        pilot.heed(KeepOuts((hole,)), SlowZones((replace(hole, kind="slow", max_speed=0.1),)))
        pilot.edit_map(MapEdits((MapEdit("free", corners),)))
        pilot.step(replace(seen()[1][-1], stamp=seen()[1][-1].stamp + 0.1))
        assert pilot._edits.edits and pilot._keep_outs.zones and pilot._slow_zones.zones
        console.look()
        assert (maps.shown.name, maps.frame, maps.marks) == (None, "", MapMarks())
        assert not pilot._edits.edits and not pilot._keep_outs.zones and not pilot._slow_zones.zones
        await console.autosave()
        assert console.kept("Office") == saved and saved[2].places == DESK_MARKS
        frame = console.kept(LAST_MAP)[1]
        console.look()
        await console.autosave()  # of a third map: the second is kept
        assert console.kept(LAST_BUT_ONE)[1] == frame != console.kept(LAST_MAP)[1]

    in_use(work, tmp_path)


def test_the_map_in_use_is_replaced_by_no_other_that_is_kept(tmp_path: Path) -> None:
    async def work(console: InUse) -> None:
        await console.autosave()
        console.look()
        await console.autosave()
        before, last = console.kept(LAST_BUT_ONE), console.kept(LAST_MAP)
        await console.maps.load(LAST_BUT_ONE, ITSELF)
        await console.autosave()
        assert console.kept(LAST_BUT_ONE) == before and console.kept(LAST_BUT_TWO)[:2] == last[:2]
        await console.mark(places=DESK_MARKS)
        assert console.kept(LAST_BUT_ONE) == (*before[:2], MapMarks(places=DESK_MARKS))

    in_use(work, tmp_path)


def test_a_saved_map_is_called_otherwise_and_the_robot_goes_on_in_it(tmp_path: Path) -> None:
    async def work(console: InUse) -> None:
        maps = console.maps
        await maps.save("Office", ITSELF, replace=False)
        await console.mark(places=DESK_MARKS)
        saved = console.kept("Office")
        assert (await maps.rename("office", "First  floor", ITSELF)).name == "First floor" == maps.shown.name
        assert console.kept("First floor") == saved and console.store.find("Office") is None
        await maps.rename("First floor", "first Floor", ITSELF)
        assert console.kept("first Floor") == saved and maps.shown.name == "first Floor"
        await maps.save("Lab", ITSELF, replace=False)
        for name, wrong in (("LAB", Problem), ("a/b", BadInput)):
            with pytest.raises(wrong):
                await maps.rename("first Floor", name, ITSELF)
        with pytest.raises(Problem, match="no saved map"):
            await maps.rename("Office", "Hall", ITSELF)
        assert {one.name for one in await maps.all()} == {"Lab", "first Floor"} and maps.shown.name == "Lab"

    in_use(work, tmp_path)


def test_an_import_in_the_place_of_the_map_in_use_keeps_its_own_marks(tmp_path: Path) -> None:
    async def work(console: InUse) -> None:
        other = InUse(tmp_path / "other")
        await other.maps.save("office", ITSELF, replace=False)
        packed = (await other.maps.packed("office")).read()
        await console.maps.save("Office", ITSELF, replace=False)
        await console.maps.take_in("office", packed, ITSELF, replace=True)
        assert console.maps.shown.name is None
        await console.mark(places=DESK_MARKS)
        assert console.kept("office")[1:] == (other.maps.frame, MapMarks())
        assert console.kept(LAST_MAP)[2].places == DESK_MARKS
        await console.maps.load("office", ITSELF)
        await console.maps.take_in("Office", packed, ITSELF, replace=True)  # the same axes: it goes on in it
        assert console.maps.shown.name == "Office"

    in_use(work, tmp_path)


def test_a_map_that_is_loaded_while_another_is_written_keeps_its_own_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def work(console: InUse) -> None:
        maps, keep, written = console.maps, console.maps._store.keep, threading.Event()
        await maps.save("lab", ITSELF, replace=False)
        lab = console.kept("lab")
        console.look()  # another map
        frames = asyncio.create_task(console.go_on())

        def slowly(card: MapInfo, write: Callable[[Path], None], *, replace: bool) -> None:
            assert written.wait(10)
            keep(card, write, replace=replace)

        monkeypatch.setattr(maps._store, "keep", slowly)
        saving = await console.in_line(maps.save("office", ITSELF, replace=False))
        loading = await console.in_line(maps.load("lab", ITSELF))
        assert not loading.done()
        late = await console.in_line(maps.save("yard", ITSELF, replace=False))
        written.set()
        await asyncio.gather(saving, loading)
        assert (maps.shown.name, maps.frame) == ("lab", lab[1])
        assert console.kept("office")[1] not in ("", lab[1])
        with pytest.raises(Refused, match="Another map"):
            await late  # it was asked for while the office was in use
        copied = await maps.save("copy", ITSELF, replace=False)
        assert copied.frame == lab[1] and maps._entering is None and not maps._unsaved
        frames.cancel()

    in_use(work, tmp_path)


def test_a_map_that_is_renamed_before_it_is_written_again_is_written_under_its_new_name(tmp_path: Path) -> None:
    async def work(console: InUse) -> None:
        maps = console.maps
        await maps.save("lab", ITSELF, replace=False)
        maps._redrawn = True
        async with maps._turn:
            renaming = await console.in_line(maps.rename("lab", "shop", ITSELF))
            drawing = await console.in_line(maps._keep_redrawn())
            marking = await console.in_line(console.mark(places=DESK_MARKS))
        await asyncio.gather(renaming, drawing, marking)
        assert [kept.card.name for kept in console.store.all()] == ["shop"]
        assert console.kept("shop")[2].places == DESK_MARKS

    in_use(work, tmp_path)


def test_a_map_that_is_saved_again_while_it_is_loaded_or_joined_loses_no_marks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def work(console: InUse) -> None:
        maps, reads, saved_again = console.maps, threading.Event(), threading.Event()

        def late(folder: Path) -> MapMarks:
            reads.set()
            saved_again.wait(1.0)
            return read_marks(folder)

        await maps.save("lab", ITSELF, replace=False)
        await console.mark(places=DESK_MARKS)
        older = console.store.find("lab")
        with monkeypatch.context() as busy:
            busy.setattr("console.maps.service.read_marks", late)
            loading = asyncio.create_task(maps.load("lab", ITSELF))
            await until(reads.is_set)
            saving = asyncio.create_task(maps.save("lab", ITSELF, replace=True))
            saving.add_done_callback(lambda _: saved_again.set())
            await asyncio.gather(loading, saving, return_exceptions=True)
        assert maps.marks.places == console.kept("lab")[2].places == DESK_MARKS

        await maps.save("lab", ITSELF, replace=True)

        async def joined(_: object) -> JoinedMap:
            return JoinedMap(SavedMap.from_files(console.kept("lab")[0] / FLOOR), maps.grid, 1)

        assert older is not None and not older.folder.exists()
        monkeypatch.setattr(maps, "_worked", joined)
        match = TwoMaps(str(older.folder), str(older.folder), parts_of(Settings()))
        maps._proposal = JoinProposal("1", older, older, match, MapMatch(Pose(), 1, 1, (), 1.0, 0.0), b"")
        with pytest.raises(Problem, match="no saved map of that name any more"):
            await maps.join("1", "both", ITSELF)
        assert console.store.find("both") is None

    in_use(work, tmp_path)


def test_of_changes_at_once_all_are_made(tmp_path: Path) -> None:
    async def work(console: InUse) -> None:
        maps, dispatcher = console.maps, console.maps._dispatcher
        dispatcher.own_phrases, dispatcher.know_places = (), lambda _: None
        edits, places = EditService(maps, dispatcher, Lease()), PlaceService(maps, dispatcher)
        await maps.save("lab", ITSELF, replace=False)
        for _ in range(3):
            await edits.add("free", [(0.3, 0.1)], 0.2, 0.0, ITSELF)
        await asyncio.gather(*(edits.undo(ITSELF) for _ in range(3)))
        assert all(one.undone_s for one in console.kept("lab")[2].edits)
        await asyncio.gather(*(edits.redo(ITSELF) for _ in range(3)))
        assert not any(one.undone_s for one in console.kept("lab")[2].edits)
        await places.add("desk", (0.3, 0.1), None, ITSELF)

        async def change(at: tuple[float, float] | None, heading: float | None) -> None:
            await places.change("desk", ITSELF, to_name=None, at=at, heading=heading, turned=at is None)

        await asyncio.gather(change((0.4, 0.2), None), change((0.5, 0.2), None), change(None, 1.0))
        [desk] = console.kept("lab")[2].places
        assert (desk.x_m, desk.y_m, desk.heading_rad) == (0.5, 0.2, 1.0)

    in_use(work, tmp_path)


def test_a_map_takes_no_more_marks_than_it_can_be_loaded_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def work(console: InUse) -> None:
        strokes = tuple(EditMark(k + 1, "free", ((12.345, -6.789),) * 60, 0.2) for k in range(MAX_EDITS))
        await console.maps.save("lab", ITSELF, replace=False)
        await console.mark(edits=strokes)
        assert console.kept("lab")[2].edits == strokes
        monkeypatch.setattr(marks, "MAX_MARKS_BYTES", 1_000_000)
        kept = (console.store.find("lab").folder / marks.MARKS).read_bytes()
        with pytest.raises(BadInput, match="is full, and nothing was changed"):
            await console.mark(places=DESK_MARKS)
        assert (console.store.find("lab").folder / marks.MARKS).read_bytes() == kept and not console.maps.marks.places

    in_use(work, tmp_path)


def test_marks_that_cannot_be_written_leave_nothing_of_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def work(console: InUse) -> None:
        def fail(*_: object) -> None:
            raise Unwritable("The disk is full.")

        await console.maps.save("lab", ITSELF, replace=False)
        monkeypatch.setattr("console.maps.service.write_marks", fail)
        both = (console.mark(places=DESK_MARKS), console.mark(edits=ERASED_CELLS))
        refused = await asyncio.gather(*both, return_exceptions=True)
        assert [type(one) for one in refused] == [Unwritable, Unwritable] and console.maps.marks == MapMarks()

    in_use(work, tmp_path)


def test_edits_are_drawn_into_their_own_map_however_its_writing_goes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def work(console: InUse) -> None:
        maps, keep = console.maps, console.maps._store.keep
        for name in ("lab", "office"):
            await maps.save(name, ITSELF, replace=False)
        await console.mark(edits=ERASED_CELLS)
        await maps.load("lab", ITSELF)
        saved = console.kept("lab")
        await maps._keep_redrawn()
        assert console.kept("lab") == saved  # the other was edited

        def fail(*_: object, **__: object) -> None:
            raise Unwritable("The disk is full.")

        def edit_meanwhile(card: MapInfo, write: Callable[[Path], None], *, replace: bool) -> None:
            keep(card, write, replace=replace)
            maps._redrawn = True

        await console.mark(edits=ERASED_CELLS)
        monkeypatch.setattr(maps._store, "keep", fail)
        with pytest.raises(Unwritable):
            await maps._keep_redrawn()
        for how, left in ((edit_meanwhile, True), (keep, False)):
            saved = console.kept("lab")
            monkeypatch.setattr(maps._store, "keep", how)
            await maps._keep_redrawn()
            assert console.kept("lab")[0] != saved[0] and maps._redrawn is left
        monkeypatch.setattr(maps._store, "keep", fail)
        with pytest.raises(Unwritable):
            await console.mark(edits=(), whole=True)
        assert maps.frame == saved[1] and maps.marks.edits == ERASED_CELLS  # a turn that cannot be saved

    in_use(work, tmp_path)
