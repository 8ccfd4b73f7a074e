"""The robot's clock in ours, and the age of words by the clock of a robot that waits for a slow computer."""

import time

import pytest

from console.access.logins import ANYBODY
from console.control.command_freshness import CommandFreshness, RobotTime, Spoken
from console.control.lease import Lease


def running(rate: float, *, simulated: bool, seconds: float = 20.0) -> RobotTime:
    """A robot whose clock [s] runs at this share of ours until now."""
    known, begun = RobotTime(), time.monotonic() - seconds
    known.simulated = simulated
    for frame in range(round(seconds / 0.05) + 1):
        known.note(7.0 + frame * 0.05 * rate, begun + frame * 0.05)
    return known


@pytest.mark.parametrize("rate", [0.05, 0.4, 1.0])
def test_time_passes_for_a_simulated_robot_as_its_clock_runs(rate: float) -> None:
    known, now = running(rate, simulated=True), time.monotonic()
    assert known.elapsed(now - 10.0, now) == pytest.approx(10.0 * rate, abs=0.06)
    assert running(rate, simulated=False).elapsed(now - 10.0, now) == pytest.approx(10.0)


def test_a_clock_that_runs_ahead_or_is_not_known_makes_nothing_younger_or_older_than_ours_does() -> None:
    now = time.monotonic()
    assert running(3.0, simulated=True).elapsed(now - 5.0, now) == pytest.approx(5.0)
    assert running(0.1, simulated=True, seconds=3.0).elapsed(now - 9.0, now) == pytest.approx(9.0)
    assert RobotTime().elapsed(now - 9.0, now) == pytest.approx(9.0)


def test_a_moment_of_the_robots_clock_is_known_in_ours() -> None:
    known, now = running(0.5, simulated=True), time.monotonic()
    assert known.ours(7.0 + 5.0) == pytest.approx(now - 10.0, abs=0.06)
    known.note(1.0, now)  # the robot was started again
    assert known.ours(1.0) == now


@pytest.mark.parametrize(("rate", "late"), [(1.0, True), (0.4, False)])
def test_words_are_late_by_the_clock_of_the_robot_and_stops_count_by_ours(rate: float, late: bool) -> None:
    lease = Lease()
    lease.acquire(ANYBODY, time.monotonic())
    words, now = CommandFreshness(lease), time.monotonic()
    words.time = running(rate, simulated=True)
    said = Spoken(now - 5.0, now - 4.0)
    assert ("too late" in words.why_not(said, "ears", ANYBODY)) is late
    words.void("Ann stopped the robot.", objector=ANYBODY, at=now - 3.0)
    assert words.why_not(said, "ears", ANYBODY) != ""


def test_a_console_that_stood_still_doubts_all_words_but_those_that_a_simulator_dated() -> None:
    lease = Lease()
    lease.acquire(ANYBODY, time.monotonic())
    words, now = CommandFreshness(lease), time.monotonic()
    words.stood_still(1.4, now + 0.5)
    said = Spoken(now - 0.5, now - 0.1)
    assert all("stood still" in words.why_not(said, source, ANYBODY) for source in ("voice", "ears"))
    words.time.simulated = True
    assert "stood still" in words.why_not(said, "voice", ANYBODY) and words.why_not(said, "ears", ANYBODY) == ""
