import dataclasses

import numpy as np
import pytest

from core.calibration.board.board import Board
from core.calibration.board.session import BoardVerdict
from core.calibration.laser import session as laser_session
from core.calibration.laser.session import POSE_SCANS, LaserSession
from core.calibration.laser.solve import calibrate_laser, check, dots
from core.calibration.mount import Mount
from core.calibration.practice import picture, visible
from core.calibration.projection import Poses, exponential
from core.errors import BadInput, Refused
from core.message import Array
from core.optics import TABLE_3
from core.sensors.laser import Scan
from tests.core.calibration.rooms_to_practise import BOARD, a_room, error_of
from tests.practice_room import PracticeRoom

FACING = Poses(exponential(np.array([[0.5, 0.2, 0.0]])), np.array([[-0.12, -0.06, 0.6]]))


def scan_of(room: PracticeRoom, ranges: Array) -> Scan:
    return Scan(stamp=0.0, ranges=ranges, angle_min=room.laser.angle_min, angle_step=room.laser.angle_step)


def shown(session: LaserSession, room: PracticeRoom, pose: Poses) -> BoardVerdict | None:
    """Hold one pose still until something comes of it."""
    shots = room.shots(1, 25, poses=pose)
    if not shots:
        return None
    verdict, grey = None, picture(room.rng, TABLE_3, pose, BOARD)
    for ranges in shots[0].scans:
        verdict = session.look(grey)
        verdict = session.sweep(scan_of(room, ranges)) or verdict
        if verdict.kind in ("counted", "same"):
            return verdict
    return verdict


def begun(room: PracticeRoom) -> LaserSession:
    session = LaserSession(BOARD, TABLE_3)
    for ranges in room.background(30):
        session.sweep(scan_of(room, ranges))
    return session


@pytest.mark.campaign
def test_following_the_advice_finds_the_mount_without_a_click() -> None:
    room = a_room(3)
    session = begun(room)
    for _ in range(25):
        advice = session.advice()
        assert advice is not None
        for _ in range(300):
            turned = exponential(room.rng.normal(0, np.deg2rad(3), (1, 3)))[0] @ advice.rotation
            middle = advice.rotation @ BOARD.centre + advice.translation + room.rng.normal(0, 0.02, 3)
            pose = Poses(turned[None], (middle - turned @ BOARD.centre)[None])
            if visible(TABLE_3, pose, BOARD, 9.0)[0]:
                break
        shown(session, room, pose)
        if session.stale:
            session.solve()
        if session.progress().ready:
            break
    progress = session.progress()
    assert progress.ready and progress.weak == () and "Done" in progress.words
    found = session.accept().extrinsics
    turn, shift = error_of(found.transform, room)
    assert turn < 1.0 and shift < 8.0
    proof = check(session.poses[-1], found, BOARD, TABLE_3)
    assert proof.residual_rms < 0.02 and proof.off < 3 and proof.beams > 10
    points, _ = dots(scan_of(room, room.background(1)[0]), found.transform, TABLE_3)
    assert len(points) > 50 and np.all(points[:, 0] < 320)


def test_the_empty_room_comes_first() -> None:
    room = a_room(0)
    session = LaserSession(BOARD, TABLE_3)
    verdict = session.look(picture(room.rng, TABLE_3, FACING, BOARD))
    assert verdict.kind == "background" and "empty room" in verdict.words
    assert "empty room" in session.progress().words
    for ranges in room.background(30):
        verdict = session.sweep(scan_of(room, ranges)) or verdict
    assert "Now show the board" in verdict.words


