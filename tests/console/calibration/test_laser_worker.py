"""The laser's session as a worker holds it; here in this process, before a practice room."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest

from console.calibration.codec import board_fields, camera_fields
from console.calibration.laser_worker import LaserWorker, mount_fields, resumed, state_of
from console.calibration.solver_worker import SolverWorker
from core.calibration.board.board import Board
from core.calibration.files.mount_files import read_mount
from core.calibration.mount import Mount
from core.calibration.practice import picture
from core.calibration.projection import Poses
from core.errors import BadInput, Refused
from core.message import Array
from core.optics import TABLE_3
from core.sensors.laser import Laser
from tests.practice_room import PracticeRoom, RoomSettings

BOARD = Board(columns=9, rows=6, square=0.03, panel=(0.34, 0.25))
LASER = Laser()


class Assistant:
    """Holds boards before both sensors and hands over what they deliver."""

    def __init__(self, poses: int) -> None:
        rng = np.random.default_rng(4)
        self.room = PracticeRoom(TABLE_3, LASER, BOARD, Mount().nominal, rng, RoomSettings(noise=0.01))
        self.worker = LaserWorker()
        self.given = {"board": board_fields(BOARD), "camera": camera_fields(TABLE_3), "mount": mount_fields(Mount())}
        self.worker.open(state=None, calibration=None, names=[], **self.given)
        for ranges in self.room.background(30):
            self.newest = self.sweep(ranges)
        self.verdicts = [self.hold() for _ in range(poses)]

    def sweep(self, ranges: Array) -> Any:
        told = self.worker.sweep(
            ranges.astype(np.float64).tobytes(), LASER.angle_min, LASER.angle_step, 0.02, 5.6, stamp=0.0
        )
        return msgspec.msgpack.decode(msgspec.msgpack.encode(told))

    def hold(self) -> Any:
        """One still pose → the verdict of its last scan."""
        shot = self.room.shots(1, 23)[0]
        pose = Poses(shot.rotation[None], shot.translation[None])
        grey = picture(self.room.rng, TABLE_3, pose, BOARD)
        verdict = None
        for ranges in shot.scans:
            told = self.worker.look(grey.tobytes(), 320, 256, stamp=0.0)
            verdict = told["parts"]["verdict"]
            self.newest = self.sweep(ranges)
            verdict = self.newest["parts"].get("verdict", verdict)
            if verdict["kind"] in ("counted", "same", "refused"):
                break
        return verdict


@pytest.fixture(scope="module")
def held() -> Assistant:
    return Assistant(8)


def test_still_poses_are_counted_and_solved_into_a_mount_that_can_be_accepted(held: Assistant) -> None:
    kinds = [verdict["kind"] for verdict in held.verdicts]
    assert kinds.count("counted") >= 6
    state = held.newest["state"]
    with pytest.raises(Refused):
        held.worker.accept(force=True)
    told = SolverWorker().solve_laser(state=state, **held.given)
    answer = held.worker.adopt(told["calibration"], told["names"])
    assert not answer["stale"]
    assert len(answer["parts"]["views"]) == kinds.count("counted") == told["report"]["poses_used"]
    assert set(told["exports"]) == {"json", "urdf", "static_transform", "matrix"}
    kept = held.worker.accept(force=True)
    mount = read_mount(kept["document"]["extrinsics"])
    assert np.linalg.norm(mount.translation) < 0.02
    tries = 0
    while held.hold()["kind"] != "counted":
        assert (tries := tries + 1) < 30, "no pose is new any more"
    assert held.newest["parts"]["check"]["off_px"] < 3
    room_known = held.worker.forget_room()
    state = room_known["state"]
    assert state["background"] is None and len(state["taken"]) >= 6 and len(state["rooms"]) == 1
    again = resumed(held.given["board"], held.given["camera"], held.given["mount"], state)
    rooms = [pose.background for pose in again.poses]
    assert all(room is not None and len(room) == LASER.beams for room in rooms)
    assert state_of(again)["rooms"] == state["rooms"]
    assert room_known["parts"]["progress"]["views"] == len(rooms) and room_known["parts"]["progress"]["precision"]


def test_dots_and_scan_show_which_beams_end_on_the_board(held: Assistant) -> None:
    shot = held.room.shots(1, 1)[0]
    fresh = Assistant(0)
    told = fresh.sweep(shot.scans[0])
    scan = told["parts"]["scan"]
    assert len(scan["points"]) > 500 and len(scan["background"]) > 500
    on_board = np.array(scan["points"])[scan["board"]]
    assert len(on_board) >= 10 and np.ptp(np.linalg.norm(on_board, axis=1)) < 0.5
    grey = np.full((256, 320), 128, np.uint8)
    verdict = fresh.worker.look(grey.tobytes(), 320, 256, stamp=0.0)["parts"]["verdict"]
    assert any(dot[3] for dot in verdict["laser"]) and all(0 <= dot[0] < 320 for dot in verdict["laser"])


def test_a_session_goes_on_from_plain_values(held: Assistant) -> None:
    state = held.worker.refresh()["state"]
    again = LaserWorker().open(
        state=msgspec.json.decode(msgspec.json.encode(state)), calibration=None, names=[], **held.given
    )
    assert again["stale"] and again["names"] == [pose["name"] for pose in state["taken"]]
    first, same = state["taken"][0], again["state"]["taken"][0]
    assert same["ranges_m"] == first["ranges_m"] and same["covariance"] == first["covariance"]


def test_pictures_of_another_size_are_refused(held: Assistant) -> None:
    with pytest.raises(BadInput, match="640x480"):
        held.worker.look(bytes(640 * 480), 640, 480, stamp=0.0)


def laid_out(held: Assistant, taken: list[Any]) -> tuple[LaserWorker, list[str]]:
    """A worker with the solution of these poses, while the room is looked at anew → it, and their names."""
    state = held.worker.refresh()["state"] | {"background": None, "taken": taken}
    told = SolverWorker().solve_laser(state=state, **held.given)
    worker = LaserWorker()
    worker.open(state=state, calibration=told["calibration"], names=told["names"], **held.given)
    return worker, told["names"]


def test_poses_that_are_left_out_are_not_used_all_the_same(held: Assistant) -> None:
    worker, names = laid_out(held, held.worker.refresh()["state"]["taken"])
    assert worker.accept(force=True)["report"]["poses_used"] >= 6
    for name in names[3:]:
        worker.drop(name)
    with pytest.raises(Refused, match="other views"):
        worker.accept(force=True)


def test_an_open_direction_is_named_also_while_the_room_is_looked_at_anew(held: Assistant) -> None:
    taken = held.worker.refresh()["state"]["taken"]
    alike = [pose | {"name": f"again {number}"} for number, pose in enumerate(taken[:1] * 5)]
    worker, _ = laid_out(held, alike)
    with pytest.raises(Refused, match="is not known from these poses"):
        worker.accept(force=True)
