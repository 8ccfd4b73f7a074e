"""The navigation that a robot has of its own: its map and pose, and goals for it on request."""

from typing import Annotated, Literal

import msgspec
from pydantic import Field

from console.access.roles import needs
from console.api import Angle, RequestBody, Who, part, router
from console.control.own_navigation import OwnNavigationService
from console.http.problems import Problem
from core.geometry import Pose
from core.robots.requests import PlanarPose

own_navigation = router("own navigation", 404, 409, 503)
OwnNavigationInUse = Annotated[OwnNavigationService, part(OwnNavigationService)]

Number = Annotated[float, Field(ge=-10_000, le=10_000)]


class GoalRequest(RequestBody):
    """A goal for the robot's own navigation, on its own map or on Beckon's."""

    x_m: Number
    y_m: Number
    heading_rad: Angle = 0.0
    on: Literal["own map", "beckon"] = "own map"


class LayerRequest(RequestBody):
    """Request to draw the robot's own map in the scene, or not, for everybody."""

    shown: bool


class OwnMapSize(msgspec.Struct, frozen=True):
    """Size of the robot's own map."""

    width_m: float
    height_m: float


class OwnNavigationState(msgspec.Struct, frozen=True):
    """The robot's own navigation."""

    map: OwnMapSize | None
    sentence: str  # how its map lies to Beckon's, or why there is none
    shown: bool  # in the scene
    pose: PlanarPose | None  # on its own map; None: it does not say
    takes_goals: str  # the topic; "": it takes none
    goal: PlanarPose | None  # that it was given from here and that is under way, on its own map


@own_navigation.get("/robot/navigation")
@needs("viewer")
async def state(navigation: OwnNavigationInUse) -> OwnNavigationState:
    """The robot's own map, pose and goal. 404 for a robot without."""
    return state_of(navigation)


@own_navigation.post("/robot/navigation/goal", status_code=202)
@needs("operator")
async def go(asked: GoalRequest, navigation: OwnNavigationInUse, who: Who) -> OwnNavigationState:
    """Let the robot's own navigation drive there. Its software steers then, and Beckon's gate does not look ahead.

    It needs the lease, as any motion. STOP, another command, a hand, or a lease that lapses ends it: the robot's
    present pose is sent as its goal, and its lock is closed, where one is set. 409 where neither would work.
    """
    await navigation.go(Pose(asked.x_m, asked.y_m, asked.heading_rad), who, on_own_map=asked.on == "own map")
    return state_of(navigation)


@own_navigation.delete("/robot/navigation/goal")
@needs("viewer", reads_body=False)
async def cancel(navigation: OwnNavigationInUse) -> OwnNavigationState:
    """Let the robot's own navigation stand; anyone signed in."""
    await navigation.stop()
    return state_of(navigation)


@own_navigation.put("/robot/navigation/layer")
@needs("operator")
async def layer(asked: LayerRequest, navigation: OwnNavigationInUse) -> OwnNavigationState:
    """Draw the robot's own map in the scene, or not."""
    navigation.show(asked.shown)
    return state_of(navigation)


def state_of(navigation: OwnNavigationService) -> OwnNavigationState:
    """The state as the page has it. Raises Problem 404 for a robot without a navigation of its own."""
    if not navigation.there:
        raise Problem(404, "This robot has no navigation of its own that Beckon knows.")
    newest, found = navigation.newest, navigation.map
    return OwnNavigationState(
        map=None if found is None else OwnMapSize(found.width, found.height),
        sentence=navigation.sentence,
        shown=navigation.shown,
        pose=newest.pose if newest else None,
        takes_goals=newest.takes_goals if newest else "",
        goal=newest.goal if newest else None,
    )
