"""The HTTP interface: one router per topic, every endpoint with its role."""

from __future__ import annotations

import time
from typing import Annotated

from fastapi import APIRouter, Depends, Request
from pydantic import BaseModel, ConfigDict

from console.access.logins import Person
from console.api.typed_route import Responses, TypedRoute
from console.runtime import Runtime

SENTENCES = {
    400: "The request is malformed.",
    401: "Nobody is signed in, or the token is not valid.",
    403: "This person, page or host may not do this.",
    404: "There is no such thing.",
    405: "The path does not take this method.",
    408: "The body came too slowly.",
    409: "Not now: somebody else drives, the robot is halted, or it is of another kind.",
    413: "The body is too large.",
    415: "The body is not declared as JSON.",
    422: "Not understood, or out of bounds.",
    429: "Too many wrong tokens.",
    503: "The robot cannot be reached now.",
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
    },
}
PROBLEMS: Responses = {
    status: {"description": sentence, "content": {"application/problem+json": {"schema": PROBLEM}}}
    for status, sentence in SENTENCES.items()
}


class RequestBody(BaseModel):
    """Base of all bodies: exact types, finite numbers, nothing that was not asked for."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)


def router(topic: str) -> APIRouter:
    """A router whose endpoints may answer with a struct, and all answer problems alike."""
    return APIRouter(prefix="/api", tags=[topic], responses=PROBLEMS, route_class=TypedRoute)


async def runtime_of(request: Request) -> Runtime:
    """The runtime behind this request. A request is a sign of life of its person: it renews their lease."""
    runtime: Runtime = request.app.state.runtime
    if request.scope["person"] is not None:
        runtime.lease.active(request.scope["person"], time.monotonic())
    return runtime


async def person_of(request: Request) -> Person:
    """The person who sent the request; the guard has checked it."""
    return request.scope["person"]


Behind = Annotated[Runtime, Depends(runtime_of)]
Who = Annotated[Person, Depends(person_of)]


async def undisturbed(behind: Behind, who: Who) -> Person:
    """A person who may change how the robot sees, hears or moves. Raises Refused while another person drives."""
    behind.lease.check_not_anothers(who)
    return who


Driver = Annotated[Person, Depends(undisturbed)]  # or anybody who may, while nobody drives
