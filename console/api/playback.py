"""Steering a recording."""

from typing import Annotated, Literal

import msgspec
from fastapi import Response
from pydantic import Field

from console.access.roles import needs
from console.api import RequestBody, Who, part, problems, router, sends_file
from console.api.recordings import FILM_MEDIA_TYPES, MAX_PART_S, PartBegin, PartEnd, Recordings, filmed
from console.control.playback import PlaybackController
from console.http.problems import Problem
from console.messages.inbound import PlaybackAction, PlaybackMessage, PlaybackWay
from console.recording.work import FinishedRecording
from core.pipelines.drive_film import FilmForm
from core.robots.requests import PlaybackMark

playback = router("playback", 409, 503)
Playback = Annotated[PlaybackController, part(PlaybackController)]


class PlaybackRequest(RequestBody):
    """`t_s` belongs to seek, `speed` [times real time] to speed, `way` and `compare` to way, `from_s` and `to_s` to
    export; times are in seconds from the start.
    """

    action: PlaybackAction | Literal["export"]
    t_s: float | None = Field(None, examples=[12.5])
    speed: float | None = Field(None, examples=[2.0])
    way: PlaybackWay | None = None
    compare: bool = False
    from_s: float | None = Field(None, ge=0, examples=[12.0])
    to_s: float | None = Field(None, gt=0, le=MAX_PART_S, examples=[34.0])


class SteeredPlayback(msgspec.Struct, frozen=True):
    """The action that was done, and the recording that an export has made."""

    done: PlaybackAction | Literal["export"]
    recording: FinishedRecording | None = None


class PlaybackDescription(msgspec.Struct, frozen=True):
    """How a recording plays, and what happened in it."""

    t_s: float  # from its start
    duration_s: float
    playing: bool
    speed: float  # times real time
    way: str  # that is shown: recorded, computed
    compare: bool  # the other one is drawn over it
    ways: tuple[str, ...]  # that it has
    computed_since_s: float | None  # where computing began
    marks: tuple[PlaybackMark, ...]


@playback.get("/playback", responses=problems(404))
@needs("viewer")
async def state(player: Playback) -> PlaybackDescription:
    """Return where a recording is, and its marks: commands, speech, contacts, trips, gaps. 404 where none plays."""
    now, marks = await player.read()
    return msgspec.convert(
        {**msgspec.structs.asdict(now), "t_s": now.position_s, "marks": marks}, PlaybackDescription
    )


@playback.post("/playback")
@needs("operator")
async def steer(asked: PlaybackRequest, player: Playback, store: Recordings, who: Who) -> SteeredPlayback:
    """Play, pause, change the speed, seek, show another way, or save a part as a recording of its own.

    A recording waits at its first frame to be played.
    """
    if asked.action == "export":
        path = player.file(409)
        if asked.from_s is None or asked.to_s is None:
            raise Problem(422, "To export needs two times: from_s and to_s.")
        return SteeredPlayback("export", await store.cut(path, asked.from_s, asked.to_s, who))
    await player.steer(PlaybackMessage(asked.action, 0, asked.t_s, asked.speed, asked.way, asked.compare), who)
    return SteeredPlayback(asked.action)


@playback.get("/playback/film.{form}", **sends_file(*FILM_MEDIA_TYPES, errors=[404]))
@needs("viewer")
async def film(form: FilmForm, player: Playback, store: Recordings, from_s: PartBegin, to_s: PartEnd) -> Response:
    """A film of a part of the recording that plays: map and camera. 404 where none of Beckon's own plays."""
    return await filmed(store, player.file(404), form, from_s, to_s)
