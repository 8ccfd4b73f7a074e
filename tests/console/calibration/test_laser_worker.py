"""The laser's session as a worker holds it; here in this process, before a practice room."""

from typing import TypeVar

import msgspec
import numpy as np
import pytest

from console.calibration.answers import LaserSolution, SessionAnswer, SessionChange, SolvedViews
from console.calibration.laser_state import LaserState, StoredPose, resumed
from console.calibration.laser_worker import LaserWorker
from console.calibration.solver_worker import SolverWorker
from console.messages.calibration import CalibrationBoard, CalibrationVerdict
from console.workers.job import Job, decoder, plain
from core.calibration.board.board import Board
from core.calibration.files.mount_files import read_mount
from core.calibration.mount import Mount
from core.calibration.practice import picture
from core.calibration.projection import Poses
from core.errors import BadInput, Refused
from core.message import Array
from core.optics import TABLE_3
from core.sensors.laser import Laser, Scan
from tests.practice_room import PracticeRoom, RoomSettings

BOARD = Board(columns=9, rows=6, square=0.03, panel=(0.34, 0.25))
SHOWN = CalibrationBoard(9, 6, 0.03, (0.34, 0.25))
LASER = Laser()
T = TypeVar("T")


def opened(state: bytes = b"null", solved: SolvedViews | None = None) -> tuple[LaserWorker, SessionAnswer]:
    worker = LaserWorker()
    return worker, worker.open(SHOWN, state, solved, TABLE_3, Mount())


def solution(state: bytes) -> LaserSolution:
    asked = SHOWN, state, TABLE_3, Mount()
    return crossed(SolverWorker().solve_laser(*asked, printed=False), SolverWorker.solve_laser(*asked, printed=False))


def crossed(answer: T, job: Job[T]) -> T:
    """The answer to a job as the console decodes it."""
    return decoder(job.answer).decode(msgspec.msgpack.encode(answer, enc_hook=plain))


class Assistant:
    """Holds boards before both sensors and hands over what they deliver."""

    def __init__(self, poses: int) -> None:
        rng = np.random.default_rng(4)
        self.room = PracticeRoom(TABLE_3, LASER, BOARD, Mount().nominal, rng, RoomSettings(noise=0.01))
        self.worker, _ = opened()
        for ranges in self.room.background(30):
            self.newest = self.sweep(ranges)
        self.verdicts = [self.hold() for _ in range(poses)]

    def sweep(self, ranges: Array) -> SessionAnswer:
        scan = Scan(
            stamp=0.0,
            ranges=ranges,
            angle_min=LASER.angle_min,
            angle_step=LASER.angle_step,
            range_min=0.02,
            range_max=5.6,
        )
        return crossed(self.worker.sweep(scan), LaserWorker.sweep(scan))

    @property
    def change(self) -> SessionChange:
        """What the newest scan has changed."""
        assert self.newest.change is not None
        return self.newest.change

    def hold(self) -> CalibrationVerdict:
        """One still pose → the verdict of its last scan."""
        shot = self.room.shots(1, 23)[0]
        pose = Poses(shot.rotation[None], shot.translation[None])
        grey = picture(self.room.rng, TABLE_3, pose, BOARD)
        verdict = None
        for ranges in shot.scans:
            told = self.worker.look(grey, 0.0)
            self.newest = self.sweep(ranges)
            verdict = self.newest.verdict or told.verdict
            assert verdict is not None
            if verdict.kind in ("counted", "same", "refused"):
                break
        assert verdict is not None
        return verdict


def changed(answer: SessionAnswer) -> SessionChange:
    assert answer.change is not None
    return answer.change


def stored(state: bytes) -> LaserState:
    return msgspec.json.decode(state, type=LaserState)


@pytest.fixture(scope="module")
def held() -> Assistant:
    return Assistant(8)


