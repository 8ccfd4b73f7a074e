"""Words that steer a route of named places; the console carries them out, stop by stop, with other commands."""

from __future__ import annotations

from dataclasses import dataclass

from core.commands.command import Action, Command, CommandSpec, Target
from core.errors import Refused
from core.navigation.control_context import ControlContext
from core.sentences import Statement


@dataclass(frozen=True, kw_only=True)
class RouteCommand(CommandSpec):
    """Begins nothing by itself."""

    needs_pose: bool = True

    def begin(self, command: Command, ctx: ControlContext) -> Action:
        """Refuse: a robot without the console knows no routes."""
        raise Refused(Statement("routes.gone"))


TO_A_PLACE: Target = "place"
START_ROUTE = RouteCommand(
    name="start_route",
    words=("start the route {name}", "start route {name}"),
    example="start the route round",
    summary=Statement("routes.starts"),
    target=TO_A_PLACE,
)
PAUSE_ROUTE = RouteCommand(
    name="pause_route",
    words=("pause", "pause the route"),
    example="pause the route",
    summary=Statement("routes.stands"),
    moves=False,
    needs_pose=False,
)
RESUME_ROUTE = RouteCommand(
    name="resume_route",
    words=("go on", "go on with the route"),
    example="go on with the route",
    summary=Statement("routes.goes_on"),
    target=TO_A_PLACE,
)
ROUTE_COMMANDS = (START_ROUTE, PAUSE_ROUTE, RESUME_ROUTE)
