"""The HTTP interface: one router per topic, every endpoint with its role."""

import time
from collections.abc import Callable, Sequence
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from console.access.guard import Access
from console.access.logins import Person
from console.access.open_sockets import OpenSockets
from console.api.typed_route import REF, Responses, TypedRoute
from console.calibration.service import CalibrationService
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.http.problems import Problem
from console.maps.service import MapService
from console.part import Part
from console.robot.supervisor import RobotSupervisor
from console.runtime import Runtime
from core.robots.requests import Ask
from core.sentences import Language, PageTexts, Statement

Angle = Annotated[float, Field(ge=-7, le=7)]
"""An angle of a request [rad], once around in either direction at most: what is more is degrees."""

SENTENCES = {
    400: "The request is malformed.",
    401: "Nobody is signed in, or the token is not valid.",
    403: "This person, page or host may not do this.",
    404: "There is no such thing.",
    408: "The body came too slowly.",
    409: "Not now: someone else drives, the robot is halted, or it is of another kind.",
    413: "The body is too large.",
    415: "The body is not declared as one of the types that are taken.",
    422: "Not understood, or out of bounds.",
    429: "Too many at once, or too many wrong tokens; try again later.",
    503: Statement("robot.unreached"),
    507: "The disk does not take what was to be saved; the sentence says why.",
}
PROBLEM = {
    "type": "object",
    "required": ["type", "title", "status", "detail"],
    "properties": {
        "type": {"type": "string"},
        "title": {"type": "string"},
        "status": {"type": "integer"},
        "detail": {"type": "string", "description": "A sentence to act on."},
        "code": {"type": "string", "description": "Of this sentence, where it has one: it keeps its meaning."},
        "values": {"type": "object", "description": "In the sentence, by their names."},
        "reason": {"type": "string", "description": "Of words: why they are no command."},
        "suggestions": {"type": "array", "items": {"type": "string"}, "description": "Of words: what is understood."},
        "errors": {
            "type": "array",
            "description": "Of a body: what is wrong with which field.",
            "items": {
                "type": "object",
                "required": ["field", "wrong"],
                "properties": {"field": {"type": "string"}, "wrong": {"type": "string"}},
            },
        },
    },
}
PROBLEMS: Responses = {
    status: {
        "description": sentence,
        "content": {"application/problem+json": {"schema": {"$ref": REF.format(name="Problem")}}},
    }
    for status, sentence in SENTENCES.items()
}


class RequestBody(BaseModel):
    """Base of all bodies: exact types, finite numbers, nothing that was not asked for."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)


def problems(*errors: int) -> Responses:
    """The refusals of these statuses, for the description."""
    return {status: PROBLEMS[status] for status in errors}


def sends_file(*types: str, errors: Sequence[int] = ()) -> dict[str, Any]:
    """The declarations of a route that answers with a file of one of these media types, or with a problem."""
    return {
        "response_class": Response,
        "responses": {200: {"content": {one: {} for one in types}}, **problems(*errors)},
    }


def router(topic: str, *errors: int) -> APIRouter:
    """A router whose endpoints may answer with a struct.

    `errors`: problems of its topic; those that follow from the role, the path and the body are described with them.
    """
    return APIRouter(prefix="/api", tags=[topic], responses=problems(*errors), route_class=TypedRoute)


async def runtime_of(request: Request) -> Runtime:
    """The runtime behind this request. A request is a sign of life of its person: it renews their lease."""
    runtime: Runtime = request.app.state.runtime
    if request.scope["person"] is not None:
        runtime.lease.active(request.scope["person"], time.monotonic())
    return runtime


async def room_of(runtime: Annotated[Runtime, Depends(runtime_of)]) -> Ask:
    """The way to a simulated robot's room. Raises Problem 404 for a robot that is not simulated."""
    if not runtime.robot.profile.simulated:
        raise Problem(404, "This robot is not simulated.")
    return runtime.ask


async def person_of(request: Request) -> Person:
    """The person who sent the request; the guard has checked it."""
    return request.scope["person"]


Behind = Annotated[Runtime, Depends(runtime_of)]
Who = Annotated[Person, Depends(person_of)]
SimulatedRoom = Annotated[Ask, Depends(room_of)]


def base(take: Callable[[Runtime], object]) -> Any:
    """The dependency of an endpoint on what every console is built on."""

    async def of(runtime: Behind) -> object:
        return take(runtime)

    return Depends(of)


def part(kind: type[Part]) -> Any:
    """The dependency of an endpoint on the part of this class."""
    return base(lambda runtime: runtime.parts[kind])


AccessRules = Annotated[Access, base(lambda runtime: runtime.access)]
CalibrationSessions = Annotated[CalibrationService, part(CalibrationService)]
HistoryInUse = Annotated[History, base(lambda runtime: runtime.history)]
Dispatcher = Annotated[CommandDispatcher, base(lambda runtime: runtime.dispatcher)]
OperatorLease = Annotated[Lease, base(lambda runtime: runtime.lease)]
NotificationsInUse = Annotated[Notifications, base(lambda runtime: runtime.notifications)]
RobotInUse = Annotated[RobotSupervisor, base(lambda runtime: runtime.robot)]
SavedMaps = Annotated[MapService, part(MapService)]
Sockets = Annotated[OpenSockets, base(lambda runtime: runtime.sockets)]


async def undisturbed(behind: Behind, who: Who) -> Person:
    """A person who may change how the robot sees, hears or moves. Raises Refused while another person drives."""
    behind.lease.check_not_anothers(who)
    return who


Operator = Annotated[Person, Depends(undisturbed)]  # or anybody who may, while nobody drives


async def texts_of(language: Annotated[Language, Query(description="of the words in the file")] = "en") -> PageTexts:
    return PageTexts(language)


Texts = Annotated[PageTexts, Depends(texts_of)]
