"""Words that steer a route of named places; the console carries them out, stop by stop, with other commands."""

from dataclasses import dataclass

from core.commands.command import Action, Command, CommandSpec
from core.errors import Refused
from core.navigation.control_context import ControlContext
from core.sentences import Statement


@dataclass(frozen=True, kw_only=True)
class RouteCommand(CommandSpec):
    """Begins nothing by itself."""

    def begin(self, command: Command, ctx: ControlContext) -> Action:
        """Refuse: a robot without the console knows no routes."""
        raise Refused(Statement("routes.gone"))


def _route_command(
    name: str, words: tuple[str, ...], example: str, summary: str, *, moves: bool = True
) -> RouteCommand:
    """One that moves the robot goes to a place; one that does not needs no pose."""
    target = "place" if moves else "none"
    return RouteCommand(
        name=name, words=words, example=example, summary=summary, moves=moves, target=target, needs_pose=moves
    )


START_ROUTE = _route_command(
    "start_route",
    ("start the route {name}", "start route {name}"),
    "start the route round",
    Statement("routes.starts"),
)
PAUSE_ROUTE = _route_command(
    "pause_route", ("pause", "pause the route"), "pause the route", Statement("routes.stands"), moves=False
)
RESUME_ROUTE = _route_command(
    "resume_route", ("go on", "go on with the route"), "go on with the route", Statement("routes.goes_on")
)
ROUTE_COMMANDS = (START_ROUTE, PAUSE_ROUTE, RESUME_ROUTE)
