"""Everything that people, robots and computers may do to a console, in any order, while it decides what drives.

Real are gate, lease, dispatcher, freshness, halts, history and routes; the pilot is the worst that there can be: it
asks for motion for whatever command it likes, late, twice, and after it was cancelled. A second, simpler memory says
whose consent a motion needs: something that a person did after everything that has stopped the robot.
"""

import contextlib
import json
import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest import mock

import msgspec
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from console.access.logins import Person
from console.control import command_freshness, dispatcher, history, stop
from console.control.command_freshness import READ_SOURCES, Spoken
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.http.problems import Problem
from console.maps import routes
from console.maps.marks import RouteMark, RouteStop
from console.maps.routes import RouteService
from console.messages.inbound import JogMessage
from console.robot import setpoint_sender
from core.commands.command import Command
from core.errors import Refused
from core.gate import TICK_S, Gate, Limits, Setpoint, Twist
from core.gate.gate import STEADY_S, TROUBLE_HELD_S
from core.gate.status import GateStatus
from core.navigation.places import NamedPlace
from core.sentences import Statement, plain
from core.snapshot import ActiveCommandStatus
from core.speech.understanding.grammar import understand
from core.speech.understanding.place_names import place_phrases

TIMED_MODULES = (dispatcher, stop, command_freshness, setpoint_sender, history, routes)
READY_TICKS = math.ceil((max(TROUBLE_HELD_S, STEADY_S) + 0.1) / TICK_S)
START_S = 2.0  # that a console takes at least
GATE_TICKS = 3  # in one of the console's
ALL_PERSONS = (Person("a", "Ann"), Person("b", "Bob", "admin"), Person("f", "Fleet"), Person("v", "Vera", "viewer"))
ANN, BOB, _, VERA = ALL_PERSONS
COMMAND_SOURCES = ("typed", "chip", "click", "camera", "rest", "fleet", "voice", "ears", "file")
NAMED_PLACES = (NamedPlace(name="Kitchen", x_m=1.0, y_m=2.0), NamedPlace(name="Hall", x_m=3.0, y_m=0.0))
LOOP_ROUTE = RouteMark("Rounds", (RouteStop("Kitchen"), RouteStop("Hall", 0.5), RouteStop("Kitchen")), loop=True)
TOUR_ROUTE = RouteMark("Tour", (RouteStop("Hall", 0.0, "wait_for_continue"), RouteStop("Kitchen", 2.0, "come_here")))
SPOKEN_TEXTS = (
    *("turn left", "turn right", "continue 2 meters", "stop at 1 and 2", "follow wall", "come here", "follow me"),
    *("stop moving", "start the route rounds", "start the route tour", "pause", "go on", "make coffee"),
)
ROUTE_NAMES = tuple(NamedPlace(name=name, x_m=0.0, y_m=0.0, route=True) for name in ("Rounds", "Tour"))
UNDERSTOOD_TEXTS = {
    words: understand(words, own=place_phrases((*NAMED_PLACES, *ROUTE_NAMES))) for words in SPOKEN_TEXTS
}
STORY_EVENTS: dict[str, tuple[Any, ...]] = {
    "press_stop": (VERA,),
    "press_halt": (BOB,),
    "pass_control_on": (BOB, "take"),
    "come_and_go": (ANN, "signs out"),
    "say": (BOB, "stop moving", "voice", 0.1),
    "the_pilot_dies_or_comes": (True,),
    "the_console_stands_still": (6.0,),
    "the_gate_is_started_again": (),
    "the_console_is_started_again": (True,),
    "bumper": (True,),
    "the_machine_slept": (),
    "the_link_is_lost": (True,),
    "the_link_is_lost_for_a_moment": (),
    "hold_a_key": (ANN, 0.0, 0.3, True, 0, 0),
    "steer_the_route": (ANN, "stop", False),
    "another_one_orders": (),
}
WITHDRAWN_BY = {  # what they end of what drives
    "the_link_is_lost_for_a_moment": ("command", "route"),
    "hold_a_key": ("command", "route"),
    "steer_the_route": ("route",),
    "another_one_orders": (),
}
PILOT_ENDING = Statement("pilot.strayed")
people = st.sampled_from(ALL_PERSONS)
speeds = st.sampled_from([-0.2, 0.0, 0.1, 0.3])


