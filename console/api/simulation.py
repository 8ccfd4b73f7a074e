"""The simulated robot only: where it really is, and things and people put in its way."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from console.api import Behind, Who, Wish, router
from console.problems import Problem
from console.roles import needs
from console.runtime import Runtime

simulation = router("simulation")


class Placing(Wish):
    """What stands where, in the world frame. `robot` carries the robot itself; its wheels do not notice."""

    what: Literal["person", "box", "robot"]
    x_m: float = Field(ge=-1000, le=1000)
    y_m: float = Field(ge=-1000, le=1000)
    heading_rad: float = Field(default=0.0, ge=-100, le=100)
    id: str | None = Field(default=None, max_length=40)
    size_m: float | None = Field(default=None, ge=0, le=10)


Number = Annotated[float, Field(ge=-1000, le=1000)]  # [m] or a part of a rotation


class BoardInCamera(Wish):
    """A board's pose in the camera's frame, P_camera = rotation · P_board + translation, as the advice has it."""

    rotation: list[list[Number]] = Field(min_length=3, max_length=3)
    translation_m: list[Number] = Field(min_length=3, max_length=3)


class BoardPlacing(Wish):
    """A chessboard that is held up: its middle and axes in the world frame, or its pose in the camera's frame.

    Where there is one already, it is moved there in `seconds`. With `holder`, a person stands behind it.
    """

    what: Literal["board"]
    columns: int = Field(default=9, ge=3, le=40)
    rows: int = Field(default=6, ge=3, le=40)
    square_m: float = Field(default=0.03, ge=0.001, le=1)
    panel_m: list[Number] | None = Field(default=None, min_length=2, max_length=2)
    x_m: Number | None = None
    y_m: Number | None = None
    z_m: Number | None = None
    rotation: list[list[Number]] | None = Field(default=None, min_length=3, max_length=3)
    in_camera: BoardInCamera | None = None
    seconds: float = Field(default=0.0, ge=0, le=10)
    holder: bool = False


class Removing(Wish):
    """Which of the placed things goes."""

    id: str = Field(max_length=40)


@simulation.get("/sim/truth")
@needs("viewer")
async def truth(behind: Behind) -> dict[str, Any]:
    """The true pose in the world frame. For scoring; no estimator sees it."""
    return await simulated(behind).ask({"do": "truth"})


@simulation.get("/sim/plan")
@needs("viewer")
async def plan(behind: Behind) -> dict[str, Any]:
    """The true floor plan: walls as segments, and the things in the room."""
    return await simulated(behind).ask({"do": "plan"})


@simulation.post("/sim/place", status_code=201)
@needs("operator")
async def place(
    asked: Annotated[Placing | BoardPlacing, Field(discriminator="what")], behind: Behind, who: Who
) -> dict[str, Any]:
    """Put a person or a box into the room, hold up a chessboard, or carry the robot."""
    wanted = {key: value for key, value in asked.model_dump().items() if value is not None}
    answer = await simulated(behind).ask({"do": "place", **wanted})
    behind.history.add("place", who, words=asked.what)
    return answer


@simulation.post("/sim/remove")
@needs("operator")
async def remove(asked: Removing, behind: Behind, who: Who) -> dict[str, Any]:
    """Take it away again."""
    answer = await simulated(behind).ask({"do": "remove", "id": asked.id})
    behind.history.add("place", who, words="remove")
    return answer


def simulated(behind: Runtime) -> Runtime:
    """Raises Problem 404 for a robot that is not simulated."""
    if behind.robot.profile.kind != "SIM":
        raise Problem(404, "This robot is not simulated.")
    return behind
