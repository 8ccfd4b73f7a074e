"""Scans with wrong stamps: the pilot finds out in the first turn, corrects them, and says so once."""

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from core.geometry import wrap
from core.pilot import Pilot
from core.pilot.scan_timing import ScanTiming
from core.robots import Profile
from core.sensors import Laser, SensorFrame
from core.settings import Settings
from core.slam.motion import Motion
from core.slam.scan_matching.time_offset import TimeOffset, TimeOffsetSettings
from core.snapshot import Snapshot
from tests.benchmarks.time_offset import TURNED, WAY, Leg, Stamping, driven, frames, turns

TURN: tuple[Leg, ...] = turns(1.0)["90+90"]
ONE = Profile(name="", url="", lasers=(Laser(),))


def with_laser(laser: Laser) -> Profile:
    return replace(ONE, lasers=(laser,))


def snapshots(profile: Profile, stamping: Stamping, settings: Settings | None = None) -> list[Snapshot]:
    """What the pilot publishes on a drive with turns."""
    pilot = Pilot(profile, settings)
    return [pilot.step(frame) for frame in frames("lab", TURN, stamping, 0)]


def sentences(seen: Iterable[Snapshot]) -> set[tuple[int, str]]:
    """The notices about stamps."""
    return {(one.id, one.text) for each in seen for one in each.notices if "stamped" in one.text}


def widest_error(seen: list[Snapshot]) -> float:
    """The largest error of the heading [rad] after the first second of turning."""
    poses = [(one.estimate.pose, one.truth) for one in seen if one.stamp > 2.0]
    return max(abs(wrap(pose.heading - truth.heading)) for pose, truth in poses if truth is not None)


@pytest.mark.parametrize("shift", [-0.1, pytest.param(0.1, marks=pytest.mark.campaign)])
def test_wrong_stamps_turn_the_pose_only_until_they_are_corrected(shift: float) -> None:
    left = Settings(time_offset=TimeOffsetSettings(estimate=False))
    assert widest_error(snapshots(ONE, Stamping(shift), left)) > math.radians(4)
    assert widest_error(snapshots(ONE, Stamping(shift))) < math.radians(1)


@pytest.mark.campaign
@pytest.mark.parametrize("shift", [-0.1, 0.1])
def test_after_the_first_turn_the_pose_is_as_good_as_with_right_stamps(shift: float) -> None:
    right = [driven("lab", Stamping(0.0, seed=seed), seed, WAY[:8]) for seed in range(1)]
    wrong = [driven("lab", Stamping(shift, seed=seed), seed, WAY[:8]) for seed in range(1)]
    assert not any(run.lost for run in wrong)
    for column, slack in ((0, 0.001), (1, math.radians(0.03))):
        ours, base = (np.median([run.mean(TURNED)[column] for run in runs]) for runs in (wrong, right))
        assert ours < 1.5 * base + slack


@pytest.mark.parametrize(("shift", "code", "figure"), [(-0.1, "early", 0.1), (0.1, "late", -0.1)])
def test_one_notice_names_the_offset_and_what_to_write(shift: float, code: str, figure: float) -> None:
    pilot = Pilot(ONE)
    seen = [pilot.step(frame) for frame in frames("lab", TURN, Stamping(shift), 0)]
    ((_, text),) = sentences(seen)
    (fault,) = pilot.faults
    assert fault.code == f"agreement.{code}"
    assert fault.values["sensor"] == "laser"
    assert float(fault.values["late"]) == pytest.approx(0.1, abs=0.010)
    assert "0.1" in text
    assert "time offset of the laser" in text
    (timing,) = seen[-1].timings
    assert timing.offset == pytest.approx(figure, abs=0.010)
    assert timing.applied == timing.offset


def test_right_stamps_are_left_as_they_are() -> None:
    timing, corrector = None, ScanTiming(ONE, TimeOffsetSettings())
    for frame in frames("lab", TURN, Stamping(0.0), 0):
        assert corrector.correct(frame, Motion(wheels=frame.wheels)) is frame
        timing = next(iter(corrector.offsets), None)
    assert timing is not None
    assert abs(timing.offset) < 0.010
    assert timing.applied == 0.0
    assert corrector.faults == ()


def test_a_configured_offset_counts_from_the_first_scan_and_needs_no_notice() -> None:
    seen = snapshots(with_laser(Laser(time_offset=0.1)), Stamping(-0.1))
    assert sentences(seen) == set()
    assert widest_error(seen) < math.radians(1)
    (timing,) = seen[-1].timings
    assert timing.offset == pytest.approx(0.1, abs=0.010)
    assert timing.applied == 0.1


def test_without_odometry_only_the_configured_offset_counts() -> None:
    pilot = Pilot(with_laser(Laser(time_offset=0.05)))
    corrector = ScanTiming(with_laser(Laser(time_offset=0.05)), TimeOffsetSettings())
    for frame in frames("lab", TURN[:2], Stamping(-0.1), 0):
        bare = replace(frame, wheels=None)
        assert pilot.step(bare).timings == ()
        corrected = corrector.correct(bare, Motion(by_scans=True)).scan
        assert (corrected is None) == (frame.scan is None)
        if corrected is not None and frame.scan is not None:
            assert corrected.stamp == pytest.approx(frame.scan.stamp + 0.05)


def test_every_laser_has_an_offset_of_its_own() -> None:
    profile = replace(ONE, lasers=(Laser(name="front"), Laser(name="rear")))
    corrector, offsets, number = ScanTiming(profile, TimeOffsetSettings()), dict[str, TimeOffset](), 0
    for frame in frames("lab", turns(0.5)["90+90"], Stamping(0.0), 0):
        given: SensorFrame = frame
        if frame.scan is not None:
            number += 1
            name, shift = (("front", 0.0), ("rear", 0.08))[number % 2]
            given = replace(frame, scan=replace(frame.scan, laser=name, stamp=frame.scan.stamp + shift))
        corrector.correct(given, Motion(wheels=frame.wheels))
        offsets |= {one.laser: one for one in corrector.offsets}
    assert offsets["rear"].offset == pytest.approx(-0.08, abs=0.015)
    assert [(one.code, one.sensor) for one in corrector.faults] == [("agreement.late", "rear")]


def test_a_jump_back_in_a_recording_forgets_the_offset() -> None:
    pilot, scenes = Pilot(ONE), list(frames("lab", TURN, Stamping(-0.1), 0))
    assert [pilot.step(frame) for frame in scenes][-1].timings
    assert not pilot.step(scenes[0]).timings
