import json

import numpy as np
import pytest

from core.calibration.board.board import Board
from core.calibration.camera.session import AcceptedView, CameraSession
from core.calibration.practice import ImageExposure, picture, visible
from core.calibration.projection import Poses, exponential, project, vector_of
from core.errors import BadInput, Refused
from core.message import Array
from core.optics import TABLE_3
from tests.core.calibration.seen_boards import BOARD, SIZE, some_corners

FACING = Poses(np.eye(3)[None], np.array([[-0.12, -0.075, 0.42]]))


def shot(rng: np.random.Generator, pose: Poses = FACING, exposure: ImageExposure | None = None) -> Array:
    return picture(rng, TABLE_3, pose, BOARD, exposure)


def near(rng: np.random.Generator, rotation: Array, translation: Array) -> Poses:
    """The pose as a hand would find it: 3 degrees and 2 cm off."""
    for _ in range(500):
        turned = exponential(rng.normal(0, np.deg2rad(3), (1, 3)))[0] @ rotation
        middle = rotation @ BOARD.centre + translation + rng.normal(0, 0.02, 3)
        pose = Poses(turned[None], (middle - turned @ BOARD.centre)[None])
        if visible(TABLE_3, pose, BOARD, 9.0)[0]:
            return pose
    return FACING


@pytest.mark.campaign
def test_following_the_advice_calibrates_the_camera_in_a_dozen_views() -> None:
    rng = np.random.default_rng(5)
    session = CameraSession(BOARD)
    session.look(np.full((256, 320), 128, np.uint8), 0.0)
    stamp = 1.0
    for _ in range(20):
        advice = session.advice()
        assert advice is not None and advice.words.endswith(".")
        pose = near(rng, advice.rotation, advice.translation)
        for _ in range(7):
            verdict = session.look(shot(rng, pose), stamp)
            stamp += 0.1
            if verdict.kind == "counted":
                break
        else:
            session.skip()
        if session.stale:
            session.solve()
        if session.progress().ready:
            break
    progress = session.progress()
    assert progress.ready and progress.views <= 12 and "Done" in progress.words
    assert abs(session.accept().model.fx - TABLE_3.fx) < 1.72
    known = session.uncertainty()
    assert known is not None and known.p95 < 0.5


def test_a_board_in_motion_is_not_taken_and_a_still_one_is_taken_once() -> None:
    rng = np.random.default_rng(0)
    session = CameraSession(BOARD)
    kinds = []
    for frame in range(12):
        shift = 0.006 * frame if frame < 5 else 0.03
        pose = Poses(FACING.rotations, FACING.translations + np.array([shift, 0, 0]))
        kinds.append(session.look(shot(rng, pose), 0.1 * frame).kind)
    assert kinds.count("counted") == 1 and kinds.index("counted") > 6
    assert kinds[-1] == "same" and set(kinds[:5]) == {"moving"}


def test_time_while_a_view_is_refused_is_no_time_of_holding_still() -> None:
    rng = np.random.default_rng(0)
    session = CameraSession(BOARD, still_for=0.25)
    sharp, blurred = shot(rng), shot(rng, exposure=ImageExposure(blur=3))
    pictures = ((sharp, 0.0), (sharp, 0.1), (blurred, 0.2), (blurred, 0.3), (sharp, 0.4), (sharp, 0.5), (sharp, 0.9))
    kinds = [session.look(grey, stamp).kind for grey, stamp in pictures]
    assert kinds[2:4] == ["refused"] * 2
    assert "counted" not in kinds[:6] and kinds[6] == "counted"


def test_views_that_are_missing_are_counted_once_with_the_one_that_brings_the_first_estimate() -> None:
    words = CameraSession(BOARD).progress().words
    assert words == "6 more views at least; view 4 brings a first estimate."


def test_a_blurred_view_is_refused_in_words() -> None:
    verdict = CameraSession(BOARD).capture(
        shot(np.random.default_rng(0), exposure=ImageExposure(motion=10)), "upload"
    )
    assert verdict.kind == "refused" and "Blurred" in verdict.words


