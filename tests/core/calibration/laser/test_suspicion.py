"""Scans in other units, turned, or of other pictures: the cause is named, and a sound set is never suspected."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.calibration.laser import session as laser_session
from core.calibration.laser.range_lines import unit_rays
from core.calibration.laser.session import LaserSession, TakenPose
from core.calibration.laser.solve import LaserPose
from core.calibration.laser.suspicion import Rival
from core.calibration.reports import laser_report
from core.errors import BadInput
from core.optics import TABLE_3
from core.pipelines.calibrate import _pairs, mount_from, sorted_by_number
from tests.core.calibration.rooms_to_practise import BOARD, a_room, poses_of

COUNT = 6


@pytest.fixture(scope="module")
def sound() -> list[LaserPose]:
    room = a_room(11, noise=0.005)
    shots = [shot for _ in range(4) for shot in room.shots(4, 10)]
    return poses_of(room, shots[:COUNT], noise=0.005)


def other(pose: LaserPose, factor: float = 1.0, along: float = 1.0, turn: float = 0.0) -> LaserPose:
    """The pose with the scan as a file in another form would have it."""
    bearings = np.arctan2(pose.scan.rays[:, 1], pose.scan.rays[:, 0])
    scan = replace(pose.scan, ranges=pose.scan.ranges * factor, rays=unit_rays(along * bearings + turn))
    return replace(pose, scan=scan)


def refusal(poses: list[LaserPose], rivals: tuple[Rival, ...] = ()) -> str:
    with pytest.raises(BadInput) as told:
        mount_from(poses, [], BOARD, TABLE_3, rivals=rivals)
    return str(told.value)


@pytest.mark.campaign
def test_a_mount_that_is_in_doubt_is_said_and_not_accepted(
    sound: list[LaserPose], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(laser_session, "MIN_POSE_COUNT", COUNT)
    session = LaserSession(BOARD, TABLE_3)
    session.taken, session.background = [TakenPose(pose) for pose in sound], np.zeros(1)
    found = session.solve()
    assert found.doubt == "" and found.extrinsics.misfit < 100
    session.adopt(replace(found, doubt="The scans show no boards."), session.names)
    assert session.progress().words == "The scans show no boards." and not session.progress().ready
    assert (
        laser_report(replace(found, doubt=session.progress().words), [""] * COUNT, BOARD, TABLE_3)["warnings"][0]
        == session.progress().words
    )


@pytest.mark.campaign
def test_the_wizard_says_that_the_laser_turns_the_other_way_and_accepts_nothing(sound: list[LaserPose]) -> None:
    session = LaserSession(BOARD, TABLE_3)
    session.background = np.zeros(1)
    session.taken = [TakenPose(other(pose, along=-1.0)) for pose in sound]
    try:
        words = session.solve().doubt
        assert session.progress().words == words or len(sound) < laser_session.MIN_POSE_COUNT
        assert not session.progress().ready
    except BadInput as wrong:
        words = str(wrong)
    assert "if its angles run the other way" in words


def test_a_sound_set_is_not_suspected(sound: list[LaserPose]) -> None:
    told = mount_from(sound, [], BOARD, TABLE_3)
    assert told["poses_used"] >= COUNT - 1


@pytest.mark.parametrize(
    ("factor", "along", "turn", "words"),
    [
        (1000.0, 1.0, 0.0, "if its ranges are in millimetres."),
        (1e-3, 1.0, 0.0, "are in metres, not in millimetres."),
        pytest.param(0.0254, 1.0, 0.0, "are in metres, not in inches.", marks=pytest.mark.campaign),
        pytest.param(25.4, 1.0, 0.0, "are in millimetres, not in inches.", marks=pytest.mark.campaign),
        pytest.param(1 / 25.4, 1.0, 0.0, "are in inches, not in millimetres.", marks=pytest.mark.campaign),
        pytest.param(1.0, -1.0, 0.0, "if its angles run the other way", marks=pytest.mark.campaign),
        pytest.param(1.0, 1.0, np.pi, "if its angles are turned by half a turn", marks=pytest.mark.campaign),
        pytest.param(
            1000.0, -1.0, 0.0, "are in millimetres and its angles run the other way", marks=pytest.mark.campaign
        ),
    ],
)
def test_another_unit_or_sense_is_named(
    sound: list[LaserPose], factor: float, along: float, turn: float, words: str
) -> None:
    assert words in refusal([other(pose, factor, along, turn) for pose in sound])


@pytest.mark.parametrize("factor", [1000.0, 39.37])
def test_scans_of_which_some_are_in_another_unit_are_told(sound: list[LaserPose], factor: float) -> None:
    mixed = [other(pose, factor) if number % 2 else pose for number, pose in enumerate(sound)]
    assert f"{COUNT // 2} of {COUNT} scans have ranges" in refusal(mixed)


@pytest.mark.campaign
def test_scans_of_other_pictures_are_suspected_by_the_order_that_fits(sound: list[LaserPose]) -> None:
    back = [replace(pose, scan=scan.scan) for pose, scan in zip(sound, sound[1:] + sound[:1], strict=True)]
    assert "goes with the scan before it" in refusal(back, (Rival("laser.other_pairing", "before it", tuple(sound)),))


@pytest.mark.parametrize(
    ("pictures", "scans", "pairs"),
    [
        (["img1", "img2", "img10"], ["scan001", "scan002", "scan010"], [("img1", "scan001"), ("img10", "scan010")]),
        (["img0", "img1", "img2"], ["s1", "s2", "s3"], [("img0", "s1"), ("img2", "s3")]),
        (["a1", "a2", "a3"], ["b1", "b2", "b3", "b4"], [("a1", "b1"), ("a3", "b3")]),
        (["1773_left", "1774_left", "1790_left"], ["1772", "1775", "1789"], [("1773_left", "1772")]),
    ],
)
def test_files_pair_by_their_numbers_and_else_in_natural_order(
    tmp_path: Path, pictures: list[str], scans: list[str], pairs: list[tuple[str, str]]
) -> None:
    for place, names, ending in (("images", pictures, ".png"), ("scans", scans, ".csv")):
        (tmp_path / place).mkdir()
        for name in names:
            (tmp_path / place / f"{name}{ending}").touch()
    found = [(one.stem, two.stem) for one, two in _pairs(tmp_path)[0]]
    assert set(pairs) <= set(found) and len(found) == 3


def test_natural_order_counts_numbers() -> None:
    names = [Path(f"img{number}.png") for number in (10, 2, 1)]
    assert [path.stem for path in sorted_by_number(names)] == ["img1", "img2", "img10"]
