"""STOP AT x AND y: the robot moves towards the goal point (x, y) and stops there."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from core.commands.command import Action, Command, CommandPreview, CommandSpec, Parameter, Progress, Target
from core.commands.routes import START_ROUTE
from core.geometry import Pose
from core.message import Array
from core.navigation.control_context import ControlContext, as_it_is
from core.navigation.goal_controller import GoalAim, GoalController
from core.navigation.places import NamedPlace
from core.sentences import Statement


@dataclass(frozen=True, kw_only=True)
class StopAt(CommandSpec):
    """To a place in the world frame."""

    name: str = "stop_at"
    words: tuple[str, ...] = (
        "stop at {x_m} and {y_m}",
        "stop at {x_m} and {y_m} meters",
        "stop at {x_m} meters and {y_m} meters",
        "go to {x_m} and {y_m}",
        "go to {x_m} and {y_m} meters",
        "go to {x_m} meters and {y_m} meters",
    )
    numbers: tuple[Parameter, ...] = (
        Parameter(name="x_m", says="x", unit="m", low=-20.0, high=20.0, spoken_high=5.0),
        Parameter(name="y_m", says="y", unit="m", low=-20.0, high=20.0, spoken_high=5.0),
    )
    example: str = "stop at 1 and 0.5"
    summary: str = "Drives to the point (x, y) of the map and stops there."
    target: Target = "place"
    already: str = Statement("command.already_on_its_way")
    icon: str = "stop_at"

    def preview(self, numbers: Mapping[str, float], pose: Pose, radius: float) -> CommandPreview:
        """Return the line to the goal."""
        return CommandPreview.straight(pose, (numbers["x_m"], numbers["y_m"]))

    def begin(self, command: Command, ctx: ControlContext) -> Action:
        """Plan the way. Raises Refused with a sentence when there is none."""
        numbers = command.numbers
        return Going((numbers["x_m"], numbers["y_m"]), ctx, numbers.get("heading_rad"), with_map=bool(command.place))


class Going:
    """The drive to a goal, until the robot stands there."""

    def __init__(
        self, goal: tuple[float, float], ctx: ControlContext, heading: float | None = None, *, with_map: bool = False
    ) -> None:
        """`goal` (x, y) [m], world; `heading` [rad] to look there, None: as it comes; `with_map`: it is a place and
        no numbers, and moves with the map. Raises Refused.
        """
        self._looks = heading is not None
        place = Pose(*goal, heading or 0.0)
        self._place = ctx.anchored(place) if with_map else as_it_is(place)
        self._whole = max(ctx.pose.distance_to(*goal), 1e-6)
        self._approach = GoalController(self._aim, ctx)

    @property
    def _aim(self) -> GoalAim:
        place = self._place()
        return GoalAim(x=place.x, y=place.y, heading=place.heading if self._looks else None)

    @property
    def _goal(self) -> Array:
        place = self._place()
        return np.array([place.x, place.y])

    def drive(self, ctx: ControlContext) -> Progress:
        """Take one frame."""
        step = self._approach.drive(ctx, self._aim)
        if step.state == "there":
            return Progress(finished="done", fraction=1.0, goal=self._goal)
        left = ctx.pose.distance_to(*self._goal)
        return Progress(
            twist=step.twist,
            finished="failed" if step.state == "stuck" else "",
            remark=step.words,
            fraction=min(1.0, max(0.0, 1 - left / self._whole)),
            path=step.path,
            goal=self._goal,
        )


STOP_AT = StopAt()

TO_PLACE = ("go to {name}", "go to the {name}", "stop at {name}", "stop at the {name}")
"""Words of STOP AT with the name of a place; the first is the canonical one."""
SAID_OF_PLACES = TO_PLACE[1]  # as most people say it


def command_to(place: NamedPlace) -> Command:
    """Build STOP AT for a named place, which may lie beyond `spoken_high`, or the start of a route of that name."""
    if place.route:
        words = START_ROUTE.words[0].format(name=place.name.lower())
        return Command(name=START_ROUTE.name, numbers={}, heard_as=words, place=place.name)
    numbers = {"x_m": place.x_m, "y_m": place.y_m}
    if place.heading_rad is not None:
        numbers["heading_rad"] = place.heading_rad
    return Command(
        name=STOP_AT.name, numbers=numbers, heard_as=TO_PLACE[0].format(name=place.name.lower()), place=place.name
    )
