"""Settings of COME HERE and FOLLOW ME: how near to come, how long to look, how recent a voice must be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from core.setting import Meta, Section

Mode = Literal["person", "voice"]


@dataclass(frozen=True)
class PersonFollowingSettings(Section):
    """COME HERE and FOLLOW ME."""

    mode: Annotated[
        Mode, Meta(meaning="voice: without the camera, to where several bearings cross", common=True, live=True)
    ] = "person"
    stop_short: Annotated[
        float,
        Meta(
            "m",
            0.3,
            3,
            "distance between the person's middle and the robot's on arrival (Table 2)",
            common=True,
            live=True,
        ),
    ] = 0.5
    coming: Annotated[
        float, Meta("m/s", 0.05, 1, "speed on the way to a person, at most", common=True, live=True)
    ] = 0.2
    keep: Annotated[float, Meta("m", 0.6, 3, "distance kept from a followed person", common=True, live=True)] = 1.0
    following: Annotated[float, Meta("m/s", 0.05, 1, "speed after a person, at most", common=True, live=True)] = 0.27
    fresh: Annotated[
        float, Meta("s", 0.5, 60, "age of a voice, at most, when a command is typed after it", common=True, live=True)
    ] = 8.0
    spoken_fresh: Annotated[
        float,
        Meta("s", 0.5, 30, "the same when the voice gave the command itself, which was read and confirmed since"),
    ] = 5.0
    sure: Annotated[float, Meta("rad", 0.02, 0.6, "sd of a direction that is good enough")] = 0.26
    look_for: Annotated[float, Meta("s", 0.3, 30, "time for which a person is looked for")] = 2.0
    listen_for: Annotated[float, Meta("s", 1, 120, "time for another word where a voice must be located")] = 12.0
    sidestep: Annotated[float, Meta("m", 0.3, 3, "way to hear the voice from elsewhere")] = 0.9
