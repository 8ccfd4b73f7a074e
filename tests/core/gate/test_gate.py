"""The gate on simulated time: every way to stop, and every order that must not move."""

import math
from collections.abc import Callable
from dataclasses import replace

import pytest

from core.gate import Gate, Limits, Setpoint
from core.gate.gate import MAX_REMEMBERED_PRESSES, Presses
from core.gate.setpoint import Source
from core.gate.status import EXPIRED, TOO_BUSY, GateStatus
from tests.core.gate.bench import Bench, motion_after


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    assert bench.complaints() == []


def test_it_begins_disarmed_and_nothing_moves_it(bench: Bench) -> None:
    fresh = Bench(armed=False)
    assert fresh.gate.status().state == "disarmed"
    fresh.hold("jog", 0.2, seconds=0.5)
    fresh.hold("goal", 0.2, seconds=0.5)
    assert motion_after(fresh.rows, 0.0) == []
    assert fresh.gate.status().refused == "The robot is not armed."


def test_what_was_refused_while_halted_is_not_said_of_what_comes_after_the_reset(bench: Bench) -> None:
    bench.hold("goal", 0.3, seconds=0.3)
    bench.gate.halt(bench.now)
    bench.goal(0.3)
    assert bench.gate.status().refused == "The robot is halted."
    bench.gate.reset(bench.now)
    bench.gate.arm(2, "anna", bench.now)
    assert bench.gate.status().refused == ""


def test_a_hand_drives_and_the_speed_ramps(bench: Bench) -> None:
    bench.hold("jog", 0.3, seconds=0.1)
    assert bench.speed == pytest.approx(0.1)
    bench.hold("jog", 0.3, seconds=0.4)
    assert bench.speed == 0.3
    assert bench.gate.status().source == "jog"


def test_a_released_key_is_zero_at_once(bench: Bench) -> None:
    bench.hold("jog", 0.3, seconds=0.5)
    bench.jog(0.0)
    assert bench.speed == 0.0
    assert bench.jog(0.3) == ""  # the same press may go on: a stick passes through its middle


def test_too_much_is_cut_to_the_limits(bench: Bench) -> None:
    bench.hold("jog", 1e9, -1e9, seconds=1.0)
    assert (bench.speed, bench.gate.twist.w) == (0.3, -1.5)


@pytest.mark.parametrize("cap", [0.0, 0.05, 0.2, 5.0, -1.0])
@pytest.mark.parametrize("source", ["jog", "goal"])
def test_a_cap_only_lowers_the_speed_and_holds_until_it_is_lifted(bench: Bench, source: Source, cap: float) -> None:
    bench.hold(source, 0.3, seconds=0.5)
    bench.gate.cap(cap)
    begun = bench.now
    bench.hold(source, 0.3, seconds=1.0)
    slowed = 0.3 / bench.gate.limits.max_acceleration  # [s]
    fastest = max(abs(row.v) for row in bench.rows if row.t_mono_ns * 1e-9 > begun + slowed + 0.1)
    assert fastest == pytest.approx(min(max(cap, 0.0), 0.3), abs=1e-9)
    bench.gate.cap(None)
    bench.hold(source, 0.3, seconds=0.5)
    assert bench.speed == 0.3


@pytest.mark.parametrize("source", ["jog", "goal"])
def test_silence_stops_within_the_deadman(bench: Bench, source: str) -> None:
    bench.hold(source, 0.3, seconds=0.5)  # type: ignore[arg-type]
    last = bench.now
    bench.run(0.5)
    moving = motion_after(bench.rows, last)
    assert max(row.t_mono_ns for row in moving) * 1e-9 <= last + 0.25 + 1e-6
    status = bench.gate.status()
    assert (status.trips, status.holds, status.need_neutral) == (source == "jog", source == "goal", True)
    assert status.reason.startswith("silence")
    bench.run(2.0)
    bench.hold(source, 0.3, seconds=0.5)  # type: ignore[arg-type]
    assert bench.speed == 0.0  # the press that was held through the trip is over


