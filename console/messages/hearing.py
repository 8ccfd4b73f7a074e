"""Hearing as it goes over the sockets."""

import math
from dataclasses import dataclass

import msgspec
import numpy as np

from console.messages import filled
from core.sensors import Camera
from core.snapshot import Hearing, VoiceDirection

Struct = msgspec.Struct


class VoiceHeard(Struct):
    """A voice and its direction, as heard from the robot."""

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


class HearingState(Struct):
    """The state of the robot's hearing."""

    listening: bool
    muted: bool  # the robot itself speaks, so that nothing is listened to
    voice_control: bool  # what voices in the room say is done: the driver has taken their words on
    starting: bool  # words are not read yet: what reads them is started first
    suggested_commands: list[str]  # that the newest words most likely were, which were rejected
    speaking: bool
    level_dbfs: float | None
    voices: list[VoiceHeard]  # most recently heard first


VOICE_DISTANCE_M = 3.0  # at which a voice is put into the picture: the camera sits next to the microphones
DECIMAL_DIGITS = 4


@dataclass(frozen=True)
class TranscriptionStatus:
    starting: bool = False  # they are not read yet: what reads them must be started first
    suggested_commands: tuple[str, ...] = ()  # that the newest may have been, as long as they are offered


NONE = TranscriptionStatus()


def direction(heard: Hearing | None, camera: Camera | None) -> VoiceHeard | None:
    """The voice that was heard last."""
    voices = heard.voices if heard is not None else ()
    return voice(voices[0], camera) if voices else None


def ears(
    heard: Hearing | None,
    camera: Camera | None,
    *,
    muted: bool = False,
    voice_control: bool = False,
    words: TranscriptionStatus = NONE,
) -> HearingState | None:
    """The state of the robot's hearing; None without microphones."""
    if heard is None:
        return None
    level = None if heard.level_db is None else round(heard.level_db, 1)
    voices = [voice(one, camera) for one in heard.voices]
    offered = list(words.suggested_commands)
    return HearingState(heard.listening, muted, voice_control, words.starting, offered, heard.speaking, level, voices)


def voice(direction: VoiceDirection, camera: Camera | None) -> VoiceHeard:
    """A voice → its row."""
    x, y = direction.heard_at.tolist()
    seen = None if camera is None else columns(direction.azimuth, direction.sd_heard, camera)
    at = {"x_m": round(x, DECIMAL_DIGITS), "y_m": round(y, DECIMAL_DIGITS)}
    return filled(VoiceHeard, direction, DECIMAL_DIGITS, columns_px=seen, **at)


def columns(azimuth: float, sd: float, camera: Camera) -> tuple[float, float, float] | None:
    """A direction [rad] in the robot's frame → columns [pixel] of its left bound, middle and right bound in the
    picture at the camera's height, two deviations apart; None where the camera does not look.
    """
    half = min(2 * sd, 0.6)
    angles = np.array([azimuth + half, azimuth, azimuth - half])
    height = float(camera.mounting.translation[2])
    places = np.column_stack(
        (VOICE_DISTANCE_M * np.cos(angles), VOICE_DISTANCE_M * np.sin(angles), np.full(3, height))
    )
    seen = camera.mounting.inverse().apply(places)
    if seen[1, 2] <= 0.2 * math.hypot(*seen[1]):
        return None
    found = camera.model.project(seen)[:, 0]
    if not np.isfinite(found).all() or not 0 <= found[1] < camera.model.width:
        return None
    left, middle, right = np.round(np.sort(found), 1).tolist()
    return left, middle, right
