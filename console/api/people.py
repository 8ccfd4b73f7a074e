"""Enrollment of people, and the choice of the one person whom the robot comes to."""

from typing import Annotated, Literal

import msgspec
from fastapi import Path, Request, Response
from pydantic import Field

from console.access.roles import PICTURE, needs
from console.api import HistoryInUse, Operator, OperatorLease, RequestBody, Who, part, problems, router, sends_file
from console.http.problems import Problem
from console.people.enrollment import EnrollmentState
from console.people.service import EnrollmentService, PeopleState
from console.people.store import MAX_NAME_CHARACTERS
from console.people.worker import UploadedPicture

people = router("people", 409, 503, 507)
PeopleEnrolled = Annotated[EnrollmentService, part(EnrollmentService)]

Id = Annotated[str, Path(max_length=40)]
Number = Annotated[int, Path(ge=0, le=10**6)]


class ChoiceRequest(RequestBody):
    """To whom alone the robot comes when called; null: to anybody."""

    id: str | None = Field(max_length=40)


class NameRequest(RequestBody):
    """The name of the person."""

    name: str = Field(max_length=4 * MAX_NAME_CHARACTERS, examples=["Ann"])


class CaptureRequest(RequestBody):
    """The content of the robot's newest picture: the empty room, or a person in it."""

    what: Literal["background", "picture"]


class EnrollmentDemoRequest(RequestBody):
    """`on`: a simulated person steps before the camera; `inhabitant`: one who is in the room already, by their id."""

    on: bool
    inhabitant: str = Field(default="", max_length=40)


class NamedPerson(msgspec.Struct, frozen=True):
    """A person whom the robot knows."""

    id: str
    name: str
    pictures: int  # from how many it was learnt


@people.get("/people")
@needs("viewer")
async def known(people: PeopleEnrolled) -> PeopleState:
    """The known people, the `chosen` one, and the enrollment: what to do next, the result of each picture."""
    return people.shown


@people.post("/people", status_code=201)
@needs("operator")
async def begin(people: PeopleEnrolled, who: Who) -> EnrollmentState:
    """Begin an enrollment. Pictures are kept in memory until it is over, and never written."""
    return people.begin(who).shown


@people.put("/people/chosen", responses=problems(404))
@needs("operator")
async def choose(asked: ChoiceRequest, people: PeopleEnrolled, history: HistoryInUse, who: Operator) -> PeopleState:
    """Come to and follow only this person, or anybody; it outlasts a restart. Other commands are obeyed as before."""
    await people.choose(asked.id)
    history.add("people", who, words="anybody" if asked.id is None else "choose")
    return people.shown


@people.delete("/people/demo", responses=problems(404), status_code=204)
@needs("operator")
async def send_away(people: PeopleEnrolled) -> None:
    """Send the person who showed the gestures out of the simulated room."""
    await people.send_away()


@people.post("/people/{id}/background")
@needs("operator", body=PICTURE)
async def background(id: Id, request: Request, people: PeopleEnrolled) -> EnrollmentState:
    """A picture without anybody, as JPEG or PNG; restarts the pictures that were taken with another background."""
    enrollment = people.find(id)
    await people.background(enrollment, UploadedPicture(await request.body()))
    return enrollment.shown


@people.post("/people/{id}/pictures")
@needs("operator", body=PICTURE)
async def picture(id: Id, request: Request, people: PeopleEnrolled) -> EnrollmentState:
    """A picture of the whole person by the same camera; `newest` says whether it is good, or what to do better."""
    enrollment = people.find(id)
    await people.take(enrollment, UploadedPicture(await request.body()))
    return enrollment.shown


@people.post("/people/{id}/capture")
@needs("operator")
async def capture(id: Id, asked: CaptureRequest, people: PeopleEnrolled) -> EnrollmentState:
    """The same with the newest picture of the robot's own camera."""
    enrollment = people.find(id)
    await people.capture(enrollment, asked.what)
    return enrollment.shown


@people.get("/people/{id}/pictures/{number}.jpg", **sends_file("image/jpeg"))
@needs("operator")
async def shown(id: Id, number: Number, people: PeopleEnrolled) -> Response:
    """A picture of the enrolment under way; gone when that is over."""
    found = people.find(id).picture(number)
    if found is None:
        raise Problem(404, "There is no such picture any more.")
    return Response(found, media_type="image/jpeg", headers={"Cache-Control": "no-store"})


@people.post("/people/{id}/pictures/{number}/drop")
@needs("operator")
async def drop(id: Id, number: Number, people: PeopleEnrolled) -> EnrollmentState:
    """Leave a picture out."""
    enrollment = people.find(id)
    if not enrollment.drop(number):
        raise Problem(404, "There is no such picture any more.")
    return enrollment.shown


@people.post("/people/{id}/demo", status_code=202)
@needs("operator")
async def show_demo(id: Id, asked: EnrollmentDemoRequest, people: PeopleEnrolled) -> EnrollmentState:
    """In the simulated room a person steps before the camera and takes every gesture, or leaves."""
    enrollment = people.find(id)
    await people.show_demo(enrollment, on=asked.on, inhabitant=asked.inhabitant)
    return enrollment.shown


@people.post("/people/{id}/finish", status_code=201)
@needs("operator")
async def finish(id: Id, asked: NameRequest, people: PeopleEnrolled, history: HistoryInUse, who: Who) -> NamedPerson:
    """Save the enrolled person under a name; the pictures are gone."""
    card = await people.finish(people.find(id), asked.name)
    history.add("people", who, words="learn")
    return NamedPerson(card.id, card.name, card.pictures)


@people.post("/people/{id}/rename")
@needs("operator")
async def rename(id: Id, asked: NameRequest, people: PeopleEnrolled, history: HistoryInUse, who: Who) -> NamedPerson:
    """Rename a person."""
    card = await people.rename(id, asked.name)
    history.add("people", who, words="rename")
    return NamedPerson(card.id, card.name, card.pictures)


@people.delete("/people/{id}", status_code=204)
@needs("operator")
async def forget(id: Id, people: PeopleEnrolled, lease: OperatorLease, history: HistoryInUse, who: Who) -> None:
    """Forget a person for good, or cancel an enrollment. A chosen person is no longer chosen."""
    if people.enrollment is not None and people.enrollment.id == id:
        await people.cancel(people.enrollment)
    else:
        if id == people.shown.chosen:
            lease.check_not_anothers(who)
        await people.forget(id)
        history.add("people", who, words="forget")
