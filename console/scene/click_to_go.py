"""Click to go: where the ray meets the floor becomes words for the one dispatcher."""

import asyncio
from collections.abc import Callable, Mapping

from viser import SceneClickEvent

from console.access.logins import Person
from console.control.dispatcher import CommandDispatcher
from console.http.problems import Problem, refused
from console.messages import state as messages
from console.scene.viser_host.mount import QuietViser, websocket_server
from core.commands.command import Command
from core.commands.stop_at import STOP_AT
from core.errors import BeckonError
from core.geometry import floor_point
from core.speech.understanding.grammar import command_of

CAMERA_AT, CAMERA_LOOKS = (-2.0, 0.0, 3.6), (0.55, 0.0, 0.0)  # [m]: down at about 55 degrees

Tell = Callable[[messages.AnswerMessage], None]


class ClickToGo:
    """Proposes "stop at x and y" as the person signed in at the tab that was clicked."""

    def __init__(
        self,
        server: QuietViser,
        dispatcher: CommandDispatcher,
        tabs: Mapping[str, Tell],
        loop: asyncio.AbstractEventLoop,
    ) -> None:
        self._server = server
        self._dispatcher = dispatcher
        self._tabs = tabs
        self._loop = loop
        server.initial_camera.position = CAMERA_AT
        server.initial_camera.look_at = CAMERA_LOOKS
        server.initial_camera.fov = 0.85
        server.scene.on_click()(self._clicked)

    def _clicked(self, event: SceneClickEvent) -> None:
        connection = websocket_server(self._server)._live_connections.get(event.client_id)
        place = floor_point(event.ray_origin, event.ray_direction)
        if connection is not None and connection.person is not None and place is not None:
            self._loop.call_soon_threadsafe(self._propose, connection.person, connection.tab, place)

    def _propose(self, person: Person, tab: str, place: tuple[float, float]) -> None:
        x, y = (round(value, 2) + 0.0 for value in place)
        try:
            goal = command_of(STOP_AT.name, {"x_m": x, "y_m": y})
            words = goal.heard_as if isinstance(goal, Command) else f"({x:g}, {y:g})"
            entry = self._dispatcher.accept(goal, words, "click", person)
            answer = messages.AnswerMessage(0, True, 202, entry.heard_as, id=entry.id)
        except (Problem, BeckonError) as error:
            answer = refused(0, error)
        if tab in self._tabs:
            self._tabs[tab](answer)