def test_after_a_trip_a_hand_lets_go_and_presses_again(bench: Bench) -> None:
    bench.hold("jog", 0.3, press=5, seconds=0.3)
    bench.run(0.4)
    assert bench.jog(0.3, press=6) == "Let go first, then press again."
    bench.let_go()
    assert bench.jog(0.3, press=5).startswith("This was stopped")
    assert bench.jog(0.3, press=6).startswith("This was stopped")  # it was held before the neutral order
    assert bench.jog(0.3, press=7) == ""


def test_a_zero_order_from_before_the_stop_does_not_count_as_letting_go(bench: Bench) -> None:
    bench.hold("jog", 0.3, seconds=0.3)
    before = bench.order("jog", 0.0, 0.0, 1)
    bench.gate.stop(bench.now)
    assert bench.gate.accept(before, bench.now) == ""
    assert bench.gate.status().need_neutral


def test_frames_buffered_through_a_freeze_move_nothing(bench: Bench) -> None:
    bench.hold("jog", 0.3, seconds=0.5)
    frozen = bench.now
    kept: list[Setpoint] = []
    nonce = bench.gate.status().nonce  # the page sees no newer one: its link is frozen both ways
    for n in range(30):
        if n % 3 == 0:
            kept.append(bench.order("jog", 0.3, 0.0, 1, nonce=nonce))
        bench.run(0.05)
    stopped = [row for row in bench.rows if row.event == "trip"][-1].t_mono_ns * 1e-9
    assert stopped <= frozen + 0.28
    for frame in kept:  # the link is back, the operator is gone
        assert bench.gate.accept(frame, bench.now) != ""
        bench.tick()
    bench.run(0.5)
    assert motion_after(bench.rows, stopped) == []


def test_frames_that_only_trickle_in_are_bounded_by_their_nonce(bench: Bench) -> None:
    """A link that lets frames out one by one, each late: the deadman is fed, the nonce is not."""
    bench.hold("jog", 0.3, seconds=0.5)
    start, nonce = bench.now, bench.gate.status().nonce
    for _ in range(50):
        bench.gate.accept(bench.order("jog", 0.3, 0.0, 1, nonce=nonce), bench.now)
        bench.tick()
    moving = motion_after(bench.rows, start)
    assert max(row.t_mono_ns for row in moving) * 1e-9 <= start + 0.4 + 0.25 + 0.021


def test_a_frame_counts_once(bench: Bench) -> None:
    frame = bench.order("jog", 0.3, 0.0, 1)
    assert bench.gate.accept(frame, bench.now) == ""
    assert bench.gate.accept(frame, bench.now).startswith("Stale")


def test_an_older_frame_does_not_undo_a_newer_one(bench: Bench) -> None:
    old, new = bench.order("jog", 0.3, 0.0, 1), bench.order("jog", 0.0, 0.0, 1)
    assert bench.gate.accept(new, bench.now) == ""
    assert bench.gate.accept(old, bench.now).startswith("Stale")


@pytest.mark.parametrize("epoch", [0, 2])
def test_another_epoch_is_refused(bench: Bench, epoch: int) -> None:
    assert "another lease" in bench.jog(0.3, epoch=epoch)


def test_an_invented_nonce_is_refused(bench: Bench) -> None:
    newest = bench.gate.status().nonce
    for nonce in (0, newest + 1, newest + 1000):
        assert bench.gate.accept(bench.order("jog", 0.3, 0.0, 1, nonce=nonce), bench.now).startswith("Old")


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, True, "0.3", None, [0.3], 10**400])
@pytest.mark.parametrize("field", ["v", "w"])
def test_a_speed_that_is_no_number_is_zero_and_a_fault(bench: Bench, field: str, bad: object) -> None:
    bench.hold("jog", 0.3, seconds=0.3)
    frame = replace(bench.order("jog", 0.3, 0.1, 1), **{field: bad})
    assert bench.gate.accept(frame, bench.now) == "A speed is not a finite number."
    assert bench.speed == 0.0
    assert bench.gate.status().trips == 1


