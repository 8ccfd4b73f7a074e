"""Voices: from where the robot stood when it heard them, a wedge two deviations wide, fading with age."""

import math

import numpy as np
from viser import SceneApi

from console.scene.drawing.lines import Lines, joined
from console.scene.drawing.palette import UNSURE, VOICE, mix
from core.message import Array
from core.robots import Profile
from core.snapshot import Snapshot, VoiceDirection

WEDGE_SDS = 2.0
WEDGE_LENGTH_M = 2.5
HEIGHT_M = 0.03
WEDGE_RAYS = 9
FADE_S = 6.0
MIN_WEDGE_HALF_RAD = 0.02  # half of a wedge that can still be seen


class VoiceWedges:
    """One node for all of them."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._strokes = Lines(scene, "/voices", VOICE, 2.2)
        self._drawn: tuple[tuple[int, float, int], ...] = ()

    def show(self, snapshot: Snapshot) -> None:
        """Draw them again when one was heard, or has faded by a tenth."""
        voices = snapshot.hearing.voices if snapshot.hearing is not None else ()
        key = tuple((one.id, one.stamp, int(10 * one.age / FADE_S)) for one in voices)
        if key == self._drawn:
            return
        self._drawn = key
        self._strokes.draw_each((wedge(one), mix(VOICE, UNSURE, max(0.0, 1 - one.age / FADE_S))) for one in voices)


def wedge(voice: VoiceDirection) -> Array:
    """A voice → segments (RAYS + 1, 2, 3) [m], world: its two sides and the arc between them."""
    half = min(max(WEDGE_SDS * voice.sd_heard, MIN_WEDGE_HALF_RAD), math.pi)
    angles = voice.azimuth_world + np.linspace(-half, half, WEDGE_RAYS)
    rim = voice.heard_at + WEDGE_LENGTH_M * np.column_stack((np.cos(angles), np.sin(angles)))
    return joined(np.vstack((voice.heard_at[None], rim, voice.heard_at[None])), HEIGHT_M)
