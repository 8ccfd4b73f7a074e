"""Real time: frames are due by the clock, lost time is given up and told."""

from core.robots.process import CALM_WINDOWS, PACE_WINDOW_S, DriverPace


def test_frames_are_due_by_the_clock_whatever_each_took() -> None:
    pace = DriverPace(0.025)
    pace.start(10.0)
    for n in range(100):
        assert abs(pace.due - (10.0 + 0.025 * n)) < 1e-9
        pace.step(pace.due + (0.02 if n % 3 else 0.001))
    assert pace.share == 1.0


def test_a_hiccup_is_caught_up() -> None:
    pace = DriverPace(0.025)
    pace.start(0.0)
    pace.step(0.09)
    assert pace.due == 0.025


def test_a_long_stall_is_given_up_so_that_time_does_not_run_ahead() -> None:
    pace = DriverPace(0.025)
    pace.start(0.0)
    pace.step(5.0)
    assert pace.due == 5.0


def run(pace: DriverPace, now: float, until: float, takes: float) -> float:
    """Frames that take so long each [s], until then → the time."""
    while now < until:
        now = max(now, pace.due) + takes
        pace.step(now)
    return now


def test_a_computer_that_is_too_slow_is_told_how_slow_and_only_lasting_calm_ends_it() -> None:
    pace = DriverPace(0.025)
    pace.start(0.0)
    now = run(pace, 0.0, 35.0, 0.05)
    assert 0.45 < pace.share < 0.55
    for _ in range(3):  # quick for a while, slow again
        now = run(pace, now, now + (CALM_WINDOWS - 2) * PACE_WINDOW_S, 0.001)
        assert pace.share < 1.0
        now = run(pace, now, now + 2 * PACE_WINDOW_S, 0.035)
        assert 0.6 < pace.share < 0.9
    run(pace, now, now + (CALM_WINDOWS + 2) * PACE_WINDOW_S, 0.001)
    assert pace.share == 1.0