@pytest.mark.parametrize(
    ("field", "bad"),
    [
        *[(name, bad) for name in ("epoch", "seq", "press", "nonce") for bad in (True, 1.0, -1, "1", None, 2**53)],
        ("source", "speech"),
        ("source", None),
        ("source", []),
    ],
)
def test_a_malformed_order_is_refused(bench: Bench, field: str, bad: object) -> None:
    setpoint = replace(bench.order("jog", 0.3, 0.0, 1), **{field: bad})
    assert bench.gate.accept(setpoint, bench.now) == "The setpoint is malformed."


def test_stop_is_zero_at_once_and_a_new_goal_may_run(bench: Bench) -> None:
    bench.hold("goal", 0.3, press=3, seconds=0.5)
    bench.gate.stop(bench.now)
    assert bench.speed == 0.0
    bench.tick()
    assert bench.goal(0.3, press=3).startswith("This command was stopped")
    assert bench.goal(0.3, press=4) == ""


def test_stop_needs_no_arming() -> None:
    bench = Bench(armed=False)
    bench.gate.stop(bench.now)
    assert bench.gate.status().reason == "stopped"


def test_orders_that_were_under_way_when_stop_came_do_not_move(bench: Bench) -> None:
    under_way = [bench.order("goal", 0.3, 0.0, press) for press in range(5)]
    bench.gate.stop(bench.now)
    assert all(bench.gate.accept(order, bench.now) for order in under_way)
    bench.run(0.2)
    assert motion_after(bench.rows, 0.0) == []


def test_halt_is_latched_until_reset_and_reset_does_not_move(bench: Bench) -> None:
    bench.hold("jog", 0.3, seconds=0.5)
    bench.gate.halt(bench.now)
    halted = bench.now
    bench.hold("jog", 0.3, seconds=0.3)
    assert bench.gate.arm(2, "bob", bench.now) == "The robot is halted: reset the halt first."
    bench.gate.stop(bench.now)
    bench.gate.disarm(bench.now)
    assert bench.gate.status().state == "halted"
    bench.gate.reset(bench.now)
    assert bench.gate.status().state == "disarmed"
    bench.hold("jog", 0.3, seconds=0.3)
    assert bench.gate.arm(1, "ann", bench.now) == ""
    bench.hold("jog", 0.3, seconds=0.3)  # the key is still held
    assert motion_after(bench.rows, halted) == []
    bench.let_go()
    assert bench.jog(0.3, press=9) == ""


def test_a_halted_gate_wakes_halted() -> None:
    bench = Bench(halted=True, armed=False)
    assert bench.gate.status().state == "halted"
    assert bench.gate.arm(1, "ann", bench.now) != ""


def test_reset_without_a_halt_does_nothing(bench: Bench) -> None:
    bench.hold("jog", 0.3, seconds=0.5)
    bench.gate.reset(bench.now)
    assert bench.gate.status().state == "armed"
    assert bench.speed == 0.3


def test_a_takeover_goes_through_zero_and_needs_a_new_press(bench: Bench) -> None:
    bench.hold("jog", 0.3, press=1, seconds=0.5)
    assert bench.gate.arm(2, "bob", bench.now) == ""
    assert bench.speed == 0.0
    bench.tick()
    assert "another lease" in bench.jog(0.3, press=1, epoch=1)
    assert bench.jog(0.3, press=1, epoch=2) == "Let go first, then press again."
    bench.jog(0.0, epoch=2)
    assert bench.jog(0.3, press=2, epoch=2) == ""
    assert bench.gate.status().owner == "bob"


def test_an_old_lease_cannot_come_back(bench: Bench) -> None:
    assert bench.gate.arm(2, "bob", bench.now) == ""
    assert bench.gate.arm(1, "ann", bench.now) == "An older lease cannot be armed."
    assert "one holder" in bench.gate.arm(2, "ann", bench.now)


@pytest.mark.parametrize("epoch", [-1, True, 1.5, "3", None])
def test_an_epoch_is_a_count(bench: Bench, epoch: object) -> None:
    assert bench.gate.arm(epoch, "ann", bench.now) != ""  # type: ignore[arg-type]


