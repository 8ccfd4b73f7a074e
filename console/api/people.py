"""Teaching the robot who somebody is, and to whom alone it comes."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import Path, Request, Response
from pydantic import Field

from console.api import Behind, Driver, Who, Wish, router
from console.people.album import LONGEST
from console.problems import Problem
from console.roles import PICTURE, needs

people = router("people")

PICTURES: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {kind: {"schema": {"type": "string", "format": "binary"}} for kind in ("image/jpeg", "image/png")},
    }
}

Id = Annotated[str, Path(max_length=40)]
Number = Annotated[int, Path(ge=0, le=10**6)]


class ChoiceWish(Wish):
    """To whom alone the robot comes when called; null: to anybody."""

    id: str | None = Field(max_length=40)


class NameWish(Wish):
    """What the person is called."""

    name: str = Field(max_length=4 * LONGEST, examples=["Ann"])


class CaptureWish(Wish):
    """What the robot's newest picture is: the empty room, or somebody in it."""

    what: Literal["background", "picture"]


class ShowWish(Wish):
    """Whether a simulated person steps before the camera."""

    on: bool


@people.get("/people")
@needs("viewer")
async def known(behind: Behind) -> dict[str, Any]:
    """Who is known, who is `chosen`, and the enrolment under way: what to do next, and what each picture gave."""
    return behind.people.told()


@people.post("/people", status_code=201)
@needs("operator")
async def begin(behind: Behind, who: Who) -> dict[str, Any]:
    """Begin to teach the robot somebody. Pictures are kept in memory until it is over, and never written."""
    return behind.people.begin(who).told()


@people.put("/people/chosen")
@needs("operator")
async def choose(asked: ChoiceWish, behind: Behind, who: Driver) -> dict[str, Any]:
    """Come to and follow only this person, or anybody; it outlasts a restart. Other commands are obeyed as before."""
    await behind.people.choose(asked.id)
    behind.history.add("people", who, words="anybody" if asked.id is None else "choose")
    return behind.people.told()


@people.delete("/people/assistant", status_code=204)
@needs("operator")
async def send_away(behind: Behind) -> Response:
    """Whoever showed the gestures in the simulated room leaves it."""
    await behind.people.send_away()
    return Response(status_code=204)


@people.post("/people/{id}/background", openapi_extra=PICTURES)
@needs("operator", body=PICTURE)
async def background(id: Id, request: Request, behind: Behind) -> dict[str, Any]:
    """A picture without anybody, as JPEG or PNG; begins anew what was taken beside another."""
    lesson = behind.people.find(id)
    await behind.people.background(lesson, {"content": await request.body()})
    return lesson.told()


@people.post("/people/{id}/pictures", openapi_extra=PICTURES)
@needs("operator", body=PICTURE)
async def picture(id: Id, request: Request, behind: Behind) -> dict[str, Any]:
    """A picture of the whole person by the same camera; `newest` says whether it is good, or what to do better."""
    lesson = behind.people.find(id)
    await behind.people.take(lesson, {"content": await request.body()})
    return lesson.told()


@people.post("/people/{id}/capture")
@needs("operator")
async def capture(id: Id, asked: CaptureWish, behind: Behind) -> dict[str, Any]:
    """The same with the newest picture of the robot's own camera."""
    lesson = behind.people.find(id)
    await behind.people.capture(lesson, asked.what)
    return lesson.told()


@people.get(
    "/people/{id}/pictures/{number}.jpg", response_class=Response, responses={200: {"content": {"image/jpeg": {}}}}
)
@needs("operator")
async def shown(id: Id, number: Number, behind: Behind) -> Response:
    """A picture of the enrolment under way; gone when that is over."""
    found = behind.people.find(id).picture(number)
    if found is None:
        raise Problem(404, "There is no such picture any more.")
    return Response(found, media_type="image/jpeg", headers={"Cache-Control": "no-store"})


@people.post("/people/{id}/pictures/{number}/drop")
@needs("operator")
async def drop(id: Id, number: Number, behind: Behind) -> dict[str, Any]:
    """Leave a picture out."""
    lesson = behind.people.find(id)
    if not lesson.drop(number):
        raise Problem(404, "There is no such picture any more.")
    return lesson.told()


@people.post("/people/{id}/show-me", status_code=202)
@needs("operator")
async def show_me(id: Id, asked: ShowWish, behind: Behind) -> dict[str, Any]:
    """In the simulated room a person steps before the camera and takes every gesture, or leaves."""
    lesson = behind.people.find(id)
    await behind.people.show_me(lesson, on=asked.on)
    return lesson.told()


@people.post("/people/{id}/finish", status_code=201)
@needs("operator")
async def finish(id: Id, asked: NameWish, behind: Behind, who: Who) -> dict[str, Any]:
    """Keep what was learnt under a name; the pictures are gone."""
    lesson = behind.people.find(id)
    card = await behind.people.finish(lesson, asked.name)
    behind.history.add("people", who, words="learn")
    return {"id": card.id, "name": card.name, "pictures": card.pictures}


@people.post("/people/{id}/rename")
@needs("operator")
async def rename(id: Id, asked: NameWish, behind: Behind, who: Who) -> dict[str, Any]:
    """Call somebody otherwise."""
    card = await behind.people.rename(id, asked.name)
    behind.history.add("people", who, words="rename")
    return {"id": card.id, "name": card.name, "pictures": card.pictures}


@people.delete("/people/{id}", status_code=204)
@needs("operator")
async def forget(id: Id, behind: Behind, who: Who) -> Response:
    """Forget somebody for good, or cancel an enrolment. Who was chosen is chosen no more."""
    if behind.people.lesson is not None and behind.people.lesson.id == id:
        await behind.people.cancel(behind.people.lesson)
    else:
        if id == behind.people.told()["chosen"]:
            behind.lease.check_not_anothers(who)
        await behind.people.forget(id)
        behind.history.add("people", who, words="forget")
    return Response(status_code=204)
