"""Everything that may happen to a gate, in any order; a second, simpler memory says what must not move."""

import math

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from core.gate import TICK_S, Gate, Limits, Setpoint, TraceWriter, check
from core.gate.gate import MAX_BLIND_S, STEADY_S, TROUBLE_HELD_S

LIMITS = Limits()
READY_TICKS = math.ceil((max(TROUBLE_HELD_S, STEADY_S) + 0.1) / TICK_S)
FIRST_FRESH_PRESS = 10**6
LASTING_EVENTS = ("the_gate_is_frozen", "the_clock_is_set_back")
EVENTS = (
    *LASTING_EVENTS,
    "the_machine_slept",
    "the_robot_cannot_be_driven",
    "bumper",
    "stop",
    "halt",
    "disarm",
    "another_takes_it",
)
speeds = st.one_of(
    st.floats(-0.5, 0.5), st.sampled_from([0.0, -0.0, 1e300, math.nan, math.inf, -math.inf, True, "0.1", None])
)
presses = st.integers(0, 5)
sources = st.sampled_from(["jog", "goal"])


class AnyOrderOfThings(RuleBasedStateMachine):
    """Operators, viewers, links and sensors at their worst."""

    @initialize(halted=st.booleans())
    def wake(self, halted: bool) -> None:
        self.trace = TraceWriter()
        self.gate = Gate(LIMITS, halted=halted, trace=self.trace)
        self.now = 10.0
        self.seq = 0
        self.sent: list[Setpoint] = []
        self.seen_nonces: list[tuple[int, float]] = []
        self.halted = halted
        self.armed: int | None = None
        self.epoch = 0
        self.dead: set[tuple[str, int]] = set()  # presses that were in force when something stopped the robot
        self.in_force: set[tuple[str, int]] = set()
        self.last_good = -math.inf
        self.beat = self.scan = self.troubled = -math.inf
        self.set_back = 0  # times that the clock was
        self.trace.write(self.gate.status(), 0, "boot", self.now)
        self.tick()
        self.look()

    def look(self) -> None:
        """What a page sees in a state message."""
        self.seen_nonces.append((self.gate.status().nonce, self.now))

    def everything_stops(self) -> None:
        self.dead |= self.in_force
        self.in_force.clear()
        assert not self.gate.twist.moves

    def hand_stops(self) -> None:
        """What is held by hand is over; a goal may wait for a while."""
        assert not self.gate.twist.moves
        self.dead |= {press for press in self.in_force if press[0] == "jog"}

    def note(self, order: Setpoint) -> None:
        """Judge an order with the simple memory, whatever the gate says, and compare."""
        before = self.gate.status()
        answer = self.gate.accept(order, self.now)
        if answer:
            if self.gate.status().trips > before.trips:
                self.everything_stops()
            return
        issued = [when for nonce, when in self.seen_nonces if nonce == order.nonce]
        assert issued and self.now - issued[0] <= LIMITS.nonce_age + 1e-9
        assert self.armed == order.epoch and not self.halted
        for speed in (order.v, order.w):
            assert type(speed) in (int, float) and math.isfinite(speed)
        if order.v or order.w:
            assert (order.source, order.press) not in self.dead
            assert self.now - self.beat <= LIMITS.heartbeat + 1e-9
            if order.source == "jog":
                self.dead |= {press for press in self.in_force if press[0] == "goal"}
                assert not before.need_neutral
            self.in_force.add((order.source, order.press))
            self.last_good = self.now

    @rule(source=sources, v=speeds, w=speeds, press=presses, back=st.integers(0, 3), epoch=st.integers(-1, 1))
    def order(self, source: str, v: float, w: float, press: int, back: int, epoch: int) -> None:
        self.seq += 1
        nonce, _ = self.seen_nonces[-1 - min(back, len(self.seen_nonces) - 1)]
        order = Setpoint(max(self.epoch + min(epoch, 0), 0), self.seq, source, press, v, w, nonce)  # type: ignore[arg-type]
        self.sent.append(order)
        self.note(order)

    @rule(source=sources, v=st.floats(-0.4, 0.4), press=presses, count=st.integers(1, 12))
    def drive_properly(self, source: str, v: float, press: int, count: int) -> None:
        for _ in range(count):
            self.console_beats()
            self.scan_comes()
            self.look()
            self.order(source, v, 0.1, press, 0, 0)
            self.tick()

    @rule(
        source=sources,
        v=st.floats(0.05, 0.3),
        count=st.integers(1, 12),
        ticks=st.integers(1, 60),
        beats=st.booleans(),
        scans=st.booleans(),
        steers=st.booleans(),
    )
    def drive_until_something_is_silent(
        self, source: str, v: float, count: int, ticks: int, beats: bool, scans: bool, steers: bool
    ) -> None:
        press = self.drive_at_last(source, v, count)
        for _ in range(ticks):
            if steers:
                self.look()
                self.order(source, v, 0.1, press, 0, 0)
            self.time_passes(1, beats, scans, looks=False)
        self.drive_properly(source, v, press, 2)  # the key is still held

    @rule(
        source=sources,
        v=st.floats(0.05, 0.3),
        count=st.integers(1, 12),
        event=st.sampled_from(EVENTS),
        seconds=st.floats(0.101, 0.3),
    )
    def drive_until_something_happens(self, source: str, v: float, count: int, event: str, seconds: float) -> None:
        press = self.drive_at_last(source, v, count)
        happens = getattr(self, event)
        happens(seconds) if event in LASTING_EVENTS else happens(True) if event == "bumper" else happens()
        self.drive_properly(source, v, press, 2)  # the key is still held

    def drive_at_last(self, source: str, v: float, count: int) -> int:
        """Drive by a press that was never used → its number."""
        self.be_ready()
        press = FIRST_FRESH_PRESS + self.seq
        self.drive_properly(source, v, press, count)
        assert self.gate.twist.moves
        return press

    def be_ready(self) -> None:
        """As a person who wants to drive: no halt, a lease, everything alive for a while, no key held."""
        self.reset()
        if self.armed is None:
            self.arm(1, "ann")
        self.bumper(False)
        for _ in range(READY_TICKS):
            self.console_beats()
            self.scan_comes()
            self.tick()
        self.let_go()

    @rule()
    def let_go(self) -> None:
        self.look()
        self.order("jog", 0.0, 0.0, 0, 0, 0)

    @precondition(lambda self: self.sent)
    @rule(back=st.integers(0, 40))
    def an_old_order_arrives_again(self, back: int) -> None:
        again = self.sent[-1 - back % len(self.sent)]
        moves = again.v != 0 or again.w != 0
        assert self.gate.accept(again, self.now) != "" or not moves

    @rule(count=st.integers(1, 30), beats=st.booleans(), scans=st.booleans(), looks=st.booleans())
    def time_passes(self, count: int, beats: bool, scans: bool, looks: bool) -> None:
        for _ in range(count):
            if beats:
                self.console_beats()
            if scans:
                self.scan_comes()
            self.tick()
        if looks:
            self.look()

    @rule(seconds=st.floats(0.101, 2.0))
    def the_gate_is_frozen(self, seconds: float) -> None:
        self.now += seconds - TICK_S
        self.tick()
        self.hand_stops()

    def tick(self) -> None:
        self.now += TICK_S
        before = self.gate.status()
        twist = self.gate.tick(self.now)
        if self.gate.status().trips > before.trips:
            self.everything_stops()
        if twist.moves:
            assert self.armed is not None and not self.halted
            assert self.now - self.last_good <= LIMITS.deadman + 1e-9
            assert self.now - self.beat <= LIMITS.heartbeat + 1e-9
            assert self.now - self.scan <= LIMITS.scan_age + 1e-9
            assert self.now - self.troubled > TROUBLE_HELD_S
        if before.source == "jog" and self.now - self.scan > MAX_BLIND_S:
            self.hand_stops()

    def console_beats(self) -> None:
        self.beat = self.now
        self.gate.heartbeat(self.now)

    @rule()
    def scan_comes(self) -> None:
        self.scan = self.now
        self.gate.see([], self.now)

    @rule(x=st.floats(-0.3, 0.3), y=st.floats(-0.3, 0.3))
    def something_is_near(self, x: float, y: float) -> None:
        self.scan = self.now
        self.gate.see([(x, y)], self.now)

    @rule()
    def the_robot_cannot_be_driven(self) -> None:
        self.troubled = self.now
        self.gate.see_trouble(self.now)

    @rule()
    def the_machine_slept(self) -> None:
        self.gate.wake(self.now)
        self.everything_stops()

    @rule(seconds=st.floats(0.001, 5.0))
    def the_clock_is_set_back(self, seconds: float) -> None:
        self.now -= seconds
        self.set_back += 1
        trips, moved = self.gate.status().trips, self.gate.twist.moves
        assert not self.gate.tick(self.now).moves
        if moved or self.gate.status().trips > trips:
            self.everything_stops()
        self.scan, self.last_good, self.troubled = -math.inf, -math.inf, -math.inf
        if self.beat - self.now >= LIMITS.heartbeat:  # one of the future is none
            self.beat = -math.inf

    @rule(legs=st.integers(1, 2), v=st.floats(0.05, 0.3))
    def a_route_goes_from_leg_to_leg(self, legs: int, v: float) -> None:
        for leg in range(legs):
            self.drive_properly("goal", v, 10 + self.seq + leg, 3)
            self.order("goal", 0.0, 0.0, 10 + self.seq + leg, 0, 0)

    @rule(contact=st.booleans())
    def bumper(self, contact: bool) -> None:
        trips = self.gate.status().trips
        self.gate.touch(contact, self.now)
        if self.gate.status().trips > trips:
            self.everything_stops()

    @rule(step=st.integers(-1, 2), owner=st.sampled_from(["ann", "bob"]))
    def arm(self, step: int, owner: str) -> None:
        before = self.gate.status()
        epoch = self.epoch + step
        answer = self.gate.arm(epoch, owner, self.now)
        assert answer or not self.halted
        unchanged = before.state == "armed" and (before.epoch, before.owner) == (epoch, owner)
        if not answer and not unchanged:
            assert epoch >= self.epoch
            self.armed = self.epoch = epoch
            self.everything_stops()

    def another_takes_it(self) -> None:
        self.arm(1, "bob")

    @rule()
    def disarm(self) -> None:
        self.gate.disarm(self.now)
        self.armed = None
        self.everything_stops()

    @rule()
    def stop(self) -> None:
        self.gate.stop(self.now)
        self.everything_stops()

    @rule()
    def halt(self) -> None:
        self.gate.halt(self.now)
        self.halted, self.armed = True, None
        self.everything_stops()

    @rule()
    def reset(self) -> None:
        self.gate.reset(self.now)
        if self.halted:
            self.halted, self.armed = False, None
            self.everything_stops()

    @invariant()
    def the_state_is_what_was_done(self) -> None:
        if not hasattr(self, "gate"):
            return
        status = self.gate.status()
        expected = "halted" if self.halted else "disarmed" if self.armed is None else "armed"
        assert status.state == expected
        assert abs(status.v) <= LIMITS.max_speed and abs(status.w) <= LIMITS.max_turn_rate

    def teardown(self) -> None:
        if hasattr(self, "trace"):
            found = check(self.trace.rows, LIMITS)
            assert [one for one in found if "time ran backwards" not in one] == []
            assert len(found) <= self.set_back


AnyOrderOfThings.TestCase.settings = settings(max_examples=200, stateful_step_count=50, deadline=None)
TestAnyOrderOfThings = AnyOrderOfThings.TestCase