def test_arming_again_in_the_same_words_changes_nothing(bench: Bench) -> None:
    bench.hold("jog", 0.3, seconds=0.5)
    assert bench.gate.arm(1, "ann", bench.now) == ""
    assert bench.speed == 0.3


def test_disarmed_it_obeys_nobody_and_a_goal_does_not_resume(bench: Bench) -> None:
    bench.hold("goal", 0.3, press=3, seconds=0.3)
    bench.gate.disarm(bench.now, "the lease was released")
    assert bench.speed == 0.0
    assert bench.goal(0.3, press=3) == "The robot is not armed."
    assert bench.gate.arm(1, "ann", bench.now) == ""
    bench.tick()
    assert bench.goal(0.3, press=3).startswith("This command was stopped")


def test_a_hand_beats_a_goal_and_the_goal_does_not_resume(bench: Bench) -> None:
    bench.hold("goal", 0.2, press=3, seconds=0.3)
    assert bench.jog(-0.1, press=8) == ""
    assert bench.goal(0.2, press=3) != ""
    assert bench.goal(0.2, press=4) != ""  # told while a hand drives
    bench.jog(0.0, press=8)
    assert bench.goal(0.2, press=3) != ""
    assert bench.goal(0.2, press=4) != ""
    assert bench.goal(0.2, press=5) == ""


def test_a_touch_of_the_keys_ends_a_goal_for_good(bench: Bench) -> None:
    bench.hold("goal", 0.2, press=3, seconds=0.3)
    assert bench.jog(-0.1, press=8) == ""
    assert bench.jog(0.0, press=8) == ""
    assert bench.goal(0.2, press=3).startswith("This command was stopped")


def test_a_nonce_expires_also_while_the_gate_is_frozen(bench: Bench) -> None:
    order = bench.order("jog", 0.2, 0.0, 1)
    bench.now += 0.41
    bench.gate.heartbeat(bench.now)
    assert bench.gate.accept(order, bench.now).startswith("Old")


def test_a_refused_hand_does_not_disturb_a_goal(bench: Bench) -> None:
    bench.gate.stop(bench.now)
    bench.tick()
    bench.hold("goal", 0.2, press=3, seconds=0.3)
    assert bench.jog(0.1, press=8) == "Let go first, then press again."
    assert bench.goal(0.2, press=3) == ""


def test_a_command_that_was_replaced_does_not_come_back(bench: Bench) -> None:
    bench.hold("goal", 0.2, press=3, seconds=0.1)
    bench.hold("goal", 0.1, press=4, seconds=0.1)
    assert bench.goal(0.2, press=3).startswith("This command was stopped")
    assert bench.goal(0.1, press=4) == ""


def test_a_stop_also_ends_a_command_that_has_not_moved_yet(bench: Bench) -> None:
    assert bench.goal(0.0, press=3) == ""
    bench.gate.stop(bench.now)
    bench.tick()
    assert bench.goal(0.2, press=3).startswith("This command was stopped")


def test_an_idle_hand_does_not_disturb_a_goal(bench: Bench) -> None:
    bench.hold("goal", 0.2, press=3, seconds=0.3)
    assert bench.jog(0.0) == ""
    assert bench.goal(0.2, press=3) == ""
    assert bench.gate.status().source == "goal"


def test_a_waiting_goal_does_not_disturb_a_hand(bench: Bench) -> None:
    bench.hold("jog", 0.3, seconds=0.5)
    assert bench.goal(0.0, press=3) == ""
    assert bench.speed == 0.3


def test_a_silent_console_trips(bench: Bench) -> None:
    bench.hold("goal", 0.3, seconds=0.5)
    bench.beats = False
    died = bench.now
    bench.hold("goal", 0.3, seconds=0.5)
    moving = motion_after(bench.rows, died)
    assert max(row.t_mono_ns for row in moving) * 1e-9 <= died + 0.15 + 1e-6
    assert bench.goal(0.3, press=2) == "The console's heartbeat is missing."


