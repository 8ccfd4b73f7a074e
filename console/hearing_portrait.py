"""What is heard → what every viewer gets."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from console import wire_hearing as wire
from core.sensors import Camera
from core.snapshot import Hearing, VoiceDirection

FAR = 3.0  # [m] at which a voice is put into the picture: the camera sits beside the microphones
DIGITS = 4


@dataclass(frozen=True)
class Words:
    """How it is with the words of the room."""

    waking: bool = False  # they are not read yet: what reads them must be started first
    meant: str = ""  # the command that the newest may have been, as long as it is offered


NONE = Words()


def direction(heard: Hearing | None, camera: Camera | None) -> wire.VoiceHeard | None:
    """The voice that was heard last."""
    voices = heard.voices if heard is not None else ()
    return voice(voices[0], camera) if voices else None


def ears(
    heard: Hearing | None,
    camera: Camera | None,
    *,
    muted: bool = False,
    obeyed: bool = False,
    words: Words = NONE,
) -> wire.Ears | None:
    """What the robot's ears make of the sound; None without microphones."""
    if heard is None:
        return None
    level = None if heard.level_db is None else round(heard.level_db, 1)
    voices = [voice(one, camera) for one in heard.voices]
    return wire.Ears(heard.listening, muted, obeyed, words.waking, words.meant, heard.speaking, level, voices)


def voice(told: VoiceDirection, camera: Camera | None) -> wire.VoiceHeard:
    """Where somebody speaks."""
    x, y = told.heard_at.tolist()
    return wire.VoiceHeard(
        id=told.id,
        azimuth_rad=round(told.azimuth, DIGITS),
        azimuth_world_rad=round(told.azimuth_world, DIGITS),
        sd_rad=round(told.sd, DIGITS),
        sd_heard_rad=round(told.sd_heard, DIGITS),
        elevation_rad=None if told.elevation is None else round(told.elevation, DIGITS),
        ambiguity=told.ambiguity,
        strength=round(told.strength, DIGITS),
        age_s=round(told.age, 3),
        x_m=round(x, DIGITS),
        y_m=round(y, DIGITS),
        columns_px=None if camera is None else columns(told.azimuth, told.sd_heard, camera),
    )


def columns(azimuth: float, sd: float, camera: Camera) -> tuple[float, float, float] | None:
    """A direction [rad] in the robot's frame → columns [pixel] of its left bound, middle and right bound in the
    picture at the camera's height, two deviations apart; None where the camera does not look.
    """
    half = min(2 * sd, 0.6)
    angles = np.array([azimuth + half, azimuth, azimuth - half])
    height = float(camera.mounting.translation[2])
    places = np.column_stack((FAR * np.cos(angles), FAR * np.sin(angles), np.full(3, height)))
    seen = camera.mounting.inverse().apply(places)
    if seen[1, 2] <= 0.2 * math.hypot(*seen[1]):
        return None
    found = camera.model.project(seen)[:, 0]
    if not np.isfinite(found).all() or not 0 <= found[1] < camera.model.width:
        return None
    left, middle, right = np.round(np.sort(found), 1).tolist()
    return left, middle, right
