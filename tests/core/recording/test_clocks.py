"""Clocks of a recording: what was set, what differs, what has no value."""

from pathlib import Path

import numpy as np
import pytest

from core.recording.clocks import RecorderClock, StampedStream, evenly_spread, on_one_clock, settled_stamps
from core.recording.read_report import ReadReport

TIMES = 1.7e9 + 0.1 * np.arange(100)


def codes(report: ReadReport) -> list[str]:
    return [one.code for one in report.report("test").faults]


@pytest.mark.parametrize("jump", [-5.0, 3600.0, 34e6])
def test_a_recorder_whose_clock_was_set_leaves_no_gap(jump):
    clock = RecorderClock()
    set_at = np.where(np.arange(100) < 50, TIMES, TIMES + jump)
    times = [clock.corrected(topic, time) for time in set_at for topic in ("/scan", "/odom")]
    assert len(clock.jumps_s) == 1
    assert np.diff(times[::2]).max() < 0.11 and np.diff(times[::2]).min() >= 0.0


def test_topics_that_stand_one_after_the_other_in_a_file_are_no_set_clock():
    clock = RecorderClock()
    for topic in ("/scan", "/odom"):
        assert [clock.corrected(topic, time) for time in TIMES] == TIMES.tolist()
    assert clock.jumps_s == []


def test_a_device_whose_clock_was_set_goes_on_as_it_was_recorded():
    report = ReadReport(Path("x"))
    own = np.where(np.arange(100) < 50, TIMES, TIMES - 7.0)
    settled, good = settled_stamps(StampedStream("/scan", own, TIMES + 0.02), report)
    assert good.all() and np.abs(settled.own - TIMES).max() < 0.03 and codes(report) == ["clock.set"]


@pytest.mark.parametrize("rate", [0.4, 1.0, 3.0])
def test_of_a_clock_that_runs_slower_or_faster_only_single_wrong_stamps_are_left_out(rate):
    report, times = ReadReport(Path("x")), 1.7e9 + 0.1 * np.arange(3000)
    own = 5000.0 + rate * (times - times[0])
    own[[70, 1500]] += 400.0
    settled, good = settled_stamps(StampedStream("/scan", own, times), report)
    assert np.flatnonzero(~good).tolist() == [70, 1500] and (settled.own == own).all() and codes(report) == []


def test_a_burst_on_the_way_to_the_recorder_is_no_set_clock():
    report = ReadReport(Path("x"))
    logged = TIMES.copy()
    logged[40:60] = TIMES[60]
    settled, good = settled_stamps(StampedStream("/scan", TIMES, logged), report)
    assert good.all() and (settled.own == TIMES).all() and codes(report) == []


@pytest.mark.parametrize("offset", [-1.7e9, -7200.0, 1.5, 4.0])
@pytest.mark.parametrize("moved", ["laser", "odometry"])
def test_two_clocks_are_put_on_one_by_the_recorder(offset, moved):
    report = ReadReport(Path("x"))
    laser = StampedStream("/scan", TIMES + offset * (moved == "laser"), TIMES + 0.02)
    wheels = StampedStream("/odom", TIMES + offset * (moved == "odometry"), TIMES)
    shifts = on_one_clock(laser, wheels, report)
    assert np.abs(laser.own + shifts[0] - wheels.own - shifts[1]).max() < 0.03
    assert codes(report) == ["clock.differs"]


def test_stamps_that_agree_or_cannot_be_compared_stay():
    report, scattered = ReadReport(Path("x")), TIMES + 5 * np.random.default_rng(1).random(100)
    assert on_one_clock(StampedStream("a", TIMES, TIMES), StampedStream("b", TIMES + 0.3, TIMES), report) == (
        0.0,
        0.0,
    )
    assert on_one_clock(StampedStream("a", TIMES - 9, scattered), StampedStream("b", TIMES, scattered), report) == (
        0,
        0,
    )
    assert codes(report) == []


@pytest.mark.parametrize("digits", [0, -1])
def test_rounded_stamps_are_spread_evenly(digits):
    report = ReadReport(Path("x"))
    true = 1000.0 + 0.2 * np.arange(300)
    spread = evenly_spread(np.floor(true * 10.0**digits) / 10.0**digits, report, "/scan")
    assert np.abs(np.diff(spread) - 0.2).max() < 1e-6 and codes(report) == ["clock.rounded"]


def test_stamps_without_a_value_keep_the_order_of_the_file():
    report = ReadReport(Path("x"))
    assert (np.diff(evenly_spread(np.zeros(50), report, "/scan")) > 0).all() and codes(report) == ["clock.none"]
    assert (evenly_spread(TIMES, report, "/scan") == TIMES).all()


def test_a_topic_that_pauses_while_others_go_on_is_no_set_clock():
    clock, times = RecorderClock(), 1e9 + np.arange(0.0, 900.0, 1.0)
    for number, time in enumerate(times):
        if number < 10 or number > 800:
            assert clock.corrected("/scan", time) == time
        assert clock.corrected("/odom", time) == time
    assert clock.jumps_s == []
