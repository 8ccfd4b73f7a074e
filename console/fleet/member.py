"""A robot's console as a member of a fleet: it says how it is, shows pictures when asked, and stands when asked to.

The loss of the fleet changes nothing here; it is only said.
"""

import asyncio
import contextlib
import queue
import threading
import time
from collections.abc import Callable, Coroutine
from typing import Any

import msgspec

from console.access.logins import Logins, Person
from console.control.dispatcher import CommandDispatcher
from console.control.lease import Lease
from console.control.notices import Notifications
from console.fleet import bus
from console.maps.service import MapService
from console.messages import filled
from console.part import Part
from console.robot.supervisor import RobotSupervisor
from console.workers.pictures import jpeg
from console.workers.tasks import HeldTasks
from core.errors import BadInput, Unavailable
from core.robots.ros.zenoh_session import load_zenoh
from core.sensors import Image, SensorFrame
from core.sentences import Statement, code_of
from core.snapshot import Snapshot

REPORT_PERIOD_S = 0.5
MIN_REPORT_GAP_S = 0.1  # between reports of changes
RETRY_S = (0.25, 0.5, 1.0)  # between attempts to reach the fleet
STAND_TIMEOUT_S = 0.9  # within which the gate must show zero
LOOK_PERIOD_S = 0.002
STILL_M_S, STILL_RAD_S = 0.001, 0.001  # of the gate's setpoint
KEY_LIFE_S = 12 * 3600.0
MAX_PICTURE_SIDE_PX, PICTURE_QUALITY = 320, 70
FAREWELL_S = 0.3
ADMISSION_PAUSE_S = 0.3  # before the router is asked once more
NOTICE_CAUSE = "fleet"  # of the notices


