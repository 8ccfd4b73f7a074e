"""The workbench: every calibration session, what is in use, and the way of the robot's pictures to both."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec

from console.calibration.folder import VERSION, Card, Folder, Kept, kept_sessions
from console.calibration.in_use import NAMES, InUse
from console.calibration.live import Live, grey_told
from console.calibration.news import News
from console.calibration.robot_sensors import calibrated, laser_start
from console.calibration.showing import show
from console.calibration.sitting import PICTURE_BUDGET, Sitting
from console.calibration.turns import Turns
from console.calibration.values import board_of, camera_told
from console.latest import Hub
from console.problems import Problem
from console.robot_link import RobotLink
from console.tasks import end
from console.wire_calibration import CalibrationBoard, CalibrationKind, CalibrationSession, CalibrationSource
from console.workers import Worker
from core.robots import Profile
from core.sensors import Image, SensorFrame
from core.snapshot import Level

MOST_SESSIONS = 100
FORGOTTEN = 600.0  # [s] without anybody who looks, after which a session looks no more
MOST_PICTURES, MOST_EXPORTS = 8, 3  # whole pictures and zips that may be asked for at once
KINDS: tuple[CalibrationKind, ...] = ("camera", "laser")
IDLE = 180.0  # [s] after which a worker that nobody needs is ended


class Workbench:
    """Lives on the event loop. One per console."""

    def __init__(
        self,
        home: Path,
        robot: RobotLink,
        hub: Hub,
        tell: Callable[[Level, str], None],
        used: Callable[[Profile], None],
    ) -> None:
        """`tell` hangs a notice; `used` hears of the robot's profile whenever another calibration is in use."""
        self.in_use = InUse(home / "calibration")
        self.sittings: dict[str, Sitting] = {}
        self.back_room = Worker("back room")
        self.picture_turns, self.export_turns = Turns(MOST_PICTURES), Turns(MOST_EXPORTS)
        self.newest: Image | None = None  # the robot's picture; set by the pilot's thread
        self.watching = False  # some session wants the robot's frames
        self._home = home / "calibration"
        self._robot, self._tell, self._used = robot, tell, used
        self._news = News(hub)
        self._live: dict[str, Live] = {}
        self._shows: dict[str, asyncio.Task[None]] = {}

    # life

    async def open(self) -> None:
        """Find what was there before."""
        await asyncio.to_thread(self.in_use.open)
        for kept in await asyncio.to_thread(lambda: list(kept_sessions(self._home))):
            shown = kept.shown
            shown.live = shown.showing = False
            shown.solving = shown.scan = None
            self._seat(kept)
        for trouble in self.in_use.troubles:
            self._tell("warning", trouble)

    async def close(self) -> None:
        """End every worker and wait until it is gone; the sessions stay on disk."""
        await end(*self._shows.values(), *(live.task for live in self._live.values()))
        for sitting in self.sittings.values():
            sitting.close()
        self.back_room.kill()
        await asyncio.gather(self.back_room.gone(), *(sitting.gone() for sitting in self.sittings.values()))

    def tick(self, now: float) -> None:
        """Now and then: workers that nobody has needed for a while are ended, and looking that nobody looks at."""
        for name in list(self._live):
            sitting = self.sittings[name]
            if self._news.watched(name) or name in self._shows:
                sitting.looked_at = now
            elif now - sitting.looked_at > FORGOTTEN:
                self.live(sitting, on=False)
        for sitting in self.sittings.values():
            if sitting.pid is not None and not sitting.busy and now - sitting.used > IDLE:
                sitting.close()
        if self.back_room.alive and not self.back_room.busy and not any(s.pid for s in self.sittings.values()):
            self.back_room.kill()

    # sessions

    def find(self, session_id: str) -> Sitting:
        """Raises Problem 404."""
        sitting = self.sittings.get(session_id)
        if sitting is None:
            raise Problem(404, "There is no such calibration session; it may have been deleted.")
        sitting.looked_at = time.monotonic()
        return sitting

    async def begin(
        self, kind: CalibrationKind, source: CalibrationSource, board: CalibrationBoard, height: float | None
    ) -> Sitting:
        """A new session. Raises Problem 409, BadInput."""
        board_of(msgspec.to_builtins(board))
        if len(self.sittings) >= MOST_SESSIONS:
            raise Problem(409, f"{MOST_SESSIONS} calibration sessions are kept already; delete some first.")
        if source == "robot" and self._robot.profile.camera is None:
            raise Problem(409, "This robot has no camera; upload pictures instead.")
        card = Card(secrets.token_hex(6), kind, source, board, time.time())
        if kind == "laser":
            card.camera, card.mount = laser_start(self._robot.profile, source, self.in_use.camera, height)
        shown = CalibrationSession(card.id, kind, source, board, card.created_s, height_m=height)
        for other in list(self.sittings.values()):
            if other.card.kind == kind:
                self.rest(other)
        sitting = self._seat(Kept(VERSION, card, shown))
        await sitting.save()
        return sitting

    async def delete(self, sitting: Sitting) -> None:
        """For good; what was accepted from it stays in use."""
        self.rest(sitting)
        self.sittings.pop(sitting.card.id, None)
        self._news.forget(sitting.card.id)
        await sitting.remove()

    def rest(self, sitting: Sitting) -> None:
        """Look no more, and let its worker go."""
        if (task := self._shows.get(sitting.card.id)) is not None:
            task.cancel()
        self.live(sitting, on=False)
        sitting.close()

    def _seat(self, kept: Kept) -> Sitting:
        card = kept.card
        sitting = Sitting(kept, Folder(self._home / card.id), self.back_room, self._changed, self._warn)
        sitting.compare = lambda: self.in_use.compare(card.kind, kept.shown.solution or {})
        self.sittings[card.id] = sitting
        return sitting

    # in use

    def profile(self) -> Profile:
        """The robot as calibrated; why a calibration is not used is told."""
        profile, reasons = calibrated(self._robot.profile, self.in_use)
        for why_not in reasons.values():
            self._warn(why_not)
        return profile

    def used(self) -> dict[str, Any]:
        """The reports of what was accepted, by kind, each with why it is not used, or ''; None: as built."""
        reasons = calibrated(self._robot.profile, self.in_use)[1]
        told: dict[str, Any] = dict.fromkeys(KINDS)
        for kind in KINDS:
            if (report := self.in_use.report(kind)) is not None:
                told[kind] = {**report, "not_used": reasons.get(kind, "")}
        return told

    def leave_out(self, why: str) -> list[str]:
        """Use the accepted calibrations no more in this run → the files that were in use until now."""
        reasons = calibrated(self._robot.profile, self.in_use)[1]
        files: list[str] = []
        for kind in KINDS:
            if self.in_use.report(kind) is not None and kind not in reasons:
                self.in_use.left_out[kind] = why
                files.append(f"{NAMES[kind]}.json")
        return files

    async def accept(self, sitting: Sitting, *, anyway: bool, who: str) -> dict[str, Any]:
        """Use a session's calibration from now on → its report. Raises Refused with the reason."""
        await self.show_me(sitting, on=False)
        self.live(sitting, on=False)  # what was looked through is what is used
        told = await sitting.accept(anyway=anyway)
        await self.use(sitting.card.kind, told, who)
        sitting.session.accepted_s = time.time()
        await sitting.save()
        sitting.show(urgent=True)
        return told["report"]

    async def read(self, text: str, who: str) -> dict[str, Any]:
        """Use the camera or the mount in a file of any form from now on → its kind and report. Raises BadInput."""
        model = self.in_use.camera
        given = {"text": text, "camera": None if model is None else camera_told(model)}
        told = await self.back_room.ask("read_file", given, budget=PICTURE_BUDGET)
        await self.use(told["kind"], told, who)
        return {"kind": told["kind"], **told["report"]}

    async def use(self, kind: CalibrationKind, told: dict[str, Any], who: str) -> None:
        """A document with its report becomes the calibration in use. Raises BadInput, Problem 503."""
        await asyncio.to_thread(self.in_use.put, kind, told["document"], told["report"], who)
        self._used(self.profile())

    async def undo(self, kind: CalibrationKind) -> None:
        """Take the former calibration back. Raises Problem 409."""
        await asyncio.to_thread(self.in_use.undo, kind)
        self._used(self.profile())

    def _warn(self, words: str) -> None:
        self._tell("warning", words)

    # looking

    def live(self, sitting: Sitting, *, on: bool) -> None:
        """Look at the robot's pictures and scans by itself, or stop it. Raises Problem 409."""
        if on and sitting.card.source != "robot":
            raise Problem(409, "This session does not look at the robot; send it pictures.")
        live = self._live.pop(sitting.card.id, None)
        if on:
            for other in self.sittings.values():
                if other is not sitting and other.card.kind == sitting.card.kind:
                    self.rest(other)
            self._live[sitting.card.id] = live = live or Live(sitting)
            live.task.add_done_callback(lambda _: self._looked(sitting, live))
        elif live is not None:
            live.end()
        self.watching = bool(self._live)
        if sitting.session.live != on:
            sitting.session.live = on
            sitting.show(urgent=True)

    def _looked(self, sitting: Sitting, live: Live) -> None:
        """It has ended, perhaps by itself."""
        if self._live.get(sitting.card.id) is live and not live.task.cancelled():
            self.live(sitting, on=False)

    def saw(self, frame: SensorFrame) -> None:
        """A frame of the robot."""
        for live in self._live.values():
            live.saw(frame)

    async def capture(self, sitting: Sitting) -> None:
        """The robot's newest picture, taken on purpose. Raises Problem 409, 503."""
        if sitting.card.source != "robot" or sitting.card.kind != "camera":
            raise Problem(409, "Only a camera session that looks at the robot takes its pictures on purpose.")
        if self.newest is None or self._robot.link()[0] != "live":
            raise Problem(503, "No picture comes from the robot now.")
        image = self.newest
        await sitting.act("capture", grey_told(image), budget=PICTURE_BUDGET, stamp=image.stamp)

    async def show_me(self, sitting: Sitting, *, on: bool) -> None:
        """The simulated assistant holds the board for this session, or stops. Raises Problem 409."""
        await end(self._shows.pop(sitting.card.id, None))
        if on:
            for other in list(self._shows):
                await self.show_me(self.sittings[other], on=False)
            self.live(sitting, on=True)
            task = asyncio.get_running_loop().create_task(self._show(sitting))
            self._shows[sitting.card.id] = task

    async def _show(self, sitting: Sitting) -> None:
        sitting.session.showing = True
        sitting.show(urgent=True)
        try:
            await show(sitting, self._ask, seed=len(self.sittings))
        finally:
            sitting.session.showing = False
            sitting.show(urgent=True)
            self._shows.pop(sitting.card.id, None)

    async def _ask(self, request: dict[str, Any]) -> dict[str, Any]:
        return await asyncio.to_thread(self._robot.ask, request)

    # telling

    def show(self, session_id: str) -> None:
        """Somebody begins to look at a session: it is told as it is."""
        if session_id in self.sittings:
            self._news.publish(self.sittings[session_id].session)

    def _changed(self, sitting: Sitting, urgent: bool) -> None:
        if sitting.card.id in self.sittings:
            self._news.changed(sitting.session, urgent=urgent)


def listed(sitting: Sitting) -> dict[str, Any]:
    """A session in the list of all."""
    session = sitting.session
    return {
        "id": session.id,
        "kind": session.kind,
        "source": session.source,
        "created_s": session.created_s,
        "views": session.progress.views,
        "ready": session.progress.ready,
        "accepted": session.accepted_s is not None,
        "accepted_s": session.accepted_s,
    }
