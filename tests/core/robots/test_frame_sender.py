"""The newest frame wins, nothing that was sensed once is lost, and nobody waits."""

import pickle
import socket
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from core.gate import Twist
from core.geometry import Pose
from core.robots.connect import connect
from core.robots.driver_session import DriverSession
from core.robots.frame_sender import LENGTH, FrameReceiver, FrameSender, merged
from core.robots.ipc_messages import DriverTrouble, RobotAnswer
from core.sensors import Image, Scan, SensorFrame, Wheels


def frame(stamp: float, **more: object) -> SensorFrame:
    wheels = Wheels(odometry=Pose(stamp, 0.0, 0.0), speed=0.1, turn_rate=0.0)
    return replace(SensorFrame(stamp=stamp, nonce=int(stamp), wheels=wheels), **more)  # type: ignore[arg-type]


SCAN = Scan(stamp=0.5, ranges=np.array([1.0, np.nan]), angle_min=0.0, angle_step=0.1)
IMAGE = Image(stamp=0.6, pixels=np.zeros((256, 320, 3), np.uint8))


def test_a_merged_frame_is_the_newer_one_with_what_only_the_older_had() -> None:
    both = merged(
        frame(1.0, scan=SCAN, notes=("hello",), contact=True), frame(2.0, image=IMAGE, notes=("hello", "there"))
    )
    assert (both.stamp, both.nonce, both.notes, both.contact) == (2.0, 2, ("hello", "there"), True)
    assert both.scan is SCAN and both.image is IMAGE
    assert both.wheels is not None and both.wheels.odometry.x == 2.0


def test_a_newer_scan_replaces_an_older_one() -> None:
    newer = Scan(stamp=1.5, ranges=np.array([2.0]), angle_min=0.0, angle_step=0.1)
    assert merged(frame(1.0, scan=SCAN), frame(2.0, scan=newer)).scan is newer


def test_messages_come_out_as_they_went_in_however_they_are_cut() -> None:
    messages = [RobotAnswer(1, {"a": 1}), RobotAnswer(2, DriverTrouble("Refused", "No."))]
    raw = b"".join(LENGTH.pack(len(one)) + one for one in map(pickle.dumps, messages))
    for size in (1, 3, 7, len(raw)):
        inbox, out = FrameReceiver(), []
        for start in range(0, len(raw), size):
            out += inbox.feed(raw[start : start + size])
        assert out == messages


def test_arrays_stay_read_only_on_the_other_side() -> None:
    raw = pickle.dumps(frame(1.0, scan=SCAN, image=IMAGE), protocol=pickle.HIGHEST_PROTOCOL)
    (got,) = FrameReceiver().feed(LENGTH.pack(len(raw)) + raw)
    assert not got.scan.ranges.flags.writeable
    assert not got.image.pixels.flags.writeable


def test_a_listener_who_sleeps_gets_the_newest_and_the_sender_never_waits() -> None:
    here, there = socket.socketpair()
    with here, there:
        frame_sender = FrameSender(here)
        begun = time.monotonic()
        for n in range(200):
            frame_sender.put_frame(frame(float(n), image=IMAGE if n % 2 else None, scan=SCAN if n == 50 else None))
        frame_sender.put(RobotAnswer(1, {}))
        assert time.monotonic() - begun < 10.0  # a sender that waited would wait for ever
        inbox, got = FrameReceiver(), []
        there.settimeout(5.0)
        while not (got and isinstance(got[-1], SensorFrame) and got[-1].stamp == 199.0):
            got += inbox.feed(there.recv(1 << 20))
        frames = [one for one in got if isinstance(one, SensorFrame)]
        assert len(frames) < 20
        assert any(one.scan is not None for one in frames)
        assert frames[-1].nonce == 199
        assert any(isinstance(one, RobotAnswer) for one in got)
        frame_sender.close()


def test_a_listener_who_is_gone_ends_the_outbox() -> None:
    here, there = socket.socketpair()
    with here:
        frame_sender = FrameSender(here)
        there.close()
        frame_sender.put_frame(frame(1.0))
        deadline = time.monotonic() + 5.0
        while not frame_sender.gone and time.monotonic() < deadline:
            time.sleep(0.005)
        assert frame_sender.gone
        frame_sender.close()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_thread_that_fails_counts_as_gone() -> None:
    here, there = socket.socketpair()
    frame_sender = FrameSender(here)
    frame_sender.put(lambda: None)  # cannot be pickled
    ends = time.monotonic() + 5.0
    while not frame_sender.gone:
        assert time.monotonic() < ends
        time.sleep(0.005)
    frame_sender.close()
    here.close()
    there.close()


def test_a_frame_that_may_wait_goes_with_the_next_and_an_answer_does_not_wait_for_it() -> None:
    here, there = socket.socketpair()
    with here, there:
        frame_sender, inbox = FrameSender(here), FrameReceiver()
        there.settimeout(5.0)
        frame_sender.put_frame(frame(1.0, scan=SCAN), may_wait_for=1)
        frame_sender.put(RobotAnswer(1, {}))
        assert inbox.feed(there.recv(1 << 20)) == [RobotAnswer(1, {})]
        frame_sender.put_frame(frame(2.0), may_wait_for=1)
        (both,) = inbox.feed(there.recv(1 << 20))
        assert both.stamp == 2.0 and both.scan is not None
        frame_sender.put_frame(frame(3.0), may_wait_for=1)
        frame_sender.close()
        (last,) = inbox.feed(there.recv(1 << 20))
        assert last.stamp == 3.0


def test_a_standing_robots_frames_go_two_as_one_but_for_what_it_sees_and_a_moving_ones_do_not() -> None:
    session = DriverSession(connect("sim:lab"))
    try:
        rest = session.frames(1.0)
        on_the_move = session.frames(1.0, Twist(0.0, 0.5))[5:]
    finally:
        session.close()
    period = 1 / session.profile.rate

    def alone(frames: list[SensorFrame]) -> list[SensorFrame]:
        """Those that carry no reading and come one period after the frame before."""
        return [
            two
            for one, two in pairwise(frames)
            if two.scan is None and two.image is None and two.stamp - one.stamp < 1.5 * period
        ]

    assert len(rest) > 5 and not alone(rest)
    assert alone(on_the_move)


def test_while_nobody_looks_a_standing_robots_frames_are_as_many_as_its_scans_and_nothing_seen_is_lost() -> None:
    session = DriverSession(connect("sim:lab"))
    try:
        session.rest(True)
        session.drain()
        rest = session.frames(3.0)[1:]
        on_the_move = session.frames(1.0, Twist(0.0, 0.5))[5:]
    finally:
        session.close()
    period = 1 / session.profile.rate
    passed = rest[-1].stamp - rest[0].stamp
    assert passed / (len(rest) - 1) > 3.5 * period
    seen = sum(frame.scan is not None for frame in rest), sum(frame.image is not None for frame in rest)
    assert min(seen) > 0.8 * 10.0 * passed  # of ten a second; a busy computer leaves some out
    assert any(two.stamp - one.stamp < 1.5 * period for one, two in pairwise(on_the_move))