class Clock:
    """Time as the modules under test read it."""

    def __init__(self) -> None:
        self.now = 100.0
        self.calendar_s = 0.0

    def monotonic(self) -> float:
        return self.now

    def time(self) -> float:
        return 1.7e9 + self.now + self.calendar_s

    localtime = staticmethod(lambda seconds: SimpleNamespace(tm_hour=12, tm_min=0, tm_sec=int(seconds) % 60))
    strftime = staticmethod(lambda form, _: form)


class Memory:
    """In place of the store on disk."""

    def __init__(self, newest: int) -> None:
        self.newest = newest

    def open(self) -> list[Any]:
        return [SimpleNamespace(id=self.newest)]

    def keep(self, _: Any) -> None: ...


@dataclass(frozen=True)
class Consent:
    """A person's doing that a motion rests on."""

    person: Person
    step: int  # of the story, in which it was done, or was said
    began: float = math.inf  # [s] when they began to say it
    ended: float = math.inf


class GateRobot:
    """The console's RobotSupervisor with the real gate behind it; what it says is as old as its last tick."""

    def __init__(self, clock: Clock, judge: Callable[[Setpoint], None], *, halted: bool, drives: bool) -> None:
        self.clock, self.judge = clock, judge
        self.profile = SimpleNamespace(
            drives=drives, dry_run=False, simulated=False, refusal=lambda _=None: "A recording drives nothing."
        )
        self.trouble = ""
        self.presses: dict[str, int] = {}
        self.gate = Gate(Limits(), halted=halted)
        self.shown = self.gate.status()

    def start_gate_again(self, *, halted: bool) -> None:
        self.gate = Gate(Limits(), halted=halted, spent=tuple(self.presses.items()))

    def send(self, order: Setpoint) -> None:
        if order.v or order.w:
            self.presses[order.source] = order.press
        if not self.gate.accept(order, self.clock.now):
            self.judge(order)

    def stop(self) -> None:
        self.gate.stop(self.clock.now)

    def halt(self) -> None:
        self.gate.halt(self.clock.now)

    def reset(self) -> bool:
        self.gate.reset(self.clock.now)
        return True

    def arm(self, epoch: int, owner: str) -> None:
        self.gate.arm(epoch, owner, self.clock.now)

    def disarm(self) -> None:
        self.gate.disarm(self.clock.now)

    def status(self) -> GateStatus:
        return self.shown

    def link(self) -> tuple[str, float]:
        return "lost" if self.trouble else "live", 0.0


class WorstPilot:
    """Knows what it was told, and what of it has not been said to have ended."""

    def __init__(self) -> None:
        self.told: dict[int, Command] = {}
        self.over: dict[int, tuple[str, str]] = {}  # what is to be reported
        self.refuses = False

    def tell(self, number: int, command: Command, source: str, who: str) -> None:
        del source, who
        if self.refuses:
            raise Refused("The robot is lost.")
        for older in self.told:
            self.over.setdefault(older, ("pre-empted", "A newer one."))
        self.told[number] = command

    def cancel(self, state: str, why: str) -> None:
        for number in self.told:
            self.over.setdefault(number, (state, why))


class UnwrittenRoutes(RouteService):
    """The disk is a field."""

    written = ""

    def _keep(self) -> None:
        self.written = json.dumps(msgspec.to_builtins(self.run_now, enc_hook=plain))

    def _later(self, work: Any) -> None:
        work.close()


