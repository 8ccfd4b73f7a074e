"""Settings of COME HERE and FOLLOW ME: how near to come, how long to look, how recent a voice must be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from core.errors import BadInput

Mode = Literal["person", "voice"]
MODES: tuple[Mode, ...] = ("person", "voice")


@dataclass(frozen=True)
class PersonFollowingSettings:
    """COME HERE and FOLLOW ME."""

    mode: Mode = "person"  # "voice": without the camera, to where several bearings cross
    stop_short: float = 0.5  # [m] from the person's middle to the robot's (Table 2)
    coming: float = 0.2  # [m/s] at most, on the way to a person
    keep: float = 1.0  # [m] that is kept from a followed person
    following: float = 0.27  # [m/s] at most, after a person
    fresh: float = 8.0  # [s] that a voice may be old when a command is typed after it
    spoken_fresh: float = 5.0  # [s] the same when the voice gave the command itself: it was read and confirmed since
    sure: float = 0.26  # [rad] sd of a direction that is good enough
    look_for: float = 2.0  # [s] that a person is looked for
    listen_for: float = 12.0  # [s] that another word is waited for where a voice must be located
    sidestep: float = 0.9  # [m] to hear the voice from elsewhere

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise BadInput(f"mode must be one of {', '.join(MODES)}.")
        for name, (low, high) in BOUNDS.items():
            if not low <= getattr(self, name) <= high:
                raise BadInput(f"{name} must lie between {low:g} and {high:g}.")


BOUNDS = {
    "stop_short": (0.3, 3.0),
    "keep": (0.6, 3.0),
    "coming": (0.05, 1.0),
    "following": (0.05, 1.0),
    "fresh": (0.5, 60.0),
    "spoken_fresh": (0.5, 30.0),
    "sure": (0.02, 0.6),
    "look_for": (0.3, 30.0),
    "listen_for": (1.0, 120.0),
    "sidestep": (0.3, 3.0),
}