def test_a_late_tick_trips(bench: Bench) -> None:
    bench.hold("jog", 0.3, seconds=0.5)
    bench.now += 0.1
    bench.jog(0.3)
    bench.tick()
    assert bench.speed == 0.0
    assert bench.gate.status().reason == "the gate was late"
    assert "beckon doctor" in bench.gate.status().stopped_because


def test_a_command_that_a_busy_computer_ended_says_what_can_be_done(bench: Bench) -> None:
    bench.hold("goal", 0.3, seconds=0.5)
    bench.run(2.5)  # the console lives, and its orders do not come
    status = bench.gate.status()
    assert status.trips == 1 and status.reason.startswith("silence")
    assert "too busy to steer" in status.stopped_because and "beckon doctor" in status.stopped_because
    assert replace(status, reason="no scan comes").stopped_because == "The robot stopped by itself: no scan comes."


@pytest.mark.parametrize("back", [0.001, 0.1, 5.0])
def test_time_that_runs_backwards_trips(bench: Bench, back: float) -> None:
    bench.hold("jog", 0.3, seconds=0.5)
    bench.gate.tick(bench.now - back)
    assert bench.speed == 0.0
    assert bench.gate.status().reason == "the gate's clock ran backwards"
    bench.trace.rows.clear()


def test_where_the_clock_was_set_back_nothing_of_before_counts_as_fresh(bench: Bench) -> None:
    bench.hold("jog", 0.0, seconds=0.5)
    early = bench.gate.nonce
    bench.now -= 2.0
    bench.scans = False
    bench.run(0.1)
    late = bench.order("goal", 0.2, 0.0, 9, nonce=early)
    assert bench.gate.accept(late, bench.now) == "It was sent before the robot was stopped."
    bench.hold("jog", 0.2, seconds=1.0)
    assert bench.speed == 0.0 and bench.gate.status().reason == "waiting for a fresh scan"
    bench.scans = True
    bench.hold("jog", 0.2, seconds=0.4)
    assert bench.speed == 0.2
    bench.trace.rows.clear()


def test_without_a_fresh_scan_it_stands_and_goes_on_when_scans_return(bench: Bench) -> None:
    bench.hold("goal", 0.2, seconds=0.4)
    bench.scans = False
    lost = bench.now
    bench.hold("goal", 0.2, seconds=0.5)
    moving = motion_after(bench.rows, lost)
    assert max(row.t_mono_ns for row in moving) * 1e-9 <= lost + 0.31
    assert bench.gate.status().reason == "waiting for a fresh scan"
    bench.scans = True
    bench.hold("goal", 0.2, seconds=0.4)
    assert bench.speed == 0.2


def test_a_long_time_without_scans_is_a_trip(bench: Bench) -> None:
    bench.hold("goal", 0.2, press=3, seconds=0.4)
    bench.scans = False
    bench.hold("goal", 0.2, press=3, seconds=1.2)
    assert bench.gate.status().trips == 1
    bench.scans = True
    bench.hold("goal", 0.2, press=3, seconds=0.4)
    assert bench.speed == 0.0


def test_before_the_first_scan_nothing_moves() -> None:
    gate = Gate(Limits())
    gate.tick(0.0)
    gate.arm(1, "ann", 0.0)
    for n in range(1, 100):
        gate.heartbeat(0.02 * n)
        gate.accept(Setpoint(1, n, "goal", 1, 0.2, 0.0, gate.status().nonce), 0.02 * n)
        assert not gate.tick(0.02 * n).moves
    assert gate.status().reason == "waiting for a fresh scan"


def test_a_robot_without_a_guard_is_slow_and_must_be_alive() -> None:
    bench = Bench(replace(Limits(), guard=False))
    bench.scans = False
    bench.gate.touch(False, bench.now)
    for _ in range(30):
        bench.gate.touch(False, bench.now)
        bench.hold("jog", 0.3, seconds=0.02)
    assert bench.speed == 0.2
    assert bench.gate.status().limit_v == 0.2
    bench.hold("jog", 0.3, seconds=0.4)
    assert bench.speed == 0.0
    assert bench.gate.status().reason == "the robot is silent"