class AnyOrderOfThings(RuleBasedStateMachine):
    """Operators, a fleet, a viewer, speech, keys, routes, gate, pilot, clocks and restarts."""

    reached: Counter[str] = Counter()  # of all stories: what drove, and what ended it

    @initialize()
    def wake(self) -> None:
        self.clock = Clock()
        self.patched = contextlib.ExitStack()
        for module in TIMED_MODULES:
            self.patched.enter_context(mock.patch.object(module, "time", self.clock))
        self.patched.enter_context(mock.patch.object(history, "HistoryStore", lambda *_: Memory(self.newest_entry)))
        self.step, self.newest_entry = 0, 0
        self.ended_step = 0  # of the newest that stopped the robot
        self.stopped_s = self.changed_s = -math.inf  # when a person stopped it, when something else ended all
        self.halted = False
        self.consents: dict[tuple[str, int], Consent] = {}
        self.route_goals: set[int] = set()
        self.withdrawn: set[int] = set()  # goals that a person has ended without stopping the robot
        self.route_consent: Consent | None = None
        self.in_force = ("", 0)
        self.press, self.presses, self.seq = 0, {one.id: 0 for one in ALL_PERSONS}, 0
        self.begin_console(drives=True, written="null")

    def begin_console(self, *, drives: bool, written: str) -> None:
        """A console with the data folder of the one before."""
        self.robot: Any = GateRobot(self.clock, self.judge, halted=self.halted, drives=drives)
        self.lease, self.history, notifications = Lease(), History(Path(), print), Notifications()
        self.history.open()
        self.dispatcher = CommandDispatcher(self.robot, self.lease, self.history, notifications)
        self.give, self.dispatcher.dispatch = self.dispatcher.dispatch, self.noted  # type: ignore[method-assign]
        self.pilot: Any = WorstPilot()
        self.dispatcher.pilot = self.pilot
        places: Any = SimpleNamespace(find=lambda name: NAMED_PLACES[name == "Hall"], when_renamed=[])
        maps: Any = SimpleNamespace(
            marks=SimpleNamespace(routes=(LOOP_ROUTE, TOUR_ROUTE)), shown=SimpleNamespace(name="floor")
        )
        voice: Any = SimpleNamespace(muted=False)
        self.routes = UnwrittenRoutes(
            Path(), maps, places, self.dispatcher, self.lease, self.history, notifications, voice
        )
        self.routes.clock = self.clock.time
        with mock.patch.object(Path, "read_bytes", lambda _: written.encode()), contextlib.suppress(StopIteration):
            self.routes.open().send(None)
        self.nonces = [self.robot.gate.status().nonce]

    # the simple memory

    def noted(self, command: Command, source: str, who: Person, *given: Any, **more: Any) -> Any:
        """Dispatch, and remember whose consent this rests on."""
        said = given[0] if given else None
        timed = (said.began, said.ended) if said is not None and source in READ_SOURCES else (math.inf, math.inf)
        mine, before = Consent(who, self.step, *timed), self.route_consent
        if command.name in ("start_route", "resume_route"):
            self.route_consent = mine
        try:
            entry = self.give(command, source, who, *given, **more)
        except (Problem, Refused):
            self.route_consent = before
            raise
        if source == routes.SOURCE and self.route_consent is not None:
            mine = replace(self.route_consent, person=who)
            self.route_goals.add(entry.id)
        if command.name == "stop_moving":
            self.ends(by_person=True)
        self.consents["goal", entry.id] = mine
        return entry

    def ends(self, *, by_person: bool = False, changes: bool = False) -> None:
        """Whatever drove is over, and nothing goes on without a person's doing after this."""
        self.ended_step = self.step
        if by_person:
            self.stopped_s = self.clock.now
        if changes:
            self.changed_s = self.clock.now
        assert not self.robot.gate.twist.moves

    def withdraw_goals(self) -> None:
        self.withdrawn |= {number for source, number in self.consents if source == "goal"}

    def judge(self, order: Setpoint) -> None:
        """The gate has accepted this."""
        if order.v or order.w:
            assert order.source == "jog" or order.press not in self.withdrawn, order
            self.in_force = (order.source, order.press)
            self.look_who_drives()

    def look_who_drives(self) -> None:
        consent = self.consents.get(self.in_force)
        assert consent is not None, self.in_force
        assert consent.step > self.ended_step, (self.in_force, consent)
        assert consent.began > self.stopped_s and consent.ended >= self.changed_s, (self.in_force, consent)
        assert consent.person.may("operator") and self.lease.held_by(consent.person)
        assert not self.halted and self.robot.profile.drives

    @contextlib.contextmanager
    def done_by(self, who: Person | None = None) -> Iterator[None]:
        """A step of the story that may be refused; a change of who drives ends what was under way."""
        self.step += 1
        holder, epoch, trips = self.lease.holder, self.lease.epoch, self.robot.gate.status().trips
        running = self.routes.run_now is not None and self.routes.run_now.state in ("driving", "waiting")
        with contextlib.suppress(Problem, Refused):
            yield
        if self.lease.epoch != epoch and (holder is not None or (running and who is None)):
            self.ends(changes=True)
        if self.robot.gate.status().trips > trips:
            self.ends()
        if who is not None and who.role == "viewer":
            assert self.lease.epoch == epoch

    # people

    @rule(
        who=people,
        words=st.sampled_from(SPOKEN_TEXTS),
        source=st.sampled_from(COMMAND_SOURCES),
        age=st.floats(0.0, 6.0),
    )
    def say(self, who: Person, words: str, source: str, age: float) -> None:
        now = self.clock.now
        said = Spoken(now - age, now - age / 2) if source in READ_SOURCES else None
        with self.done_by(who):
            self.dispatcher.accept(UNDERSTOOD_TEXTS[words], words, source, who, said)

    @rule(who=people, v=speeds, w=speeds, fresh=st.booleans(), back=st.integers(0, 3), epoch=st.integers(-1, 1))
    def hold_a_key(self, who: Person, v: float, w: float, fresh: bool, back: int, epoch: int) -> None:
        if fresh:
            self.press += 1
            self.presses[who.id] = len(ALL_PERSONS) * self.press + ALL_PERSONS.index(who)
        press = self.presses[who.id]
        self.seq += 1
        with self.done_by(who):
            self.consents.setdefault(("jog", press), Consent(who, self.step))
            nonce = self.nonces[-1 - min(back, len(self.nonces) - 1)]
            epoch = max(self.lease.epoch + epoch, 0)
            self.dispatcher.drive(JogMessage(v=v, w=w, press=press, seq=self.seq, nonce=nonce, epoch=epoch), who)
            if v or w:
                self.withdraw_goals()

    @rule(who=people)
    def press_stop(self, who: Person) -> None:
        with self.done_by(who):
            self.dispatcher.stop(who, "page", self.step)
            self.ends(by_person=True)

    @rule(who=people)
    def press_halt(self, who: Person) -> None:
        with self.done_by(who):
            self.dispatcher.halt(who, "page", self.step)
            self.halted = True
            self.ends(by_person=True)

    @rule(who=people)
    def lift_the_halt(self, who: Person) -> None:
        with self.done_by(who):
            self.dispatcher.reset(who, "page")
            self.halted = False
            self.ends()

    @rule(
        who=people, do=st.sampled_from(["acquire", "renew", "take", "release", "ask", "give", "keep", "take", "give"])
    )
    def pass_control_on(self, who: Person, do: Any) -> None:
        with self.done_by(who):
            self.dispatcher.change_lease(do, who)

    @rule(who=people, what=st.sampled_from(["connected", "disconnected", "signs out"]))
    def come_and_go(self, who: Person, what: str) -> None:
        with self.done_by(who):
            if what == "signs out":
                self.dispatcher.forget(who)
            elif what == "connected":
                self.lease.connected(who, self.clock.now)
            else:
                self.lease.disconnected(who)

    @rule(who=people, do=st.sampled_from(["start", "pause", "resume", "skip", "stop"]), tour=st.booleans())
    def steer_the_route(self, who: Person, do: str, tour: bool) -> None:
        with self.done_by(who):
            before = self.route_consent
            if do in ("start", "resume", "skip"):
                self.route_consent = Consent(who, self.step)
            try:
                if do == "start":
                    self.routes.start((TOUR_ROUTE if tour else LOOP_ROUTE).name, who, unattended=tour)
                else:
                    getattr(self.routes, do)(who)
            except (Problem, Refused):
                self.route_consent = before
                raise
            if do in ("pause", "stop"):
                self.withdrawn |= self.route_goals

    # the pilot

    @precondition(lambda self: self.pilot.told)
    @rule(back=st.integers(0, 5), v=speeds, w=speeds, old=st.integers(0, 3))
    def the_pilot_asks_for(self, back: int, v: float, w: float, old: int) -> None:
        """A motion for any command that it ever heard of."""
        told = list(self.pilot.told)
        nonce = self.nonces[-1 - min(old, len(self.nonces) - 1)]
        self.follow(told[-1 - min(back, len(told) - 1)], Twist(v, w), nonce)

    def follow(self, number: int, twist: Twist, nonce: int) -> None:
        asked: Any = SimpleNamespace(setpoint_command_id=number, setpoint=twist, nonce=nonce)
        self.dispatcher.setpoint_sender.follow(asked)

    @rule(count=st.integers(1, 3), state=st.sampled_from(["done", "failed"]), touched=st.booleans())
    def the_pilot_reports(self, count: int, state: Any, touched: bool) -> None:
        """What has ended, the eldest first; the newest comes to its end."""
        with self.done_by():
            for number in list(self.pilot.told)[:count]:
                command = self.pilot.told.pop(number)
                how, why = self.pilot.over.pop(number, (state, PILOT_ENDING if touched and state == "failed" else ""))
                ended = ActiveCommandStatus(
                    id=number,
                    name=command.name,
                    numbers={},
                    heard_as=command.heard_as,
                    source="",
                    who="",
                    stamp=0.0,
                    state=how,
                    remark=why,
                )
                self.dispatcher.ended([ended])

    @rule(refuses=st.booleans())
    def the_pilot_is_lost(self, refuses: bool) -> None:
        self.pilot.refuses = refuses
        floor = SimpleNamespace(lost="somewhere" if refuses else None)
        snapshot: Any = SimpleNamespace(battery=None, stamp=0.0, floor=floor)
        with self.done_by():
            self.routes.on_snapshot(snapshot, SimpleNamespace(trouble=None, image=None))  # type: ignore[arg-type]

    @rule(dies=st.booleans())
    def the_pilot_dies_or_comes(self, dies: bool) -> None:
        self.step += 1
        self.dispatcher.pilot = None if dies else self.pilot
        if dies:
            self.dispatcher.setpoint_sender.stop()
            self.dispatcher.ended_without_pilot("The pilot failed.")
            self.pilot = WorstPilot()
            self.ends(changes=True)

    # computers

    @rule(ticks=st.integers(1, 30), beats=st.booleans(), scans=st.booleans(), drives=st.booleans())
    def time_passes(self, ticks: int, beats: bool, scans: bool, drives: bool) -> None:
        """Of the console; `drives`: the pilot steers the newest command as it should."""
        for _ in range(ticks):
            for _ in range(GATE_TICKS):
                self.gate_ticks(beats, scans)
            self.nonces.append(self.robot.shown.nonce)
            if drives and self.pilot.told and (newest := [*self.pilot.told][-1]) not in self.pilot.over:
                self.follow(newest, Twist(0.2, 0.1), self.nonces[-1])
            with self.done_by():
                self.dispatcher.tick(self.clock.now)
                self.routes.tick(self.clock.now)
        del self.nonces[:-10]

    def gate_ticks(self, beats: bool, scans: bool) -> None:
        gate = self.robot.gate
        self.clock.now += TICK_S
        trips = gate.status().trips
        if beats:
            gate.heartbeat(self.clock.now)
        if scans:
            gate.see([], self.clock.now)
        moves = gate.tick(self.clock.now).moves
        if gate.status().trips > trips:
            self.step += 1
            self.ends()
        elif moves:
            self.look_who_drives()
        self.robot.shown = gate.status()

    @rule(seconds=st.floats(0.1, 20.0))
    def the_console_stands_still(self, seconds: float) -> None:
        for _ in range(min(math.ceil(seconds / TICK_S), 30)):
            self.gate_ticks(beats=False, scans=True)
        self.clock.now += seconds
        self.gate_ticks(beats=False, scans=True)

    @rule(seconds=st.floats(-3600.0, 3600.0))
    def the_calendar_is_set(self, seconds: float) -> None:
        self.clock.calendar_s += seconds

    @rule()
    def the_gate_is_started_again(self) -> None:
        self.the_link_is_lost(lost=True)
        self.robot.start_gate_again(halted=self.halted)
        self.nonces = [self.robot.gate.status().nonce]
        self.the_link_is_lost(lost=False)

    @rule(drives=st.booleans())
    def the_console_is_started_again(self, drives: bool) -> None:
        """`drives`: else on a recording, which is a robot that cannot be driven."""
        self.step += 1
        self.newest_entry = max((number for source, number in self.consents if source == "goal"), default=0)
        written = self.routes.written or "null"
        self.changed_s = self.clock.now
        self.clock.now += START_S
        self.begin_console(drives=drives, written=written)
        self.ends()
        run = self.routes.run_now
        assert run is None or run.state in ("idle", "ended")

    @rule()
    def the_machine_slept(self) -> None:
        self.step += 1
        self.clock.now += 1.0
        self.robot.gate.wake(self.clock.now)
        self.dispatcher.setpoint_sender.stop()
        self.dispatcher.cancel("failed", "The machine slept.")
        self.ends()

    @rule(contact=st.booleans())
    def bumper(self, contact: bool) -> None:
        with self.done_by():
            self.robot.gate.touch(contact, self.clock.now)

    def another_one_orders(self) -> None:
        self.say(BOB, "turn right", "typed", 0.0)

    @rule(lost=st.booleans())
    def the_link_is_lost(self, lost: bool) -> None:
        self.robot.trouble = "The link is lost." if lost else ""
        if lost:
            self.the_link_is_lost_for_a_moment()
            self.robot.gate.stop(self.clock.now)  # as its silence does, a moment later
            self.ends(changes=True)

    @rule()
    def the_link_is_lost_for_a_moment(self) -> None:
        self.step += 1
        self.dispatcher.ended_without_pilot("The link to the robot was lost.")
        self.withdraw_goals()

    # stories with a beginning

    @rule(
        what=st.sampled_from(["command", "key", "route"]),
        event=st.sampled_from(tuple(STORY_EVENTS)),
        ticks=st.integers(0, 12),
        heard_by=st.sampled_from(["", "voice", "ears", "file"]),
        after=st.sampled_from([20, 200]),
        waits=st.booleans(),
    )
    def drive_until_something_happens(
        self, what: str, event: str, ticks: int, heard_by: str, after: int, waits: bool
    ) -> None:
        """Ann drives at last; then something ends it, and nobody does anything while time goes on.

        `heard_by`: what is understood only now was said before that; `waits`: a route is at a stop at which it waits.
        """
        self.be_ready()
        if what == "key":
            self.hold_a_key(ANN, 0.0, 0.0, fresh=True, back=0, epoch=0)  # as a page does with its first frame
        elif what == "route":
            self.steer_the_route(ANN, "start", tour=False)
        else:
            self.say(ANN, "continue 2 meters", "typed", 0.0)
        self.go_on(4 + ticks, holds=what == "key")
        drove, ended, withdrawn = self.robot.gate.twist.moves, self.ended_step, len(self.withdrawn)
        self.reached[what] += drove
        if what == "route" and waits:
            self.arrive_and_wait()
        getattr(self, event)(*STORY_EVENTS[event])
        self.reached[event] += drove and (self.ended_step > ended or len(self.withdrawn) > withdrawn)
        if self.pilot.told:
            self.the_pilot_asks_for(0, 0.2, 0.0, 0)  # once more, as it does where it has not heard yet
        if heard_by:
            self.say(ANN, "turn left", heard_by, 0.4)
        self.go_on(after, holds=what == "key")

    def arrive_and_wait(self) -> None:
        for _ in LOOP_ROUTE.stops[:2]:
            self.the_pilot_reports(100, "done", touched=False)
            self.follow(0, Twist(0.0, 0.0), self.nonces[-1])
            self.time_passes(2, beats=True, scans=True, drives=True)
        run = self.routes.run_now
        self.reached["waits"] += run is not None and run.state == "waiting"

    def go_on(self, ticks: int, *, holds: bool) -> None:
        """Nobody does anything, but that Ann holds the key that she pressed."""
        for _ in range(ticks):
            if holds:
                self.hold_a_key(ANN, 0.2, 0.0, fresh=False, back=0, epoch=0)
            self.time_passes(1, beats=True, scans=True, drives=not holds)

    def be_ready(self) -> None:
        """As a person who wants to drive: no halt, everything alive, control in hand, nothing under way."""
        if not self.robot.profile.drives:
            self.the_console_is_started_again(drives=True)
        self.the_link_is_lost(lost=False)
        self.the_pilot_dies_or_comes(dies=False)
        self.the_pilot_is_lost(refuses=False)
        self.bumper(contact=False)
        self.pass_control_on(ANN, "take")
        if self.halted:
            self.lift_the_halt(ANN)
        self.press_stop(ANN)
        self.steer_the_route(ANN, "stop", tour=False)
        self.the_pilot_reports(100, "done", touched=False)
        self.time_passes(READY_TICKS, beats=True, scans=True, drives=False)
        self.pass_control_on(ANN, "take")
        if not self.lease.is_present(ANN):
            self.come_and_go(ANN, "connected")

    # at any time

    @invariant()
    def what_is_shown_is_so(self) -> None:
        if not hasattr(self, "lease"):
            return
        holder, status = self.lease.holder, self.robot.gate.status()
        assert holder is None or holder.may("operator")
        assert (status.state == "halted") == self.halted
        assert status.state != "armed" or (holder is not None and status.owner == holder.name)

    def teardown(self) -> None:
        if hasattr(self, "patched"):
            self.patched.close()


AnyOrderOfThings.TestCase.settings = settings(
    max_examples=100, stateful_step_count=50, deadline=None, derandomize=True
)
TestAnyOrderOfThings = AnyOrderOfThings.TestCase


def test_the_stories_reached_what_they_are_about() -> None:
    """A key, a command and a route drove, and everything that ends them struck while they did."""
    story = AnyOrderOfThings()
    story.wake()
    story.reached.clear()
    for what in ("command", "key", "route"):
        for event in STORY_EVENTS:
            story.drive_until_something_happens(what, event, 3, "", 20, waits=False)  # type: ignore[operator]
    assert [story.reached[what] for what in ("command", "key", "route")] == 3 * [len(STORY_EVENTS)]
    expected = {event: len(WITHDRAWN_BY.get(event, ("command", "key", "route"))) for event in STORY_EVENTS}
    assert {event: story.reached[event] for event in STORY_EVENTS} == expected
    for event in STORY_EVENTS:
        story.drive_until_something_happens("route", event, 3, "", 20, waits=True)  # type: ignore[operator]
    assert story.reached["waits"] == len(STORY_EVENTS)
    story.teardown()
