"""The simulator's time waits for a computer that does not come to its work; what stops the robot stays what it is."""

import heapq
import random
from collections.abc import Callable

import pytest

from core.gate import TICK_S, Gate, Limits, Setpoint
from core.gate.requests import GateHeartbeat, GateReach
from core.gate.simulated_clock import MAX_AHEAD_S, SimulatedClock
from core.robots.process import MAX_SLOWDOWN_FACTOR

PERIOD = 0.025  # [s]
EACH_S = {"frame": PERIOD, "tick": TICK_S, "pilot": PERIOD, "beat": 0.05}  # between two turns of each part, at least


class LoadedComputer:
    """Simulator, gate, pilot and heartbeat, each of which takes a turn whenever the computer comes to it."""

    def __init__(self, delay: Callable[[str], float]) -> None:
        """`delay`: of a part → how much later [s] than it wants its next turn is."""
        self._delay = delay
        self.real, self.stamp, self.pilot_stamp = 0.0, 100.0, 100.0
        self.gate, self.clock = Gate(Limits()), SimulatedClock(PERIOD)
        self.silent: set[str] = set()  # parts that take no turn any more
        self.moved = 0.0  # [m] forward
        self.speed, self._stepped, self._nonce, self._seq = 0.0, 0.0, 0, 0
        self._turns = [(0.0, part) for part in EACH_S]
        self.gate.arm(1, "ann", 0.0)

    def run(self, seconds: float) -> None:
        """So much real time."""
        end = self.real + seconds
        while self.real < end:
            self.real, part = heapq.heappop(self._turns)
            if part not in self.silent:
                getattr(self, f"_{part}")()
            heapq.heappush(self._turns, (self.real + EACH_S[part] + self._delay(part), part))

    def _frame(self) -> None:
        until = self.clock.until
        held = until is not None and self.stamp + PERIOD > until
        if held and self.real < self._stepped + MAX_SLOWDOWN_FACTOR * PERIOD:
            return
        self.stamp, self._stepped = self.stamp + PERIOD, self.real
        self.moved += self.speed * PERIOD
        self._nonce = self.gate.nonce
        self.clock.report(self.stamp, self.real)
        self.gate.see([], self.clock.now)
        self.gate.touch(False, self.clock.now)

    def _tick(self) -> None:
        before = self.clock.now
        now = self.clock.advance(self.real)
        assert before <= now <= self.real and now + 100.0 <= self.stamp + PERIOD + 1e-9
        self.speed = self.gate.tick(now).v

    def _pilot(self) -> None:
        self._seq += 1
        self.gate.accept(Setpoint(1, self._seq, "goal", 1, 0.2, 0.0, self._nonce), self.clock.now)
        self.clock.hear(GateReach(self.stamp))

    def _beat(self) -> None:
        self.gate.heartbeat(self.clock.now)
        self.clock.hear(GateHeartbeat())


def test_a_computer_that_keeps_up_has_real_time() -> None:
    at = LoadedComputer(lambda _: 0.002)
    at.run(10.0)
    assert at.stamp - 100.0 == pytest.approx(10.0, rel=0.1) and at.gate.status().trips == 0
    assert at.moved == pytest.approx(0.2 * (at.stamp - 100.0), rel=0.1)


@pytest.mark.parametrize("seed", range(20))
def test_no_stall_of_gate_or_pilot_or_console_ends_a_command_of_a_simulated_robot(seed: int) -> None:
    chance = random.Random(seed)
    at = LoadedComputer(lambda _: chance.choice((0.0, 0.01, 0.05, 0.2, 0.9)))
    at.run(60.0)
    status = at.gate.status()
    assert status.trips == 0 and status.refused == "" and status.v > 0.0
    assert 0.1 < at.stamp - 100.0 < 30.0  # it is slower
    assert at.moved == pytest.approx(0.2 * (at.stamp - 100.0), abs=0.06)  # … and nothing else


def test_ears_that_are_busy_hold_the_time_until_they_are_not() -> None:
    at = LoadedComputer(lambda _: 0.0)
    assert at.clock.until is None
    at.silent = {"pilot", "beat"}
    at.run(2.0)
    assert at.stamp - 100.0 == pytest.approx(2.0, abs=0.2)  # nobody is waited for who has not come yet
    at.silent = set()
    at.run(2.0)
    heard = at.stamp
    at.clock.hear(GateReach(heard, "ears"))
    at.run(8.0)
    assert at.stamp - heard < MAX_AHEAD_S + 8.0 / MAX_SLOWDOWN_FACTOR + 2 * PERIOD and at.gate.status().trips == 0
    at.clock.hear(GateReach(None, "ears"))
    at.run(2.0)
    assert at.stamp - heard > 1.8


@pytest.mark.parametrize("part", ["pilot", "beat"])
def test_a_part_that_does_not_come_back_stops_a_simulated_robot_within_its_own_time(part: str) -> None:
    at = LoadedComputer(lambda _: 0.002)
    at.run(2.0)
    at.silent, moved = {part}, at.moved
    at.run(20.0)
    limits = Limits()
    assert at.gate.status().holds and at.speed == 0.0
    assert at.moved - moved < 0.2 * (MAX_AHEAD_S + max(limits.deadman, limits.heartbeat) + 2 * PERIOD)


def test_a_stop_holds_while_time_stands() -> None:
    at = LoadedComputer(lambda _: 0.0)
    at.run(2.0)
    at.silent = {"pilot", "beat"}
    at.run(0.3)
    at.gate.stop(at.clock.now)
    assert at.gate.twist.v == 0.0
    at.silent = set()
    at.run(3.0)
    assert at.speed == 0.0
