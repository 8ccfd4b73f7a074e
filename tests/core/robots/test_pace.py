"""Real time: frames are due by the clock, lost time is given up and told."""

from __future__ import annotations

from core.robots.process import Pace


def test_frames_are_due_by_the_clock_whatever_each_took() -> None:
    pace = Pace(0.025)
    pace.start(10.0)
    for n in range(100):
        assert abs(pace.due - (10.0 + 0.025 * n)) < 1e-9
        assert pace.step(pace.due + (0.02 if n % 3 else 0.001)) == ""


def test_a_hiccup_is_caught_up() -> None:
    pace = Pace(0.025)
    pace.start(0.0)
    pace.step(0.09)
    assert pace.due == 0.025


def test_a_long_stall_is_given_up_so_that_time_does_not_run_ahead() -> None:
    pace = Pace(0.025)
    pace.start(0.0)
    pace.step(5.0)
    assert pace.due == 5.0


def test_a_computer_that_is_too_slow_is_told_so_now_and_then() -> None:
    pace, now, remarks = Pace(0.025), 0.0, []
    pace.start(now)
    for _ in range(1000):
        now = max(now, pace.due) + 0.05
        remarks += filter(None, [pace.step(now)])
    assert 3 <= len(remarks) <= 6
    assert remarks[0].startswith("This computer is too slow")
    assert "50%" in remarks[-1]