def test_the_guard_stops_before_a_wall_and_says_where_it_is(bench: Bench) -> None:
    bench.hold("jog", 0.3, seconds=0.5)
    bench.points = [(0.12, 0.01)]
    bench.hold("jog", 0.3, seconds=0.2)
    status = bench.gate.status()
    assert (status.v, status.limit_v) == (0.0, 0.0)
    assert status.blocked_by == pytest.approx((0.12, 0.01), abs=0.01)
    assert status.reason == "something is in the way"
    assert status.trips == 0
    bench.points = []
    bench.hold("jog", 0.3, seconds=0.5)
    assert bench.speed == 0.3


def test_a_bump_trips_and_only_the_way_back_is_open(bench: Bench) -> None:
    bench.hold("jog", 0.3, seconds=0.5)
    bench.gate.touch(True, bench.now)
    assert bench.speed == 0.0
    bench.let_go()
    bench.hold("jog", 0.3, press=2, seconds=0.2)
    assert bench.speed == 0.0
    assert "away" in bench.gate.status().reason
    bench.hold("jog", -0.1, press=2, seconds=0.2)
    assert bench.speed == -0.1
    bench.gate.touch(False, bench.now)
    bench.hold("jog", 0.1, press=2, seconds=0.3)
    assert bench.speed == 0.1


def test_a_touch_while_standing_is_no_trip(bench: Bench) -> None:
    bench.gate.touch(True, bench.now)
    assert bench.gate.status().trips == 0


def test_presses_from_before_a_restart_do_not_move_the_new_gate() -> None:
    gate = Gate(Limits(), spent=[("goal", 12), ("jog", 7)])
    gate.tick(0.0)
    gate.see([], 0.0)
    gate.heartbeat(0.0)
    gate.arm(1, "ann", 0.0)
    gate.accept(Setpoint(1, 1, "jog", 7, 0.0, 0.0, gate.status().nonce), 0.0)
    assert gate.accept(Setpoint(1, 2, "jog", 7, 0.1, 0.0, gate.status().nonce), 0.0).startswith("This was stopped")
    assert gate.accept(Setpoint(1, 1, "goal", 12, 0.1, 0.0, gate.status().nonce), 0.0).startswith("This command")
    assert gate.accept(Setpoint(1, 2, "goal", 13, 0.1, 0.0, gate.status().nonce), 0.0) == ""


@pytest.mark.parametrize(
    "stop",
    [
        lambda bench: bench.gate.stop(bench.now),
        lambda bench: bench.gate.halt(bench.now),
        lambda bench: bench.gate.disarm(bench.now),
        lambda bench: bench.gate.arm(2, "bob", bench.now),
        lambda bench: bench.gate.touch(True, bench.now),
    ],
)
def test_every_stop_is_seen_in_the_status_with_a_new_nonce(bench: Bench, stop: Callable[[Bench], object]) -> None:
    bench.hold("jog", 0.3, seconds=0.3)
    before = bench.gate.status()
    stop(bench)
    after = bench.gate.status()
    assert (after.v, after.w, after.source, after.need_neutral) == (0.0, 0.0, "", True)
    assert after.nonce > before.nonce


def test_what_was_stopped_is_remembered_within_bounds() -> None:
    presses = Presses()
    for press in range(3 * MAX_REMEMBERED_PRESSES):
        presses.refuse("jog", press)
    assert presses.begin("jog", 0)
    assert not presses.begin("jog", 3 * MAX_REMEMBERED_PRESSES - 1)


def test_an_expired_nonce_is_said_as_what_it_means_to_the_operator() -> None:
    assert GateStatus(refused=EXPIRED).refused_because == TOO_BUSY
    assert GateStatus(refused="The robot is halted.").refused_because == "The gate refuses: The robot is halted."


