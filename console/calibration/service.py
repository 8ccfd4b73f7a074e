"""The calibration service: every calibration session, what is in use, and the robot's pictures for both."""

import asyncio
import secrets
import time
from collections.abc import Callable
from pathlib import Path

import msgspec

from console.broadcast import Broadcaster
from console.calibration import answers
from console.calibration.answers import Document
from console.calibration.apply import calibrated, laser_start
from console.calibration.calibration_store import NAMES, CalibrationStore
from console.calibration.camera_worker import CameraWorker
from console.calibration.codec import board_of
from console.calibration.demo import demo_of
from console.calibration.live_capture import LiveCapture, grey_picture
from console.calibration.session import (
    PICTURE_BUDGET_S,
    CalibrationSession,
    CameraCalibrationSession,
    LaserCalibrationSession,
)
from console.calibration.session_store import (
    FORM_VERSION,
    SessionInfo,
    SessionStore,
    StoredMount,
    StoredSession,
    kept_sessions,
)
from console.calibration.solver_worker import SolverWorker
from console.http.problems import Problem
from console.messages import filled
from console.messages import state as messages
from console.messages.calibration import (
    CalibrationBoard,
    CalibrationKind,
    CalibrationNews,
    CalibrationSessionState,
    CalibrationSource,
)
from console.part import Part
from console.robot.supervisor import RobotSupervisor
from console.workers.demo_runner import DemoRunner
from console.workers.tasks import QueueLimit, end
from console.workers.worker import Worker
from core.calibration.reports import CameraReport, LaserReport
from core.robots import Profile
from core.robots.requests import AnswerT, RobotRequest
from core.sensors import Image, SensorFrame
from core.snapshot import Level, Snapshot

# Session updates for the page: the newest only, and not too often.

STATE_GAP_S = 0.1  # at least between two states of one session, unless it is urgent


class SessionUpdates:
    """Lives on the event loop. Every session is a kind of its own in the broadcaster."""

    def __init__(self, broadcaster: Broadcaster) -> None:
        self._broadcaster = broadcaster
        self._published_at: dict[str, float] = {}
        self._later: dict[str, asyncio.TimerHandle] = {}

    def watched(self, session_id: str) -> bool:
        return self._broadcaster.watched(topic_of(session_id))

    def changed(self, session: CalibrationSessionState, *, urgent: bool) -> None:
        """Publish at most ten times a second; at once, when it is urgent."""
        if not self.watched(session.id):
            return
        wait = self._published_at.get(session.id, 0.0) + STATE_GAP_S - time.monotonic()
        if urgent or wait <= 0:
            self.publish(session)
        elif session.id not in self._later:
            self._later[session.id] = asyncio.get_running_loop().call_later(wait, self.publish, session)

    def publish(self, session: CalibrationSessionState) -> None:
        if (waiting := self._later.pop(session.id, None)) is not None:
            waiting.cancel()
        self._published_at[session.id] = time.monotonic()
        self._broadcaster.publish(topic_of(session.id), messages.encode(CalibrationNews(session)).decode())

    def forget(self, session_id: str) -> None:
        if (waiting := self._later.pop(session_id, None)) is not None:
            waiting.cancel()
        self._published_at.pop(session_id, None)
        self._broadcaster.forget(topic_of(session_id))


def topic_of(session_id: str) -> str:
    return f"calibration:{session_id}"


MOST_SESSIONS = 100
FORGET_SESSION_S = 600.0  # without anybody who looks, after which a session looks no more
MOST_PICTURES, MOST_EXPORTS = 8, 3  # whole pictures and zips that may be asked for at once
KINDS: tuple[CalibrationKind, ...] = ("camera", "laser")
MAX_IDLE_S = 180.0  # after which a worker that nobody needs is ended