class FleetMember(Part):
    """Lives on the event loop; zenoh's threads only hand over, but for a stop, which acts at once."""

    def __init__(
        self,
        options: bus.MemberOptions,
        console_address: str,
        certificate: str = "",
        *,
        robot: RobotSupervisor,
        dispatcher: CommandDispatcher,
        lease: Lease,
        notifications: Notifications,
        logins: Logins,
        maps: MapService,
    ) -> None:
        """`console_address`: of this console, as the fleet opens it; `certificate` (PEM): which it then shows."""
        self.connected = False
        self._options, self._address, self._certificate = options, console_address, certificate
        self._robot, self._dispatcher, self._lease = robot, dispatcher, lease
        self._notifications, self._logins, self._maps = notifications, logins, maps
        self._session: FleetSession | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._snapshot: Snapshot | None = None
        self._image: Image | None = None
        self._packed: tuple[float, bytes] | None = None  # stamp [s] and JPEG of the picture that was asked for last
        self._sent: tuple[float, tuple[object, ...]] = (0.0, ())  # when the newest report went [s], and of what
        self._tasks = HeldTasks()

    # the console's own life

    async def run(self) -> None:
        """Join, and join again whenever the fleet was lost."""
        attempts, self._loop = 0, asyncio.get_running_loop()
        while True:
            try:
                session = await asyncio.to_thread(FleetSession, self._options, self._loop, self)
            except (Unavailable, BadInput) as why:
                self._lost(why)
                await asyncio.sleep(RETRY_S[min(attempts, len(RETRY_S) - 1)])
                attempts += 1
                continue
            attempts, self._session, self.connected = 0, session, True
            self._sent = (0.0, ())
            self._tell("info", Statement("fleet.joined", address=self._options.address.name))
            try:
                await session.lost.wait()
            finally:
                self._session, self.connected = None, False
                await asyncio.to_thread(session.close)
            self._lost(Statement("fleet.hung_up", address=self._options.address.name))

    async def close(self) -> None:
        """Leave: the token goes at once."""
        session, self._session = self._session, None
        if session is not None:
            await asyncio.to_thread(session.close)

    def _lost(self, why: object) -> None:
        self._tell("warning", Statement("fleet.not_there", why=why))

    def _tell(self, level: Any, text: str) -> None:
        shown = [one for one in self._notifications.shown if one.cause == NOTICE_CAUSE]
        if not shown or shown[-1].text != text:
            self._notifications.tell(level, text, NOTICE_CAUSE)

    # what it says

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        self._snapshot = snapshot
        self._image = frame.image or self._image

    def tick(self, now: float) -> None:
        """Report twice a second, and what changed at once."""
        session, gate = self._session, self._robot.status()
        if session is None or self._snapshot is None:
            return
        active, holder = self._snapshot.active_command, self._lease.holder
        newest = self._notifications.shown[-1:]
        situation = (gate.state, gate.reason, holder, active and active.id, newest and newest[0].id)
        sent_at, sent = self._sent
        if now - sent_at < (REPORT_PERIOD_S if situation == sent else MIN_REPORT_GAP_S):
            return
        self._sent = (now, situation)
        session.report(msgspec.json.encode(self.report(self._snapshot)))

    def report(self, snapshot: Snapshot) -> bus.RobotReport:
        (link, age), gate, profile = self._robot.link(), self._robot.status(), self._robot.profile
        pose, active, holder = snapshot.estimate.pose, snapshot.active_command, self._lease.holder
        notice = next((one for one in reversed(self._notifications.shown) if one.cause != NOTICE_CAUSE), None)
        command = None if active is None else filled(bus.CommandReport, active)
        said = None
        if notice is not None:
            said = bus.NoticeReport(notice.level, str.__str__(notice.text), *code_of(notice.text))
        return bus.RobotReport(
            address=self._address,
            robot=profile.name,
            simulated=profile.simulated,
            robot_link=link,
            robot_age_s=round(age, 3),
            pose=filled(bus.PoseReport, pose, 3),
            speed_m_s=round(abs(snapshot.velocity.v), 3),
            lost=snapshot.floor.lost is not None,
            map=bus.MapReport(self._maps.shown.name, self._maps.frame),
            battery=snapshot.battery,
            operator=holder and holder.name,
            command=command,
            gate=gate.state,
            gate_reason=str.__str__(gate.reason),
            notice=said,
            picture=self._image is not None,
        )

    # what it is asked; on zenoh's threads

    def asked_to_stand(self, query: Any) -> None:
        """Zero at once on this thread; all that goes with it on the event loop."""
        asked_at = time.monotonic()
        request = msgspec.json.decode(query.payload.to_bytes(), type=bus.FleetStopRequest)
        before = self._robot.status()
        self._dispatcher.setpoint_sender.stop()
        self._soon(self._stand(query, request, before, asked_at))

    def asked_for_picture(self, query: Any) -> None:
        """The newest picture, small."""
        self._soon(self._show(query))

    def asked_for_key(self, query: Any) -> None:
        self._soon(self._admit(query, msgspec.json.decode(query.payload.to_bytes(), type=bus.FleetKeyRequest)))

    def _soon(self, work: Coroutine[Any, Any, None]) -> None:
        """Do this on the event loop, also where the fleet is lost by then: a stop that has come holds."""
        try:
            if self._loop is not None:
                self._loop.call_soon_threadsafe(self._tasks.start, work)
                return
        except RuntimeError:  # the console has ended
            pass
        work.close()

    async def _reply(self, query: Any, what: str, answer: bytes) -> None:
        with contextlib.suppress(Exception):  # zenoh's own error, of no common kind: the fleet was lost meanwhile
            await asyncio.to_thread(query.reply, bus.key_of(self._options.name, what), answer)

    async def _stand(self, query: Any, request: bus.FleetStopRequest, before: object, asked_at: float) -> None:
        who = Person("fleet", request.by[:60], "viewer")
        if request.kind == "halt":
            self._dispatcher.halt(who, "fleet")
        else:
            self._dispatcher.stop(who, "fleet")
        while not self._stands(request, before) and time.monotonic() - asked_at < STAND_TIMEOUT_S:
            await asyncio.sleep(LOOK_PERIOD_S)
        gate, stands = self._robot.status(), self._stands(request, before)
        ms = round(1000 * (time.monotonic() - asked_at), 1)
        answer = bus.FleetStopAnswer(stands, gate.state, str.__str__(gate.reason), ms)
        await self._reply(query, "stop", msgspec.json.encode(answer))
        query.drop()

    def _stands(self, request: bus.FleetStopRequest, before: object) -> bool:
        """Return whether a status that came after the stop shows zero, and the latch where that is asked for."""
        gate = self._robot.status()
        still = abs(gate.v) < STILL_M_S and abs(gate.w) < STILL_RAD_S
        return gate is not before and still and (request.kind == "stop" or gate.state == "halted")

    async def _show(self, query: Any) -> None:
        image = self._image
        if image is not None:
            if self._packed is None or self._packed[0] != image.stamp:
                self._packed = (
                    image.stamp,
                    await asyncio.to_thread(jpeg, image.pixels, MAX_PICTURE_SIDE_PX, PICTURE_QUALITY),
                )
            await self._reply(query, "picture", self._packed[1])
        query.drop()

    async def _admit(self, query: Any, request: bus.FleetKeyRequest) -> None:
        token = self._logins.issue(request.name[:60], request.role, end=time.monotonic() + KEY_LIFE_S)
        await self._reply(query, "key", msgspec.json.encode(bus.FleetKeyAnswer(token, self._certificate)))
        query.drop()


