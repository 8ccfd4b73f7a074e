"""The tracked person and the voices that were heard."""

import math

import numpy as np
from viser import SceneApi

from console.scene.drawing.lines import CIRCLE, CROSS, Lines, ellipses, joined, lifted
from console.scene.drawing.palette import DOUBT, SCAN, UNSURE, VOICE, Colour, faded
from core.geometry import Ray
from core.message import Array
from core.perception.people.tracked_person import TrackedPerson
from core.robots import Profile
from core.snapshot import Snapshot, VoiceDirection

RING_RADIUS_M = 0.22
CROSS_ARM_M = 0.10
HEIGHT_M = 0.035
ELLIPSE_SDS = 2.0
WEDGE_SDS = 2.0
WEDGE_LENGTH_M = 2.5
VOICE_HEIGHT_M = 0.03
WEDGE_RAYS = 9
FADE_S = 6.0
MIN_WEDGE_HALF_RAD = 0.02  # half of a wedge that can still be seen


class People:
    """A ring and an ellipse where all senses put the person, a cross by the laser, and the bearings; in one node."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._strokes = Lines(scene, "/person", DOUBT, 2.6)
        self._drawn: tuple[float, ...] = ()

    def show(self, snapshot: Snapshot) -> None:
        """Draw them again when something of them changed by a centimetre."""
        person = snapshot.person
        key = () if person is None else (*np.round(person.position, 2).tolist(), float(person.state == "seen"))
        if key == self._drawn:
            return
        self._drawn = key
        self._strokes.draw_each([] if person is None else strokes_of(person))


def strokes_of(person: TrackedPerson) -> list[tuple[Array, Colour]]:
    """A person → pieces of segments (N, 2, 3) [m], world, each in one colour."""
    own = DOUBT if person.state == "seen" else UNSURE
    ring = person.position + RING_RADIUS_M * np.column_stack((np.cos(CIRCLE), np.sin(CIRCLE)))
    strokes = [(joined(ring, HEIGHT_M), own)]
    strokes.append((ellipses(person.position[None], person.covariance[None], ELLIPSE_SDS, HEIGHT_M), own))
    if person.laser is not None:
        strokes.append((lifted(person.laser + CROSS_ARM_M * CROSS, HEIGHT_M), SCAN))
    for ray, colour in ((person.camera, own), (person.sound, VOICE)):
        if ray is not None:
            strokes.append((joined(_line(ray, person.position), HEIGHT_M), colour))
    return strokes


def _line(ray: Ray, towards: Array) -> Array:
    """A bearing as a line (2, 2) [m] as long as it is to the person."""
    length = float(np.hypot(*(towards - (ray.x, ray.y))))
    end = (ray.x + length * math.cos(ray.azimuth), ray.y + length * math.sin(ray.azimuth))
    return np.array([(ray.x, ray.y), end])


class VoiceWedges:
    """From where the robot stood when it heard a voice, a wedge two deviations wide, fading with age; in one node."""

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
        self._strokes.draw_each((voice_wedge(one), faded(VOICE, max(0.0, 1 - one.age / FADE_S))) for one in voices)


def voice_wedge(voice: VoiceDirection) -> Array:
    """A voice → segments (RAYS + 1, 2, 3) [m], world: its two sides and the arc between them."""
    half = min(max(WEDGE_SDS * voice.sd_heard, MIN_WEDGE_HALF_RAD), math.pi)
    angles = voice.azimuth_world + np.linspace(-half, half, WEDGE_RAYS)
    rim = voice.heard_at + WEDGE_LENGTH_M * np.column_stack((np.cos(angles), np.sin(angles)))
    return joined(np.vstack((voice.heard_at[None], rim, voice.heard_at[None])), VOICE_HEIGHT_M)