def test_poses_keep_the_empty_room_in_which_they_were_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    room = a_room(1)
    session = begun(room)
    nearer = Poses(FACING.rotations, FACING.translations - np.array([0.0, 0.0, 0.15]))
    turned = Poses(exponential(np.array([[0.1, 0.6, 0.0]])), FACING.translations)
    for pose in (FACING, nearer, turned):
        shown(session, room, pose)
    empty, poses = session.background, session.poses
    assert len(poses) == 3 and all(pose.background is empty for pose in poses)
    before = calibrate_laser(poses, BOARD)
    session.adopt(before, session.names)
    session.forget_room()
    progress = session.progress()
    assert progress.poses == 3 and len(progress.precision) == 6 and "empty room" in progress.words
    monkeypatch.setattr(laser_session, "MIN_POSE_COUNT", 3)
    assert "empty room" not in session.progress().words or session.progress().weak
    session.background = np.full(len(room.rays), 0.05)
    after = session.solve()
    assert all(np.array_equal(one, other) for one, other in zip(before.beams, after.beams, strict=True))
    closer = calibrate_laser([dataclasses.replace(pose, background=None) for pose in poses], BOARD, empty)
    assert np.allclose(closer.extrinsics.transform.translation, after.extrinsics.transform.translation)


def test_the_same_pose_is_not_taken_twice() -> None:
    room = a_room(1)
    session = begun(room)
    first, second = shown(session, room, FACING), shown(session, room, FACING)
    assert first is not None and first.kind == "counted" and first.beams is not None and len(first.beams) >= 10
    assert second is not None and second.kind == "same" and "pose 1" in second.words


def test_a_board_that_moves_is_not_taken() -> None:
    room = a_room(2)
    session = begun(room)
    scans = room.shots(1, 25, poses=FACING)[0].scans
    kinds = []
    for number, ranges in enumerate(scans):
        pose = Poses(FACING.rotations, FACING.translations + np.array([0.004 * number, 0, 0]))
        kinds.append(session.look(picture(room.rng, TABLE_3, pose, BOARD)).kind)
        kinds.append(getattr(session.sweep(scan_of(room, ranges)), "kind", ""))
    assert "counted" not in kinds and "moving" in kinds


def test_a_board_that_the_laser_misses_is_said_in_words() -> None:
    room = a_room(2)
    session = begun(room)
    empty = room.background(30)
    verdict, grey = None, picture(room.rng, TABLE_3, FACING, BOARD)
    for ranges in empty:
        session.look(grey)
        verdict = session.sweep(scan_of(room, ranges)) or verdict
        if verdict is not None and verdict.kind == "refused":
            break
    assert verdict is not None and verdict.kind == "refused" and "does not meet the board" in verdict.words


def test_scans_without_pictures_prove_nothing() -> None:
    room = a_room(2)
    session = begun(room)
    scans = room.shots(1, 25, poses=FACING)[0].scans
    for _ in range(3):
        session.look(picture(room.rng, TABLE_3, FACING, BOARD))
    verdicts = [session.sweep(scan_of(room, ranges)) for ranges in scans]
    assert any(verdict is not None and "No pictures" in verdict.words for verdict in verdicts)
    assert session.taken == []


def test_an_upright_board_is_only_turned_and_what_was_measured_is_said() -> None:
    room = a_room(5)
    session = LaserSession(BOARD, TABLE_3, Mount.measured(0.05))
    for ranges in room.background(30):
        session.sweep(scan_of(room, ranges))
    advice = session.advice()
    assert advice is not None and np.allclose(advice.rotation[1], [0, 1, 0], atol=1e-9)
    progress = session.progress()
    assert progress.from_ruler == {"roll": "as level", "pitch": "as level", "height": "by ruler"}
    assert progress.known_from == 0.7


def test_a_board_of_another_size_is_noticed() -> None:
    room = a_room(2)
    session = LaserSession(Board(columns=10, rows=7, square=0.03), TABLE_3)
    session.background = np.full(len(room.rays), 3.0)
    grey = picture(room.rng, TABLE_3, FACING, BOARD)
    assert "9x6 inner corners" in session.look(grey).words


def test_nothing_is_accepted_too_early_and_names_must_exist() -> None:
    session = begun(a_room(0))
    with pytest.raises(Refused, match="more poses"):
        session.accept()
    with pytest.raises(BadInput):
        session.drop("pose 7")
    with pytest.raises(BadInput):
        session.solve()


def test_a_laser_that_changes_its_beams_is_noticed() -> None:
    room = a_room(0)
    session = begun(room)
    with pytest.raises(BadInput, match="number of beams"):
        session.sweep(scan_of(room, np.ones(10)))
    assert POSE_SCANS == 20