def test_squares_entered_for_corners_are_noticed_while_looking() -> None:
    session = CameraSession(Board(columns=10, rows=7, square=0.03))
    verdict = session.look(shot(np.random.default_rng(0)), 0.0)
    assert verdict.kind == "nothing" and "9x6 inner corners" in verdict.words


def test_pictures_of_another_size_are_refused() -> None:
    session = CameraSession(BOARD)
    session.capture(shot(np.random.default_rng(0)), "first")
    with pytest.raises(BadInput, match=r"320x256.*begin a new session"):
        session.capture(np.zeros((480, 640), np.uint8), "second")


def test_a_picture_that_was_not_taken_does_not_fix_the_size() -> None:
    session = CameraSession(BOARD)
    blank = np.full((240, 424), 128, np.uint8)
    assert session.look(blank, 0.0).kind == "nothing" and session.size == (424, 240)
    before = session.advice()
    assert session.capture(shot(np.random.default_rng(0)), "first").kind == "counted" and session.size == SIZE
    after = session.advice()
    assert before is not None and after is not None and np.all(after.corners < SIZE)
    with pytest.raises(BadInput, match="424x240"):
        session.look(blank, 1.0)
    assert session.size == SIZE


def gathered(count: int = 8, poison: int | None = None) -> CameraSession:
    corners, _ = some_corners(count, noise=0.1, seed=12)
    session = CameraSession(BOARD)
    session.size = SIZE
    for number, view in enumerate(corners.pixels):
        spoiled = np.roll(view, 1, axis=0) if number == poison else view
        session.taken.append(AcceptedView(f"view {number + 1}", spoiled))
    return session


def test_dropping_and_restoring_a_view_makes_the_solution_stale() -> None:
    session = gathered()
    session.solve()
    assert not session.stale
    session.drop("view 3")
    assert session.stale and len(session.views) == 7
    session.solve()
    session.restore("view 3")
    assert session.stale
    with pytest.raises(BadInput):
        session.drop("view 99")


def test_the_worst_view_is_named_in_the_verdicts() -> None:
    told = gathered(10, poison=4).solve()
    assert [verdict.name for verdict in told.verdicts if verdict.reason] == ["view 5"]


def test_a_session_goes_on_where_it_was_after_a_restart() -> None:
    session = gathered()
    session.drop("view 2")
    again = CameraSession.resumed(json.loads(json.dumps(session.state())))
    assert [view.name for view in again.views] == [view.name for view in session.views]
    assert np.allclose(again.solve().covariance, session.solve().covariance)


def test_nothing_is_accepted_before_it_is_good() -> None:
    session = gathered(4)
    with pytest.raises(Refused, match="2 more views"):
        session.accept()
    with pytest.raises(BadInput, match="too few"):
        gathered(3).solve()


def test_a_solution_may_come_from_another_process() -> None:
    session = gathered()
    found = gathered().solve()
    session.adopt(found, session.names)
    assert not session.stale and session.calibration is found


def test_names_stay_unique() -> None:
    session = CameraSession(BOARD)
    rng = np.random.default_rng(0)
    session.capture(shot(rng), "upload")
    moved = Poses(FACING.rotations, FACING.translations + np.array([0.05, 0.03, 0.1]))
    assert session.capture(shot(rng, moved), "upload").name == "upload (2)"


def test_the_ghost_lies_in_the_picture() -> None:
    session = gathered()
    session.solve()
    advice = session.advice()
    assert advice is not None and session.advice() is advice
    assert np.allclose(
        advice.corners,
        project(
            vector_of(session.calibration.model),  # type: ignore[union-attr]
            Poses(advice.rotation[None], advice.translation[None]),
            BOARD.points,
        )[0],
    )
    assert np.all(advice.corners > 0) and np.all(advice.corners < SIZE)