def test_what_is_seen_is_dated_by_its_measurement_not_by_its_arrival() -> None:
    bench = Bench()
    bench.scans = False
    for _ in range(100):
        bench.gate.see([], bench.now, age=0.25)
        bench.hold("jog", 0.2, seconds=0.04)
    assert bench.speed == pytest.approx(0.2)
    stood = bench.now
    while bench.speed:
        bench.hold("jog", 0.2, seconds=0.02)
    assert bench.now - stood < bench.limits.scan_age - 0.25 + 0.05
    assert bench.complaints() == []


@pytest.mark.parametrize("source", ["jog", "goal"])
@pytest.mark.parametrize(("age", "reason"), [(0.6, "the laser is 0.6 s late"), (-60.0, "stamps lie 60.0 s ahead")])
def test_scans_that_are_late_or_stamped_ahead_let_nothing_move_and_say_so(
    source: Source, age: float, reason: str
) -> None:
    bench = Bench()
    bench.hold(source, 0.2, seconds=0.5)
    assert bench.speed == pytest.approx(0.2)
    bench.scans = False
    for _ in range(10):
        bench.gate.see_untimely(age, bench.now)
        bench.hold(source, 0.2, seconds=0.08)
    assert not bench.speed and reason in bench.gate.status().reason
    assert bench.gate.status().trips == 0
    bench.run(0.5)
    bench.hold(source, 0.2, press=2, seconds=0.5)
    assert not bench.speed


@pytest.mark.parametrize("late_from_the_first", [True, False])
def test_scans_that_are_more_than_a_second_late_trip_with_the_lateness(late_from_the_first: bool) -> None:
    bench = Bench(armed=not late_from_the_first)
    if late_from_the_first:
        bench.gate = Gate(bench.limits, trace=bench.trace)
        bench.gate.arm(1, "ann", bench.now)
        bench.scans = False
        bench.let_go()
    bench.scans = False
    for _ in range(15):
        bench.gate.see_untimely(1.24, bench.now)
        bench.hold("jog", 0.2, seconds=0.1)
    status = bench.gate.status()
    assert status.trips and not status.v
    assert status.stopped_because == "The robot stopped by itself: the laser is 1.2 s late."


@pytest.mark.parametrize("source", ["jog", "goal"])
def test_while_the_robot_says_that_it_cannot_be_driven_no_press_moves_it(source: Source) -> None:
    bench = Bench()
    bench.hold(source, 0.2, seconds=0.5)
    for press in range(1, 6):
        bench.let_go()
        bench.gate.see_trouble(bench.now)
        for _ in range(10):
            bench.hold(source, 0.2, press=press, seconds=0.02)
            assert not bench.speed
    assert bench.gate.status().stopped_because == "The robot stopped by itself: the robot cannot be driven now."
    bench.run(0.5)
    bench.let_go()
    bench.hold(source, 0.2, press=9, seconds=0.5)
    assert bench.speed == pytest.approx(0.2) and bench.complaints() == []


def test_the_older_a_scan_the_farther_from_a_wall_the_robot_begins_to_brake() -> None:
    speeds = list[float]()
    for age in (0.0, 0.1, 0.2, 0.25):
        bench = Bench()
        bench.scans = False
        for _ in range(50):
            bench.gate.see([(0.24, 0.0)], bench.now, age=age)
            bench.hold("jog", 0.3, seconds=0.02)
        speeds.append(bench.speed)
    assert speeds[0] == pytest.approx(speeds[1]) and speeds[1] > speeds[2] > speeds[3] > 0.05


def held(bench: Bench, silent: float, *, beats: bool) -> None:
    """A command under way, and a computer that does not come to steer it for so long [s]."""
    bench.hold("goal", 0.2, press=7, seconds=1.0)
    assert bench.speed == pytest.approx(0.2)
    bench.beats = beats
    bench.run(silent)
    bench.beats = True
    assert not bench.speed and not bench.gate.twist.moves


