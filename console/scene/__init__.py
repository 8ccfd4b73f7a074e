"""The 3-D scene: shows, and never commands. A click into it only proposes, through the one dispatcher.

An overlay makes its handles once, `show(snapshot)` sets properties. The list is the table of contents.
"""

import asyncio
import logging
import threading
from collections.abc import Callable, Sequence
from typing import Protocol

from starlette.websockets import WebSocket
from viser import SceneApi

from console.access.logins import Person
from console.access.open_sockets import OpenSockets, TooMany
from console.control.dispatcher import CommandDispatcher
from console.control.own_navigation import OwnMapView
from console.messages import state as messages
from console.robot.supervisor import RobotSupervisor
from console.scene.click_to_go import ClickToGo
from console.scene.overlays.landmarks import Associations, Landmarks
from console.scene.overlays.marks import MarksOnMap, ShownMarks
from console.scene.overlays.occupancy import GroundGrid, Occupancy
from console.scene.overlays.people import People, VoiceWedges
from console.scene.overlays.plan import Plan, PreviewLines
from console.scene.overlays.pose_ellipse import CandidatePoses, PoseEllipse
from console.scene.overlays.robot import DeadReckoningGhost, OtherWayGhost, RobotBody, TrailLine
from console.scene.overlays.robots_own_map import RobotsOwnMap
from console.scene.overlays.scan import ScanPoints
from console.scene.overlays.submaps import LoopClosureArcs, Submaps
from console.scene.viser_host.bridge import Bridge
from console.scene.viser_host.mount import NoSocketServer, QuietViser, close_viser, open_viser
from core.commands.command import Command
from core.errors import Unavailable
from core.robots import Profile
from core.snapshot import Snapshot

log = logging.getLogger(__name__)

PICTURE_PERIOD_S = 0.05  # at least between two pictures of the scene
MAX_FAILURES = 5  # in a row after which the scene is left as it is


class Drawable(Protocol):
    def show(self, snapshot: Snapshot) -> None:
        """Set what has changed."""
        ...


class Overlay(Drawable, Protocol):
    """Overlays that show nothing but snapshots."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None: ...


OVERLAYS: tuple[type[Overlay], ...] = (
    GroundGrid,
    Occupancy,
    Submaps,
    ScanPoints,
    TrailLine,
    DeadReckoningGhost,
    OtherWayGhost,
    Landmarks,
    Associations,
    LoopClosureArcs,
    CandidatePoses,
    PoseEllipse,
    VoiceWedges,
    People,
    Plan,
    RobotBody,
)


class Scene:
    """Draws the newest snapshot in a thread of its own, so that no picture ever makes the pilot late."""

    def __init__(
        self,
        robot: RobotSupervisor,
        complain: Callable[[str], None],
        waiting: Callable[[], Command | None],
        own_map: Callable[[], OwnMapView | None],
        marks: Callable[[], ShownMarks] = lambda: ((), ()),
    ) -> None:
        """`complain`, from any thread: why the scene is left as it is; `waiting`: the command that waits, if any;
        `own_map`: the robot's own map while it is shown; `marks`: places and zones of the map.
        """
        self.why_not = ""  # why there is no scene; "" when there is one
        self.tabs: dict[str, Callable[[messages.AnswerMessage], None]] = {}  # how to tell each open page something
        self._robot = robot
        self._complain = complain
        self._waiting = waiting
        self._own_map, self._marks = own_map, marks
        self._server: QuietViser | None = None
        self._inside: NoSocketServer | None = None
        self._sockets = OpenSockets()
        self._newest: Snapshot | None = None
        self._watchers = 0
        self._news = threading.Event()
        self._over = threading.Event()
        self._painter: threading.Thread | None = None

    async def open(self, dispatcher: CommandDispatcher, sockets: OpenSockets) -> None:
        """Mount it. Without a scene the console goes on, and says why."""
        self._sockets = sockets
        try:
            self._server, self._inside = await asyncio.to_thread(open_viser)
        except Unavailable as trouble:
            self.why_not = str(trouble)
            log.error("No 3-D scene: %s", trouble)
            return
        ClickToGo(self._server, dispatcher, self.tabs, asyncio.get_running_loop())
        self._painter = threading.Thread(target=self._paint, args=(self._server,), name="scene", daemon=True)
        self._painter.start()

    async def close(self) -> None:
        self._over.set()
        self._news.set()
        if self._painter is not None:
            await asyncio.to_thread(self._painter.join, 2.0)
        if self._server is not None:
            await asyncio.to_thread(close_viser, self._server)

    def show(self, snapshot: Snapshot) -> None:
        """From any thread: this is the newest. Nothing is drawn while nobody looks."""
        self._newest = snapshot
        if self._watchers:
            self._news.set()

    async def talk(self, socket: WebSocket, person: Person, tab: str) -> None:
        if self._inside is None:
            await socket.accept()
            await socket.close(1011, self.why_not)
            return
        bridge = Bridge(socket, self._inside, person, tab)
        try:
            with self._sockets.room_for(person, bridge.close):
                self._watchers += 1
                self._news.set()
                try:
                    await bridge.run()
                finally:
                    self._watchers -= 1
        except TooMany as crowded:
            await socket.accept()
            await socket.close(1013, str(crowded))

    def _paint(self, server: QuietViser) -> None:
        try:
            overlays = [overlay(server.scene, self._robot.profile) for overlay in OVERLAYS]
            intended = PreviewLines(server.scene, self._robot.profile, self._waiting)
            own = RobotsOwnMap(server.scene, self._robot.profile, self._own_map)
            marked = MarksOnMap(server.scene, self._robot.profile, self._marks)
            self._draw(server, [own, *overlays, marked, intended])
        except Exception:
            log.exception("The scene could not be drawn any more")
            self.why_not = "The 3-D scene cannot be drawn and stays as it is; the log says why. All else goes on."
            self._complain(self.why_not)

    def _draw(self, server: QuietViser, overlays: Sequence[Drawable]) -> None:
        """Draw what is newest until it is over. Raises what keeps failing."""
        failures = 0
        while not self._over.is_set():
            self._news.wait()
            self._news.clear()
            snapshot = self._newest
            if snapshot is None or self._over.is_set():
                continue
            try:
                with server.atomic():
                    for overlay in overlays:
                        overlay.show(snapshot)
                server.flush()
                failures = 0
            except Exception:
                failures += 1
                if failures >= MAX_FAILURES:
                    raise
                log.exception("The scene could not be drawn")
            self._over.wait(PICTURE_PERIOD_S)
