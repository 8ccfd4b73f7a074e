"""Recordings: begin and end one, keep what just happened, and the files to take away."""

import asyncio
from pathlib import Path as FilePath
from typing import Annotated, Literal

import msgspec
from fastapi import Path, Query, Request, Response
from fastapi.responses import FileResponse
from pydantic import Field

from console.access.roles import ANY_FILE, BodyLimit, needs
from console.api import RequestBody, Who, part, router, sends_file
from console.http.downloads import named
from console.recording.recorder import KEPT_BY, RecorderService, RecordingState
from console.recording.store import MAX_NAME_LETTERS, MAX_NOTE_LETTERS, RecordingStore
from console.recording.work import FinishedRecording
from core.pipelines.drive_film import FilmForm

recordings = router("recordings", 409, 503, 507)

Recorder = Annotated[RecorderService, part(RecorderService)]
Recordings = Annotated[RecordingStore, part(RecordingStore)]
Name = Annotated[str, Path(min_length=1, max_length=4 * MAX_NAME_LETTERS)]
SampleName = Literal["room", "floor", "people"]
MAX_PART_S = 100_000.0
RECORDING_LIMIT = BodyLimit((ANY_FILE,), 100_000_000, 6.0)
PartBegin = Annotated[float, Query(ge=0, description="[s] after the start")]
PartEnd = Annotated[float, Query(gt=0, le=MAX_PART_S, description="[s] after the start")]
FILM_MEDIA_TYPES = ("image/webp", "image/gif")


class StartRecordingRequest(RequestBody):
    """A name of its own, else the date; and a note."""

    name: str | None = Field(None, max_length=4 * MAX_NAME_LETTERS, examples=["hall at night"])
    note: str = Field("", max_length=MAX_NOTE_LETTERS)


class KeepRequest(RequestBody):
    """The length of what is kept [s], and a note."""

    seconds: float = Field(120.0, ge=1, le=600)
    note: str = Field("", max_length=MAX_NOTE_LETTERS)


class ChangeRecordingRequest(RequestBody):
    """Another note, or another name."""

    note: str | None = Field(None, max_length=4 * MAX_NOTE_LETTERS)
    name: str | None = Field(None, max_length=4 * MAX_NAME_LETTERS)


class PartRequest(RequestBody):
    """From when to when [s] after the start."""

    from_s: float = Field(ge=0, examples=[12.0])
    to_s: float = Field(gt=0, le=MAX_PART_S, examples=[34.0])


class StartedRecording(msgspec.Struct, frozen=True):
    """A recording that has begun."""

    name: str
    path: str
    started_s: float  # Unix time


class TakenRecording(msgspec.Struct, frozen=True):
    """A recording that was kept, and what opens it."""

    url: str


class RecordingList(msgspec.Struct, frozen=True):
    """The recorder now, and every recording, the newest first."""

    recorder: RecordingState
    recordings: list[FinishedRecording]


@recordings.get("/recordings")
@needs("viewer")
async def all_of_them(recorder: Recorder, store: Recordings) -> RecordingList:
    """Return the recorder's state and every recording."""
    return RecordingList(recorder.state, await store.all(recorder.running, recorder.kept))


@recordings.get("/recorder")
@needs("viewer")
async def state(recorder: Recorder) -> RecordingState:
    """Return the recorder's state alone."""
    return recorder.state


@recordings.post("/recordings/start", status_code=201)
@needs("operator")
async def start(asked: StartRecordingRequest, recorder: Recorder, who: Who) -> StartedRecording:
    """Record from now on. 409 while a recording runs, 507 where the disk takes none."""
    begun = await recorder.start(asked.name, asked.note, who)
    return StartedRecording(begun.name or "", begun.path, begun.started_s)


@recordings.post("/recordings/stop")
@needs("operator")
async def stop(recorder: Recorder, who: Who) -> FinishedRecording:
    """End the recording and return the whole file's facts. 409 while none runs."""
    return await recorder.stop(who)


@recordings.post("/recordings/keep", status_code=201)
@needs("viewer")
async def keep(asked: KeepRequest, recorder: Recorder, store: Recordings, who: Who) -> FinishedRecording:
    """Save what just happened: the last seconds, which the recorder holds in memory."""
    kept = await recorder.keep(asked.seconds, KEPT_BY(person=who.name), who)
    if asked.note:
        await store.rewrite(kept.name, asked.note, None)
    return msgspec.structs.replace(kept, note=asked.note)


@recordings.get("/recordings/{name}", **sends_file(ANY_FILE))
@needs("viewer")
async def download(name: Name, store: Recordings) -> Response:
    """The MCAP."""
    path = await asyncio.to_thread(store.file, name)
    return FileResponse(path, media_type=ANY_FILE, headers=named(path.name))


@recordings.get("/recordings/{name}/picture", **sends_file("image/jpeg"))
@needs("viewer")
async def picture(name: Name, store: Recordings) -> Response:
    """A small picture out of its middle. 404 where it has none."""
    return Response(await store.picture(name), media_type="image/jpeg")


@recordings.post("/recordings/{name}/export", status_code=201)
@needs("operator")
async def export(name: Name, asked: PartRequest, store: Recordings, who: Who) -> FinishedRecording:
    """Save a part as a recording of its own, with the map and the mountings that held at its beginning."""
    return await store.cut(await asyncio.to_thread(store.file, name), asked.from_s, asked.to_s, who)


@recordings.get("/recordings/{name}/film.{form}", **sends_file(*FILM_MEDIA_TYPES))
@needs("viewer")
async def film(name: Name, form: FilmForm, store: Recordings, from_s: PartBegin, to_s: PartEnd) -> Response:
    """A film of a part: the map as it was shown, and what the camera saw."""
    return await filmed(store, await asyncio.to_thread(store.file, name), form, from_s, to_s)


async def filmed(store: RecordingStore, path: FilePath, form: FilmForm, from_s: float, to_s: float) -> Response:
    """A film of a part of this file, to take away. Raises BadInput, Unavailable."""
    content = await store.film(path, from_s, to_s, form)
    name = f"{path.stem} {from_s:.0f}-{to_s:.0f} s.{form}"
    return Response(content, media_type=f"image/{form}", headers=named(name))


@recordings.post("/recordings/samples/{sample}", status_code=201)
@needs("operator")
async def make_sample(sample: SampleName, store: Recordings, who: Who) -> TakenRecording:
    """Record a short drive of a simulated robot, to look at a recording without a robot of one's own.

    It takes up to a minute; one that was made before is there at once.
    """
    return TakenRecording(f"log:{await store.sample(sample, who)}")


@recordings.put("/recordings/{name}", status_code=201)
@needs("operator", body=RECORDING_LIMIT)
async def take_in(name: Name, request: Request, store: Recordings, who: Who) -> TakenRecording:
    """Keep a recording that was made elsewhere, any form that `log:` reads; the name with its ending.

    409 where there is one of this name, 507 where the disk takes none.
    """
    return TakenRecording(f"log:{await store.take_in(name, await request.body(), who)}")


@recordings.patch("/recordings/{name}", status_code=204)
@needs("operator")
async def change(name: Name, asked: ChangeRecordingRequest, store: Recordings) -> None:
    """Change its note or its name."""
    await store.rewrite(name, asked.note, asked.name)


@recordings.delete("/recordings/{name}", status_code=204)
@needs("operator")
async def delete(name: Name, store: Recordings, who: Who) -> None:
    """Delete it for good."""
    await store.delete(name, who)