class CalibrationService(Part):
    """Lives on the event loop. One per console."""

    def __init__(
        self,
        home: Path,
        robot: RobotSupervisor,
        broadcaster: Broadcaster,
        tell: Callable[[Level, str], None],
        recalibrated: Callable[[], None],
        *,
        printed: bool = False,
    ) -> None:
        """`tell` hangs a notice; `recalibrated` is called whenever another calibration is in use;
        `printed`: solve and write as the chapter does (eq. 13, eq. 44).
        """
        self._printed = printed
        self.active = CalibrationStore(home / "calibration")
        self.sessions: dict[str, CalibrationSession] = {}
        self.solver = Worker("solver")
        self.picture_turns, self.export_turns = QueueLimit(MOST_PICTURES), QueueLimit(MOST_EXPORTS)
        self.newest: Image | None = None  # the robot's picture; set by the pilot's thread
        self._drives = False  # a command was under way in the newest snapshot
        self._home = home / "calibration"
        self._robot, self._tell, self._recalibrated = robot, tell, recalibrated
        self._news = SessionUpdates(broadcaster)
        self._live: dict[str, LiveCapture] = {}
        self._demo = DemoRunner()

    # life

    async def open(self) -> None:
        await asyncio.to_thread(self.active.open)
        for kept in await asyncio.to_thread(lambda: list(kept_sessions(self._home))):
            shown = kept.shown
            shown.live = shown.demo = False
            shown.solving = shown.scan = None
            self._make_session(kept)
        for trouble in self.active.troubles:
            self._tell("warning", trouble)

    async def close(self) -> None:
        """End every worker and wait until it is gone; the sessions stay on disk."""
        await self._demo.stop()
        await end(*(live.task for live in self._live.values()))
        for session in self.sessions.values():
            session.close()
        self.solver.kill()
        await asyncio.gather(self.solver.gone(), *(session.gone() for session in self.sessions.values()))

    def tick(self, now: float) -> None:
        """Now and then: workers that nobody has needed for a while are ended, and looking that nobody looks at."""
        for name in list(self._live):
            session = self.sessions[name]
            if self._news.watched(name) or self._demo.shows(name):
                session.looked_at = now
            elif now - session.looked_at > FORGET_SESSION_S:
                self.live(session, on=False)
        for session in self.sessions.values():
            if session.pid is not None and not session.busy and now - session.used > MAX_IDLE_S:
                session.close()
        if self.solver.alive and not self.solver.busy and not any(s.pid for s in self.sessions.values()):
            self.solver.kill()

    # sessions

    def find(self, session_id: str) -> CalibrationSession:
        """Raises Problem 404."""
        session = self.sessions.get(session_id)
        if session is None:
            raise Problem(404, "There is no such calibration session; it may have been deleted.")
        session.looked_at = time.monotonic()
        return session

    async def begin(
        self, kind: CalibrationKind, source: CalibrationSource, board: CalibrationBoard, height: float | None
    ) -> CalibrationSession:
        """A new session. One of its kind that looked at the robot, saw nothing, and that nobody watches, goes.

        Raises Problem 409, BadInput.
        """
        board_of(board)
        if len(self.sessions) >= MOST_SESSIONS:
            raise Problem(409, f"{MOST_SESSIONS} calibration sessions are kept already; delete some first.")
        if source == "robot" and self._robot.profile.camera is None:
            raise Problem(409, "This robot has no camera; upload pictures instead.")
        card = SessionInfo(secrets.token_hex(6), kind, source, board, time.time())
        if kind == "laser":
            card.camera, mount = laser_start(self._robot.profile, source, self.active.camera, height)
            card.mount = StoredMount.of(mount)
        shown = CalibrationSessionState(card.id, kind, source, board, card.created_s, height_m=height)
        for other in list(self.sessions.values()):
            if other.card.kind != kind:
                continue
            if other.card.source == "robot" and not other.shown.views and not self._news.watched(other.card.id):
                await self.delete(other)
            else:
                self.rest(other)
        session = self._make_session(StoredSession(FORM_VERSION, card, shown))
        await session.save()
        return session

    async def delete(self, session: CalibrationSession) -> None:
        """Delete a session for good; a calibration accepted from it stays in use."""
        self.rest(session)
        self.sessions.pop(session.card.id, None)
        self._news.forget(session.card.id)
        await session.remove()

    def rest(self, session: CalibrationSession) -> None:
        """Look no more, and let its worker go."""
        if self._demo.shows(session.card.id):
            self._demo.cancel()
        self.live(session, on=False)
        session.close()

    def _make_session(self, kept: StoredSession) -> CalibrationSession:
        card = kept.card
        kind = CameraCalibrationSession if card.kind == "camera" else LaserCalibrationSession
        session = kind(kept, SessionStore(self._home / card.id), self.solver, self._changed, self._warn)
        session.printed = self._printed
        session.compare = lambda: self.active.compare(card.kind, kept.shown.solution or {})
        self.sessions[card.id] = session
        return session

    # in use

    def calibrated(self, profile: Profile) -> Profile:
        """The robot as its camera and laser were calibrated; a notice says why a calibration is not used."""
        profile, reasons = calibrated(profile, self.active)
        for why_not in reasons.values():
            self._warn(why_not)
        return profile

    def used(self) -> dict[CalibrationKind, Document | None]:
        """The reports of the accepted calibrations, by kind, each with why it is not used, or ''; None: as built."""
        reasons = calibrated(self._robot.profile, self.active)[1]
        reports: dict[CalibrationKind, Document | None] = dict.fromkeys(KINDS)
        for kind in KINDS:
            if (report := self.active.report(kind)) is not None:
                reports[kind] = {**report, "not_used": reasons.get(kind, "")}
        return reports

    def leave_out(self, why: str) -> list[str]:
        """Use the accepted calibrations no more in this run → the files that were in use until now."""
        reasons = calibrated(self._robot.profile, self.active)[1]
        files: list[str] = []
        for kind in KINDS:
            if self.active.report(kind) is not None and kind not in reasons:
                self.active.left_out[kind] = why
                files.append(f"{NAMES[kind]}.json")
        return files

    async def accept(self, session: CalibrationSession, *, force: bool, who: str) -> CameraReport | LaserReport:
        """Use a session's calibration from now on → its report. Raises Refused with the reason."""
        await self.show_demo(session, on=False)
        self.live(session, on=False)  # the calibration that was looked through is the one in use
        accepted = await session.accept(force=force)
        await self.use(session.card.kind, {**accepted.document}, {**accepted.report}, who)
        session.shown.accepted_s = time.time()
        await session.save()
        session.show(urgent=True)
        return accepted.report

    async def read(
        self, text: str, who: str
    ) -> tuple[CalibrationKind, answers.ImportedCameraReport | answers.ImportedMountReport]:
        """Use the camera or the mount in a file of any form from now on → its kind and report. Raises BadInput."""
        found = await self.solver.ask(SolverWorker.read_file(text, self.active.camera), budget=PICTURE_BUDGET_S)
        if isinstance(found, answers.ImportedMount):
            kind, document = "laser", {**found.document, "extrinsics": found.extrinsics}
        else:
            kind, document = "camera", {**found.document}
        await self.use(kind, document, {**found.report}, who)
        return kind, found.report

    async def use(self, kind: CalibrationKind, document: Document, report: Document, who: str) -> None:
        """A document with its report becomes the calibration in use. Raises BadInput, Problem 503."""
        await asyncio.to_thread(self.active.put, kind, document, report, who)
        self._recalibrated()

    async def undo(self, kind: CalibrationKind) -> None:
        """Take the former calibration back. Raises Problem 409."""
        await asyncio.to_thread(self.active.undo, kind)
        self._recalibrated()

    def _warn(self, words: str) -> None:
        self._tell("warning", words)

    # looking

    def live(self, session: CalibrationSession, *, on: bool) -> None:
        """Look at the robot's pictures and scans by itself, or stop it. Raises Problem 409."""
        if on and session.card.source != "robot":
            raise Problem(409, "This session does not look at the robot; send it pictures.")
        live = self._live.pop(session.card.id, None)
        if on:
            for other in self.sessions.values():
                if other is not session and other.card.kind == session.card.kind:
                    self.rest(other)
            laser = self._robot.profile.laser
            live = live or LiveCapture(session, laser.name if laser is not None else "")
            self._live[session.card.id] = live
            live.task.add_done_callback(lambda _: self._looked(session, live))
        elif live is not None:
            live.end()
        if session.shown.live != on:
            session.shown.live = on
            session.show(urgent=True)

    def _looked(self, session: CalibrationSession, live: LiveCapture) -> None:
        if self._live.get(session.card.id) is live and not live.task.cancelled():
            self.live(session, on=False)

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        """Keep its picture; show the frame to the sessions that look at the robot."""
        self.newest = frame.image or self.newest
        self._drives = snapshot.active_command is not None
        for live in self._live.values():
            live.saw(frame)

    async def capture(self, session: CalibrationSession) -> None:
        """The robot's newest picture, taken on purpose. Raises Problem 409, 503."""
        if session.card.source != "robot" or session.card.kind != "camera":
            raise Problem(409, "Only a camera session that looks at the robot takes its pictures on purpose.")
        if self.newest is None or self._robot.link()[0] != "live":
            raise Problem(503, "No picture comes from the robot now.")
        image = self.newest
        await session.act(CameraWorker.take_picture(grey_picture(image)), budget=PICTURE_BUDGET_S, stamp=image.stamp)

    async def show_demo(self, session: CalibrationSession, *, on: bool) -> None:
        """The simulated person holds the board for this session, or stops. Raises Problem 409."""
        if on:
            if self._drives:  # the board would stand in the laser's way, and cost the robot its place
                raise Problem(409, "The robot is driving. Press STOP first; then the person comes with the board.")
            self.live(session, on=True)
            await self._demo.start(demo_of(session, self._ask, seed=len(self.sessions)))
        elif self._demo.shows(session.card.id):
            await self._demo.stop()

    async def _ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        return await asyncio.to_thread(self._robot.ask, request)

    # updates

    def show(self, session_id: str) -> None:
        """A viewer begins to look at a session: publish it as it is."""
        if session_id in self.sessions:
            self._news.publish(self.sessions[session_id].shown)

    def _changed(self, session: CalibrationSession, urgent: bool) -> None:
        if session.card.id in self.sessions:
            self._news.changed(session.shown, urgent=urgent)


class SessionRow(msgspec.Struct, frozen=True):
    """A session in the list of all."""

    id: str
    kind: CalibrationKind
    source: CalibrationSource
    created_s: float
    views: int
    ready: bool
    accepted: bool
    accepted_s: float | None


class SessionList(msgspec.Struct, frozen=True):
    """All sessions, the newest first."""

    sessions: list[SessionRow]


def listed(session: CalibrationSession) -> SessionRow:
    shown = session.shown
    views, ready = shown.progress.views, shown.progress.ready
    return filled(SessionRow, shown, views=views, ready=ready, accepted=shown.accepted_s is not None)
