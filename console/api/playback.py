"""Steering a recording."""

from __future__ import annotations

from typing import Annotated

import msgspec
from pydantic import Field

from console.access.roles import needs
from console.api import RequestBody, Who, part, problems, router
from console.control.playback import PlaybackAction, PlaybackController, PlaybackOrder, PlaybackWay
from core.robots.requests import PlaybackMark

playback = router("playback", 409, 503)
Playback = Annotated[PlaybackController, part(PlaybackController)]


class PlaybackRequest(RequestBody):
    """`t_s` [s] from the start belongs to seek, `speed` [times real time] to speed, `way` and `compare` to way."""

    action: PlaybackAction
    t_s: float | None = Field(None, examples=[12.5])
    speed: float | None = Field(None, examples=[2.0])
    way: PlaybackWay | None = None
    compare: bool = False


class SteeredPlayback(msgspec.Struct, frozen=True):
    """The action that was done."""

    done: PlaybackAction


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
    return PlaybackDescription(
        t_s=now.position_s,
        duration_s=now.duration_s,
        playing=now.playing,
        speed=now.speed,
        way=now.way,
        compare=now.compare,
        ways=now.ways,
        computed_since_s=now.computed_since_s,
        marks=marks,
    )


@playback.post("/playback")
@needs("operator")
async def steer(asked: PlaybackRequest, player: Playback, who: Who) -> SteeredPlayback:
    """Play, pause, change the speed, seek, show another way. A recording waits at its first frame to be played."""
    await player.steer(PlaybackOrder(asked.action, asked.t_s, asked.speed, asked.way, asked.compare), who)
    return SteeredPlayback(asked.action)