class FleetSession:
    """One connection with the fleet, until it is lost or closed; never used again afterwards."""

    def __init__(self, options: bus.MemberOptions, loop: asyncio.AbstractEventLoop, member: FleetMember) -> None:
        """From a thread. Raises Unavailable and BadInput with a sentence."""
        bus.check_handshake(options.address, options.files)
        zenoh = load_zenoh()
        self.lost = asyncio.Event()
        self._loop, self._put = loop, zenoh.SampleKind.PUT
        refused = Statement("fleet.no_bus", address=options.address.name)
        self._session = session = bus.open_session(bus.client_settings(options.address, options.files), refused)
        self._once = threading.Lock()
        name = options.name
        self._state_key, self._drop = bus.key_of(name, "state"), zenoh.CongestionControl.DROP
        try:
            self._kept = [session.info.declare_transport_events_listener(self._transport_changed)]
            self._check_admission(zenoh, options, refused)
            for what, act in (
                ("stop", member.asked_to_stand),
                ("picture", member.asked_for_picture),
                ("key", member.asked_for_key),
            ):
                self._kept.append(session.declare_queryable(bus.key_of(name, what), guarded(act)))
            self._kept.append(session.liveliness().declare_token(bus.key_of(name, "alive")))
            if not session.info.links():
                raise Unavailable(refused)
        except BaseException:
            self.close()
            raise

    def _check_admission(self, zenoh: Any, options: bus.MemberOptions, refused: Statement) -> None:
        """Ask whether we are let in: TLS takes a withdrawn certificate, too, and the router then hears nothing."""
        key = bus.key_of(options.name, "admission")
        for pause in (0.0, ADMISSION_PAUSE_S):  # a router that has just begun to listen may not answer yet
            time.sleep(pause)
            replies: queue.SimpleQueue[Any] = queue.SimpleQueue()  # None: there are no more
            asked = zenoh.handlers.Callback(replies.put, lambda replies=replies: replies.put(None))
            self._session.get(key, asked, timeout=bus.CONNECT_TIMEOUT_S)
            try:
                reply = replies.get(timeout=2 * bus.CONNECT_TIMEOUT_S)  # its own did not come once
            except queue.Empty:
                raise Unavailable(refused) from None
            if reply is not None and reply.ok is not None:
                return
            if reply is not None:  # the router did not answer in time
                raise Unavailable(refused)
        raise Unavailable(Statement("fleet.certificate_refused", address=options.address.name))

    def report(self, payload: bytes) -> None:
        """Send a report without waiting. A declared publisher would wait to hear who listens, which it may not."""
        with contextlib.suppress(Exception):  # zenoh's own error, of no common kind: then the transport is lost
            self._session.put(self._state_key, payload, congestion_control=self._drop, express=True)

    def hand_over(self, act: Callable[[], None]) -> None:
        """Do this on the event loop."""
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(act)

    def close(self) -> None:
        """Let go; harmless when done twice."""
        if self._once.acquire(blocking=False):
            farewell = threading.Thread(target=self._session.close, name="fleet-farewell", daemon=True)
            farewell.start()
            farewell.join(FAREWELL_S)

    def _transport_changed(self, event: Any) -> None:
        if event.kind != self._put:
            self.hand_over(self.lost.set)


def guarded(act: Callable[[Any], None]) -> Callable[[Any], None]:
    """A malformed question is not answered."""

    def answer(query: Any) -> None:
        with contextlib.suppress(msgspec.MsgspecError, AttributeError):
            act(query)

    return answer
