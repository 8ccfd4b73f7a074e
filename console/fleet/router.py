"""The fleet's router: robots join it, it asks them to stand, for pictures and for keys of their consoles."""

import asyncio
import contextlib
import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import msgspec

from console.fleet import bus
from console.fleet.authority import Authority
from console.fleet.table import FleetTable
from console.workers.tasks import HeldTasks
from core.errors import BadInput, Unavailable
from core.files import write_atomic
from core.robots.ros.zenoh_session import load_zenoh
from core.sentences import Statement

log = logging.getLogger(__name__)

LOOK_PERIOD_S = 0.25  # between looks at ages, certificates and stops without an answer
ANSWER_TIMEOUT_S = 1.0  # for which a stop of all waits for the answers of robots
ASK_TIMEOUT_S = 2.0  # for a picture or a key
REPEAT_PERIOD_S = 0.5  # after which a robot without an answer is asked again
REPEATED_FOR_S = 10.0  # for which a stop is repeated; a halt is repeated until it is reset
FAREWELL_S = 0.5
MAX_REPORT_BYTES = 65_536
HALT_FILE = "halt.json"


@dataclass
class RobotStop:
    asked_at: float  # [s]
    acknowledged: bool = False
    ms: float | None = None  # from the press to its answer
    answer: bus.FleetStopAnswer | None = None


@dataclass
class FleetStop:
    """A press of STOP ALL or of Halt all, and who has answered."""

    kind: bus.StopKind
    by: str
    wall: float  # Unix time
    began: float  # [s]
    robots: dict[str, RobotStop] = field(default_factory=dict[str, RobotStop])
    over: bool = False  # it is repeated no more

    @property
    def all(self) -> bool:
        return bool(self.robots) and all(one.acknowledged for one in self.robots.values())


class HeldHalt(msgspec.Struct):
    """The halt of all, as it is on the disk: who has taken it already is not halted again."""

    by: str
    since_s: float  # Unix time
    acknowledged: list[str]


