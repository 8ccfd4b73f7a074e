"""Hearing as it goes over the sockets."""

from __future__ import annotations

import msgspec

Struct = msgspec.Struct


class VoiceHeard(Struct):
    """Where somebody speaks, as heard from the robot."""

    id: int
    azimuth_rad: float  # in the robot's frame, as the robot stands now
    azimuth_world_rad: float
    sd_rad: float  # of both now: who spoke may have walked on since
    sd_heard_rad: float  # of both when it was heard last
    elevation_rad: float | None  # above the microphones
    ambiguity: str  # what a flat array cannot know, in words
    strength: float  # 0..1
    age_s: float
    x_m: float  # where the robot was when it heard it, in the world frame
    y_m: float
    columns_px: (
        tuple[float, float, float] | None
    )  # in the picture: left bound, middle, right bound; null: not in view


class Ears(Struct):
    """What the robot's ears make of the sound."""

    listening: bool
    muted: bool  # the robot itself speaks, so that nothing is listened to
    obeyed: bool  # what voices in the room say is done: the driver has taken their words on
    waking: bool  # words are not read yet: what reads them is started first
    meant: str  # the command that the newest words may have been, heard with a doubt and refused; "": none
    speaking: bool
    level_dbfs: float | None
    voices: list[VoiceHeard]  # most recently heard first
