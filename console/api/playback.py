"""Steering a recording."""

from __future__ import annotations

from typing import Any, Literal

from console.access.roles import needs
from console.api import Behind, RequestBody, Who, router

playback = router("playback")


class PlaybackRequest(RequestBody):
    """`value`: the speed in times real time, or the place to seek from 0 to 1."""

    do: Literal["play", "pause", "speed", "seek"]
    value: float | None = None


@playback.post("/playback")
@needs("operator")
async def steer(asked: PlaybackRequest, behind: Behind, who: Who) -> dict[str, Any]:
    """Play, pause, change the speed, seek. A recording that was just opened waits at its first scan to be played."""
    await behind.player.steer(asked.do, asked.value, who)
    return {"done": asked.do}