class FleetRouter:
    """Lives on the event loop; zenoh's threads only hand over."""

    def __init__(self, authority: Authority, listen: bus.FleetAddress) -> None:
        self.table = FleetTable()
        self.stop: FleetStop | None = None  # the newest
        self.halt: HeldHalt | None = None
        self._halting: FleetStop | None = None  # which asks for the halt, under a newer stop too
        self._listen_trouble = self._disk_trouble = ""  # sentences: why no robot can join, or no halt is kept
        self._authority, self._listen = authority, listen
        self._session: Any = None
        self._kept: list[Any] = []  # what zenoh lets go of when it is not held
        self._tasks = HeldTasks()
        self._known = -1.0  # Unix time of the list of certificates in use
        self._loop = asyncio.get_running_loop()
        self._halt_file = authority.folder / HALT_FILE
        self._halt_turn = asyncio.Lock()  # of who writes it

    @property
    def trouble(self) -> str:
        """A sentence: no robot can join, or a halt of all would not outlast this program; "" when all is well."""
        return self._listen_trouble or self._disk_trouble

    # life

    async def open(self) -> None:
        """Listen. Raises Unavailable, BadInput."""
        self.halt = await asyncio.to_thread(_held_halt, self._halt_file)
        await self._restart()

    async def run(self) -> None:
        """Let ages grow, take in new certificates, repeat stops."""
        while True:
            await asyncio.sleep(LOOK_PERIOD_S)
            self.table.tick(time.monotonic())
            try:
                if await asyncio.to_thread(lambda: self._authority.changed) != self._known:
                    await self._restart()
                self._listen_trouble = ""
            except (BadInput, Unavailable) as why:
                self._listen_trouble = str(why)
            except OSError as trouble:  # stops are repeated all the same
                self._listen_trouble = Statement("fleet.certificates_unread", why=trouble.strerror or "disk")
            self._repeat(time.monotonic())

    async def close(self) -> None:
        await asyncio.to_thread(self._close_session)

    def renew(self) -> None:
        """Open the port again at the next look: zenoh takes 0.1 s for each connection that was given up."""
        self._known = -1.0

    async def _restart(self) -> None:
        """zenoh reads rights at its start alone: every robot is cut off, and back within a second."""
        known = self._authority.changed
        certificates = await asyncio.to_thread(self._authority.certificates)
        await asyncio.to_thread(self._close_session)
        now = time.monotonic()
        self.table.know([one.name for one in certificates if one.kind == "robot"], now)
        self.table.restarted(now)
        settings = bus.router_settings(self._listen, self._authority.router, certificates)
        refused = Statement("fleet.cannot_listen", address=self._listen.name)

        def listen() -> None:
            session = self._session = bus.open_session(settings, refused)
            admits = session.declare_queryable(bus.key_of("*", "admission"), lambda one: one.reply(one.key_expr, b""))
            changed, reported = partial(self._token_changed, session), partial(self._reported, session)
            alive = session.liveliness().declare_subscriber(bus.key_of("*", "alive"), changed, history=True)
            self._kept = [admits, alive, session.declare_subscriber(bus.key_of("*", "state"), reported)]

        await asyncio.to_thread(listen)
        self._known = known

    def _close_session(self) -> None:
        session, self._session, self._kept = self._session, None, []
        if session is not None:
            farewell = threading.Thread(target=session.close, name="fleet-farewell", daemon=True)
            farewell.start()
            farewell.join(FAREWELL_S)

    # what comes; on zenoh's threads

    def _hand_over(self, act: Callable[..., None], *given: object) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(act, *given)

    def _said(self, session: Any, act: Callable[..., None], *given: object) -> None:
        """Hand over, but for a session that was closed: as it ends, it still says of every robot that it has gone."""
        self._hand_over(lambda: act(*given, time.monotonic()) if session is self._session else None)

    def _token_changed(self, session: Any, sample: Any) -> None:
        there = sample.kind == load_zenoh().SampleKind.PUT
        self._said(session, self.table.came if there else self.table.went, bus.robot_of(str(sample.key_expr)))

    def _reported(self, session: Any, sample: Any) -> None:
        payload, name = sample.payload.to_bytes(), bus.robot_of(str(sample.key_expr))
        if len(payload) > MAX_REPORT_BYTES:
            return
        try:
            report = msgspec.json.decode(payload, type=bus.RobotReport)
        except msgspec.MsgspecError:
            return  # another version of Beckon: it stays as it was, and grows old
        self._said(session, self.table.hear, name, report)

    # stops

    async def stop_all(self, kind: bus.StopKind, by: str) -> FleetStop:
        """Ask every robot to stand by its own gate; answers when all that are there have, or after a second."""
        now = time.monotonic()
        if self.stop is not None and self.stop is not self._halting:
            self.stop.over = True
        stop = self.stop = FleetStop(kind, by, time.time(), now)
        stop.robots = {name: RobotStop(now) for name in self.table.robots}
        for name in self.table.robots:
            self._ask_to_stand(stop, name, now)
        if kind == "halt":
            self.halt, self._halting = HeldHalt(by, stop.wall, []), stop
            await self._keep_halt()
        ends = now + ANSWER_TIMEOUT_S
        while time.monotonic() < ends and self._waits(stop):
            await asyncio.sleep(0.002)
        self._mark_unanswered(stop)
        return stop

    async def reset_halt(self) -> None:
        """Halt no robot any more that comes; each stays halted until it is reset at its own console."""
        halting, self.halt, self._halting = self._halting, None, None
        if halting is not None:
            halting.over = True
        await self._keep_halt()

    def _waits(self, stop: FleetStop) -> bool:
        return any(
            self.table.robots[name].alive and not one.acknowledged
            for name, one in stop.robots.items()
            if name in self.table.robots
        )

    def _mark_unanswered(self, stop: FleetStop) -> None:
        """Of those that were there when it was pressed; who was away already is named, but was no part of it."""
        for name, robot in self.table.robots.items():
            one = stop.robots.get(name)
            missed = one is not None and not one.acknowledged
            robot.unanswered = missed and robot.report is not None and not (stop.over and robot.link == "live")

    def _ask_to_stand(self, stop: FleetStop, name: str, now: float) -> None:
        zenoh, session = load_zenoh(), self._session
        if session is None:
            return
        stop.robots[name].asked_at = now
        request = msgspec.json.encode(bus.FleetStopRequest(stop.kind, stop.by))

        def take(reply: Any) -> None:
            arrived = time.monotonic()
            if reply.ok is None:
                return
            try:
                answer = msgspec.json.decode(reply.ok.payload.to_bytes(), type=bus.FleetStopAnswer)
            except msgspec.MsgspecError:
                return
            self._hand_over(self._answered, stop, name, answer, arrived)

        try:
            session.get(
                bus.key_of(name, "stop"),
                take,
                payload=request,
                timeout=ANSWER_TIMEOUT_S,
                congestion_control=zenoh.CongestionControl.DROP,  # a frozen robot keeps nobody else waiting
                priority=zenoh.Priority.REAL_TIME,
                express=True,
            )
        except zenoh.ZError:
            log.warning("%s could not be asked to stand", name)

    def _answered(self, stop: FleetStop, name: str, answer: bus.FleetStopAnswer, arrived: float) -> None:
        """Take an answer to this stop; one that comes late says nothing of a newer stop, or of a newer halt."""
        one = stop.robots.get(name)
        if one is None or one.acknowledged:
            return
        one.answer, one.acknowledged = answer, answer.stands
        if not answer.stands:
            return
        one.ms = 1000 * (arrived - stop.began)
        if stop is self.stop and (robot := self.table.robots.get(name)) is not None:
            robot.unanswered = False
        if stop is self._halting and self.halt is not None and name not in self.halt.acknowledged:
            self.halt.acknowledged.append(name)
            self._tasks.start(self._keep_halt())

    def _repeat(self, now: float) -> None:
        """Ask again who has not answered: the newest stop for a while, a halt until it is reset."""
        if self.halt is not None:
            self._halt_latecomers(self.halt, now)
        stop, halting = self.stop, self._halting
        if stop is not None and stop.kind == "stop" and now - stop.began > REPEATED_FOR_S:
            stop.over = True
        for each in (stop, None if halting is stop else halting):
            if each is None or each.over:
                continue
            for name, one in each.robots.items():
                known = self.table.robots.get(name)
                if known and known.alive and not one.acknowledged and now - one.asked_at > REPEAT_PERIOD_S:
                    self._ask_to_stand(each, name, now)

    def _halt_latecomers(self, halt: HeldHalt, now: float) -> None:
        """The halt, of an earlier run too, holds for every robot that has not taken it."""
        left = [name for name in self.table.robots if name not in halt.acknowledged]
        if self._halting is None:
            self._halting = FleetStop("halt", halt.by, halt.since_s, now)
        for name in left:
            self._halting.robots.setdefault(name, RobotStop(0.0))
        if left and self.stop is None:
            self.stop = self._halting

    async def _keep_halt(self) -> None:
        """Write the halt as it is now; of two writes the later one holds."""

        def write(held: bytes | None) -> None:
            if held is None:
                self._halt_file.unlink(missing_ok=True)
            else:
                write_atomic(self._halt_file, held)

        async with self._halt_turn:
            try:
                await asyncio.to_thread(write, None if self.halt is None else msgspec.json.encode(self.halt))
                self._disk_trouble = ""
            except OSError as trouble:
                self._disk_trouble = Statement("fleet.halt_not_kept", why=trouble.strerror or "disk")

    # pictures and keys

    async def picture(self, name: str) -> bytes | None:
        """The newest picture of a robot (JPEG); None where it has none or does not answer."""
        return await self._asked(name, "picture", b"")

    async def console_key(self, name: str, person: str, role: bus.FleetRole) -> bus.FleetKeyAnswer | None:
        """A key of a robot's console for a person; None where it does not answer."""
        answer = await self._asked(name, "key", msgspec.json.encode(bus.FleetKeyRequest(person, role)))
        with contextlib.suppress(msgspec.MsgspecError):  # another version of Beckon
            return None if answer is None else msgspec.json.decode(answer, type=bus.FleetKeyAnswer)
        return None

    async def _asked(self, name: str, what: str, payload: bytes) -> bytes | None:
        zenoh, session = load_zenoh(), self._session
        if session is None or name not in self.table.robots:
            return None
        arrived: asyncio.Future[bytes] = self._loop.create_future()

        def settle(answer: bytes) -> None:
            if not arrived.done():
                arrived.set_result(answer)

        def take(reply: Any) -> None:
            if reply.ok is not None:
                self._hand_over(settle, reply.ok.payload.to_bytes())

        drop = zenoh.CongestionControl.DROP
        try:
            session.get(bus.key_of(name, what), take, payload=payload, timeout=ASK_TIMEOUT_S, congestion_control=drop)
            async with asyncio.timeout(ASK_TIMEOUT_S):
                return await arrived
        except (TimeoutError, zenoh.ZError):  # the session was closed meanwhile
            return None


def _held_halt(path: Path) -> HeldHalt | None:
    """The halt of an earlier run; one that cannot be read halts every robot."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=HeldHalt)
    except FileNotFoundError:
        return None
    except (OSError, msgspec.MsgspecError) as trouble:
        log.warning("%s cannot be read, so all robots are halted: %s", path, trouble)
        return HeldHalt(path.name, time.time(), [])
