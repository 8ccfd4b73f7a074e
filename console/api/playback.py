"""Steering a recording."""

from __future__ import annotations

from typing import Annotated

import msgspec

from console.access.roles import needs
from console.api import RequestBody, Who, part, router
from console.control.playback import PlaybackAction, PlaybackController

playback = router("playback", 409, 503)
Playback = Annotated[PlaybackController, part(PlaybackController)]


class PlaybackRequest(RequestBody):
    """`value`: the speed in times real time, or the place to seek from 0 to 1."""

    do: PlaybackAction
    value: float | None = None


class SteeredPlayback(msgspec.Struct, frozen=True):
    """The action that was done."""

    done: PlaybackAction


@playback.post("/playback")
@needs("operator")
async def steer(asked: PlaybackRequest, player: Playback, who: Who) -> SteeredPlayback:
    """Play, pause, change the speed, seek. A recording that was just opened waits at its first scan to be played."""
    await player.steer(asked.do, asked.value, who)
    return SteeredPlayback(asked.do)