def test_still_poses_are_counted_and_solved_into_a_mount_that_can_be_accepted(held: Assistant) -> None:
    kinds = [verdict.kind for verdict in held.verdicts]
    assert kinds.count("counted") >= 6
    with pytest.raises(Refused):
        held.worker.accept(force=True)
    told = solution(held.change.state)
    answer = changed(held.worker.adopt(told.solved))
    assert not answer.stale
    assert len(answer.views) == kinds.count("counted") == told.report["poses_used"]
    assert set(told.exports) == {"json", "urdf", "static_transform", "matrix"}
    kept = crossed(held.worker.accept(force=True), LaserWorker.accept(force=True))
    mount = read_mount(kept.document["extrinsics"])
    assert np.linalg.norm(mount.translation) < 0.02
    tries = 0
    while held.hold().kind != "counted":
        assert (tries := tries + 1) < 30, "no pose is new any more"
    assert held.newest.check is not None and held.newest.check.off_px < 3
    room_known = changed(held.worker.forget_room())
    state = stored(room_known.state)
    assert state.background is None and len(state.taken) >= 6 and len(state.rooms) == 1
    again = resumed(SHOWN, TABLE_3, Mount(), room_known.state)
    rooms = [pose.background for pose in again.poses]
    assert all(room is not None and len(room) == LASER.beams for room in rooms)
    assert LaserState.of(again).rooms == state.rooms
    assert room_known.progress.views == len(rooms) and room_known.progress.precision


def test_dots_and_scan_show_which_beams_end_on_the_board(held: Assistant) -> None:
    shot = held.room.shots(1, 1)[0]
    fresh = Assistant(0)
    scan = fresh.sweep(shot.scans[0]).scan
    assert scan is not None
    assert len(scan.points) > 500 and len(scan.background) > 500
    on_board = np.array(scan.points)[scan.board]
    assert len(on_board) >= 10 and np.ptp(np.linalg.norm(on_board, axis=1)) < 0.5
    grey = np.full((256, 320), 128, np.uint8)
    verdict = fresh.worker.look(grey, 0.0).verdict
    assert verdict is not None and verdict.laser is not None
    assert any(dot[3] for dot in verdict.laser) and all(0 <= dot[0] < 320 for dot in verdict.laser)


def test_a_session_goes_on_from_what_was_stored(held: Assistant) -> None:
    state = changed(held.worker.refresh()).state
    again = changed(opened(state)[1])
    assert again.stale and again.names == [pose.name for pose in stored(state).taken]
    first, same = stored(state).taken[0], stored(again.state).taken[0]
    assert same.ranges_m == first.ranges_m and same.covariance == first.covariance


def test_a_session_that_was_stored_before_poses_had_their_own_rooms_goes_on(held: Assistant) -> None:
    state = msgspec.to_builtins(stored(changed(held.worker.refresh()).state))
    room = next(room for room in state.pop("rooms") if room is not None)
    for pose in state["taken"]:
        del pose["room"]
    old = msgspec.json.encode(state | {"background": room})
    again = resumed(SHOWN, TABLE_3, Mount(), old)
    assert again.background is not None and again.poses
    for pose in again.poses:
        assert pose.background is not None
        np.testing.assert_array_equal(pose.background, again.background)


def test_pictures_of_another_size_are_refused(held: Assistant) -> None:
    with pytest.raises(BadInput, match="640x480"):
        held.worker.look(np.zeros((480, 640), np.uint8), 0.0)


def laid_out(held: Assistant, taken: list[StoredPose]) -> tuple[LaserWorker, list[str]]:
    """A worker with the solution of these poses, while the room is looked at anew → it, and their names."""
    before = stored(changed(held.worker.refresh()).state)
    state = msgspec.json.encode(msgspec.structs.replace(before, background=None, taken=taken))
    solved = solution(state).solved
    return opened(state, solved)[0], solved.names


def test_poses_that_are_left_out_are_not_used_all_the_same(held: Assistant) -> None:
    worker, names = laid_out(held, stored(changed(held.worker.refresh()).state).taken)
    assert worker.accept(force=True).report["poses_used"] >= 6
    for name in names[3:]:
        worker.drop(name)
    with pytest.raises(Refused, match="other views"):
        worker.accept(force=True)


def test_an_open_direction_is_named_also_while_the_room_is_looked_at_anew(held: Assistant) -> None:
    taken = stored(changed(held.worker.refresh()).state).taken
    alike = [msgspec.structs.replace(pose, name=f"again {number}") for number, pose in enumerate(taken[:1] * 5)]
    worker, _ = laid_out(held, alike)
    with pytest.raises(Refused, match="is not known from these poses"):
        worker.accept(force=True)
