"""Settings of COME HERE and FOLLOW ME: how near to come, how long to look, how recent a voice must be."""

from dataclasses import dataclass
from typing import Annotated, Literal

from core.setting import Meta, Section

Mode = Literal["person", "voice"]


@dataclass(frozen=True)
class PersonFollowingSettings(Section):
    """COME HERE and FOLLOW ME.

    Watch:
        mode: who is approached, and how often the robot asks for another word
        stop_short: distance on arrival
        coming: speed on the way to a person
        keep: distance behind a walking person
        following: distance behind a fast person; raise it where it grows
        fresh: commands refused for want of a voice (then raise it)
        look_for: persons not found at the voice (then raise it)
        listen_for: time until the robot gives up
    """

    # [s] the same when the voice gave the command itself, which was read and confirmed since
    spoken_fresh: float = 5.0
    sure: float = 0.26  # [rad] sd of a direction that is good enough
    sidestep: float = 0.9  # [m] way to hear the voice from elsewhere
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
    look_for: Annotated[float, Meta("s", 0.3, 30, "time for which a person is looked for")] = 2.0
    listen_for: Annotated[float, Meta("s", 1, 120, "time for another word where a voice must be located")] = 12.0