@pytest.mark.parametrize("beats", [True, False])
@pytest.mark.parametrize("silent", [0.3, 1.0, 1.9])
def test_a_command_that_a_busy_computer_left_alone_goes_on_within_two_seconds(
    bench: Bench, silent: float, beats: bool
) -> None:
    held(bench, silent, beats=beats)
    assert bench.gate.status().holds and bench.gate.status().trips == 0
    bench.hold("goal", 0.2, press=7, seconds=0.6)
    assert bench.speed == pytest.approx(0.2) and not bench.gate.status().holds


@pytest.mark.parametrize("beats", [True, False])
def test_after_two_seconds_it_ends_with_the_sentence(bench: Bench, beats: bool) -> None:
    held(bench, 2.6, beats=beats)
    status = bench.gate.status()
    assert (status.trips, status.holds, status.stopped_because) == (1, False, TOO_BUSY)
    bench.hold("goal", 0.2, press=7, seconds=1.0)
    assert not bench.speed


STOPPED: list[Callable[[Bench], object]] = [
    lambda bench: bench.gate.stop(bench.now),
    lambda bench: bench.gate.halt(bench.now),
    lambda bench: bench.gate.disarm(bench.now),
    lambda bench: bench.gate.arm(2, "bob", bench.now),
    lambda bench: bench.gate.wake(bench.now),
    lambda bench: (bench.let_go(), bench.hold("jog", 0.1, press=1, seconds=0.2), bench.let_go()),
    lambda bench: bench.hold("goal", 0.1, press=8, seconds=0.2),
]


@pytest.mark.parametrize("stopped", STOPPED)
def test_a_command_that_waits_and_is_stopped_meanwhile_never_moves_again(
    bench: Bench, stopped: Callable[[Bench], object]
) -> None:
    held(bench, 0.5, beats=True)
    stopped(bench)
    bench.run(0.1)
    stood = bench.now
    bench.hold("goal", 0.2, press=7, seconds=1.0)
    assert not [row for row in motion_after(bench.rows, stood) if row.press == 7]


def test_after_the_console_was_silent_a_stop_that_waited_in_it_comes_before_any_motion(bench: Bench) -> None:
    held(bench, 1.0, beats=False)
    thawed = bench.now
    bench.hold("goal", 0.2, press=7, seconds=0.16)
    bench.gate.stop(bench.now)
    bench.hold("goal", 0.2, press=7, seconds=1.0)
    assert motion_after(bench.rows, thawed) == []


def test_a_setpoint_from_before_the_wait_does_not_end_it(bench: Bench) -> None:
    bench.hold("goal", 0.2, press=7, seconds=1.0)
    old = bench.order("goal", 0.2, 0.0, 7)
    bench.run(0.3)
    assert bench.gate.accept(old, bench.now) and bench.gate.status().holds


def test_a_command_that_stands_by_itself_after_the_wait_does_not_fail(bench: Bench) -> None:
    held(bench, 0.5, beats=True)
    bench.hold("goal", 0.0, press=7, seconds=3.0)
    assert bench.gate.status().trips == 0
    bench.hold("goal", 0.2, press=7, seconds=0.6)
    assert bench.speed == pytest.approx(0.2)


def test_a_hand_never_goes_on_by_itself(bench: Bench) -> None:
    bench.hold("jog", 0.2, seconds=1.0)
    bench.run(0.3)
    assert bench.gate.status().trips == 1
    bench.hold("jog", 0.2, seconds=0.5)
    assert not bench.speed


@pytest.mark.parametrize("wall", [[], [(0.15, 0.0)]], ids=["free", "wall"])
def test_a_late_scan_neither_takes_back_nor_adds_to_what_a_timely_one_saw(wall: list[tuple[float, float]]) -> None:
    speeds = list[float]()
    for late in (False, True):
        bench = Bench()
        bench.scans = False
        for _ in range(20):
            bench.gate.see(wall, bench.now)
            if late:
                bench.gate.see([] if wall else [(0.15, 0.0)], bench.now, age=bench.limits.scan_age + 0.1)
            bench.hold("goal", 0.2, seconds=0.02)
        speeds.append(bench.speed)
    assert speeds[0] == speeds[1] > 0.1
