"""Beckon's own recordings are read back to the last bit, whatever their length, and wherever they are cut."""

import base64
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from core.gate import Twist
from core.recording.drive import CAMERA_TOPIC, HELD_CHUNKS, DriveRecording, is_drive
from core.recording.frame_record import FrameRecord
from core.recording.mcap_writing import McapRecording
from core.recording.recording import LogSettings
from core.recording.ros_writing import RosEncoder
from core.robots.requests import SetListening, Speak
from core.sensors import Laser, SensorFrame
from core.sensors.recordable import recordable
from core.simulation.faulty_robot import open_robot

BEGAN_S = 1_790_000_000.0  # Unix time
FRAMES = 120


def sensed() -> Iterator[SensorFrame]:
    """Three seconds of a robot that drives and hears, with a second laser and a second camera."""
    robot = open_robot("lab", seed=5, settings=None)
    robot.ask(SetListening(on=True))
    robot.ask(Speak(x_m=1.0, y_m=0.5, text="turn left"))
    scans = pictures = 0
    for number in range(FRAMES):
        robot.drive(Twist(0.1, 0.3))
        frame = robot.read()
        scans, pictures = scans + (frame.scan is not None), pictures + (frame.image is not None)
        if frame.scan is not None and scans % 2:
            frame = replace(frame, scan=replace(frame.scan, laser="rear"))
        if frame.image is not None and pictures % 3 == 0:
            frame = replace(frame, image=replace(frame.image, camera="back"))
        yield recordable(replace(frame, battery=0.1 * 3, contact=number == 50))


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[SensorFrame], Path]:
    path = tmp_path_factory.mktemp("drive") / "a drive.mcap"
    encoder = RosEncoder((Laser(), Laser(name="rear")))
    recording, frames = McapRecording(path), list(sensed())
    for number, frame in enumerate(frames):
        messages = [*encoder.fixed(frame.stamp)] if number == 0 else []
        messages += [encoder.frame(FrameRecord.of(frame)), *encoder.readings(frame)]
        recording.add(messages, BEGAN_S + number / 40)
        if number % 20 == 0:
            recording.flush()
    recording.finish()
    return frames, path


def same(one: object, other: object) -> bool:
    """Equal to the last bit, fields and arrays."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.dtype == other.dtype and one.tobytes() == other.tobytes()
    if hasattr(one, "__dataclass_fields__"):
        return type(one) is type(other) and all(same(getattr(one, key), getattr(other, key)) for key in vars(one))
    return one == other


def test_every_reading_comes_back_to_the_last_bit(written: tuple[list[SensorFrame], Path]) -> None:
    frames, path = written
    drive = DriveRecording(path)
    again = list(drive)
    assert len(again) == len(frames) == FRAMES
    for one, other in zip(frames, again, strict=True):
        assert same(replace(one, sensed=0.0, nonce=0), other)
    assert any(one.sound is not None for one in again) and any(one.image is not None for one in again)
    assert {one.scan.laser for one in again if one.scan is not None} == {"", "rear"}
    assert {one.image.camera for one in again if one.image is not None} == {"", "back"}
    assert drive.duration == pytest.approx((FRAMES - 1) / 40, abs=1e-6)
    assert drive.report.skipped == 0 and is_drive(path)


def test_it_is_read_from_any_time_on(written: tuple[list[SensorFrame], Path]) -> None:
    frames, path = written
    drive = DriveRecording(path)
    for since in (0.0, 0.49, 1.7, 2.9):
        first = next(drive.moments(since))
        assert first.frame.stamp == next(one.stamp for n, one in enumerate(frames) if n / 40 >= since - 1e-6)
    newest = drive.latest(CAMERA_TOPIC, 1.5)
    assert newest is not None and BEGAN_S + 1.2 < newest.logged <= BEGAN_S + 1.5 + 1e-6
    assert drive.latest(CAMERA_TOPIC, -1.0) is None


@pytest.mark.parametrize("share", [0.3, 0.7, 0.95])
def test_a_cut_one_is_read_as_far_as_it_goes(
    written: tuple[list[SensorFrame], Path], share: float, tmp_path: Path
) -> None:
    frames, path = written
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    drive = DriveRecording(cut)
    again = list(drive)
    assert 0 < len(again) < FRAMES
    stamps = [one.stamp for one in again]
    assert stamps == [one.stamp for one in frames[: len(stamps)]]
    assert all(after > before for before, after in pairwise(stamps))
    assert "not finished" in " ".join(drive.report.warnings)


def test_it_may_be_read_as_often_as_somebody_plays_it(tmp_path: Path) -> None:
    encoder, recording = RosEncoder((Laser(),)), McapRecording(tmp_path / "long.mcap")
    chunks = HELD_CHUNKS + 4
    for number in range(chunks):
        frame = FrameRecord(stamp=float(number), notes=("a" * 300_000,))
        recording.add([encoder.frame(frame)], BEGAN_S + number / 40)
    drive = DriveRecording(recording.finish().path, LogSettings(largest_block_mb=1.0))
    assert [sum(1 for _ in drive.moments()) for _ in range(6)] == [chunks] * 6
    assert drive.report.skipped == 0


def test_a_moment_that_goes_on_in_the_next_chunk_is_found_whole(tmp_path: Path) -> None:
    encoder, recording = RosEncoder((Laser(),)), McapRecording(tmp_path / "straddling.mcap")
    for number in range(5):
        noise = base64.b64encode(np.random.default_rng(3).bytes(250_000)).decode() if number == 3 else ""
        logged, frame = BEGAN_S + number / 10, FrameRecord(stamp=float(number), notes=(noise,))
        recording.add([encoder.frame(frame), encoder.text("/map", logged, f"grid {number}")], logged)
    drive = DriveRecording(recording.finish().path)
    found = [drive.moment_of(one) for one in drive.every("/map")]
    assert [one.record.stamp for one in found if one is not None and one.record is not None] == [0, 1, 2, 3, 4]
    sought = next(drive.moments(0.3))
    assert sought.record is not None and sought.record.stamp == 3
