"""Hearing where: from a frame's sound to voices and their directions in the world."""

import math
from collections import deque
from dataclasses import replace

import numpy as np

from core.errors import BadInput
from core.geometry import Pose, wrap
from core.message import Array
from core.perception.landmarks.frame_perception import BearingSet
from core.perception.people.voice_bearing import VoiceBearing
from core.perception.sound.array_diagnostics import contradiction
from core.perception.sound.direction import Direction
from core.perception.sound.doa_stream import DoaStream, HeardDirections
from core.perception.sound.locate import sure
from core.perception.sound.settings import DirectionFindingSettings
from core.perception.sound.tracking import MIN_APART_RAD, Voice, VoiceTracker
from core.robots import Profile
from core.sensors import Sound
from core.sensors.microphones import MicrophoneArray, usable
from core.slam.estimate import Estimate
from core.slam.motion import Increment
from core.slam.motion_history import MotionHistory
from core.snapshot import Hearing, VoiceDirection

HEADING_MEMORY_S = 10.0  # of headings: an utterance is judged once more when it is over
SILENCE_DB = -120.0
MAX_UTTERANCES = 5  # by which the array is judged
LEVEL_FADE_S = 0.15  # over which the level falls
MAX_ELEVATION_SD_RAD = 0.5  # sd from which an elevation is not shown


class SoundPerception:
    """Keeps the voices that were heard. Directions are turned into the world with the heading of their own moment."""

    def __init__(self, profile: Profile, settings: DirectionFindingSettings) -> None:
        self._array, self._settings = profile.microphones, settings
        self._listener = None if self._array is None else DoaStream(self._array, settings)
        self._tracker = VoiceTracker()
        self._poses: deque[tuple[float, Pose, float]] = deque()  # stamp [s], pose, variance of its heading
        self._places: dict[int, Array] = {}  # (2,) [m] of the robot, when each voice was last heard
        self._surest: dict[int, float] = {}  # [rad] sd of each voice's azimuth then
        self._newest: dict[int, Direction] = {}
        self._recall = MotionHistory()
        self._heard: tuple[Direction, ...] = ()  # in the array's frame, with the newest frame
        self._power = 0.0
        self._listening = False  # sound came with the newest frame
        self.trouble = ""  # why the sound is of no use
        self.call: VoiceBearing | None = None  # the voice that was heard last, as it was heard
        self._utterances: deque[tuple[Direction, ...]] = deque(maxlen=MAX_UTTERANCES)
        self.contradiction = ""  # what the microphones contradict each other in, so that no voice is gone to

    def hear_with(self, array: MicrophoneArray | None) -> None:
        """Hear with this array from now on: its orientation was found."""
        if array is not self._array:
            self._array = array
            self._listener = None if array is None else DoaStream(array, self._settings)
            self._utterances.clear()
            self.contradiction = ""

    def listen(self, sound: Sound | None, stamp: float, increment: Increment | None = None) -> BearingSet | None:
        """Take the sound up to `stamp` [s] → bearings of the directions that became known with it, if any.

        `increment`: the robot's move since the sound before; None: it stood. The bearings are of some moments ago;
        the microphones are where they were then, seen from the robot now.
        """
        self._recall.add(stamp, increment or Increment())
        self._listening, self._heard = sound is not None, ()
        if self._array is None or self._listener is None:
            return None
        heard: tuple[HeardDirections, ...] = ()
        if sound is not None and len(sound.samples):
            self._measure(sound)
            try:
                heard = self._listener.feed(sound, moving=increment is not None and not increment.still)
                self.trouble = ""
            except BadInput as trouble:
                self.trouble = str(trouble)
        self._judge_array(heard)
        self._heard = tuple(one for moment in heard for one in moment.directions if sure(one, self._settings))
        return self._bearings(stamp, self._array) if self._heard else None

    def hear(self, stamp: float, estimate: Estimate) -> Hearing | None:
        """Return the voices in the sound up to `stamp` [s] that `listen` took; None without microphones."""
        if self._array is None or self._listener is None:
            return None
        heading = estimate.pose.heading
        self._poses.append((stamp, estimate.pose, float(estimate.covariance[2, 2])))
        while self._poses[0][0] < stamp - HEADING_MEMORY_S:
            self._poses.popleft()
        voices = self._follow(stamp, estimate)
        return Hearing(
            listening=self._listening,
            speaking=self._listening and self._listener.speaking,
            level_db=max(SILENCE_DB, 10 * math.log10(self._power + 1e-30)) if self._listening else None,
            voices=tuple(self._shown(voice, stamp, heading) for voice in voices if voice.id in self._newest),
        )

    def heard_in(self, begin: float, end: float) -> tuple[VoiceBearing, ...]:
        """All directions in words spoken from `begin` to `end` [s] that the microphones do not contradict; echoes and
        other talkers are among them.

        Those of one moment of the words have one stamp. () where that is not remembered.
        """
        if self._listener is None or not self._poses or self._poses[0][0] > begin:
            return ()
        found: list[VoiceBearing] = []
        for number, moment in enumerate(self._listener.within(begin, end)):
            for one in moment.directions:
                if one.misfit > self._settings.declared_misfit:
                    continue
                seen = self._in_world(one)
                pose = min(self._poses, key=lambda each: abs(each[0] - one.stamp))[1]
                bearing = VoiceBearing(
                    stamp=(end, (begin + end) / 2, begin / 4 + 3 * end / 4)[number],
                    azimuth=wrap(seen.azimuth),
                    sd=seen.azimuth_sd,
                    x=pose.x,
                    y=pose.y,
                    strength=one.strength,
                )
                found.append(bearing)
        return tuple(found)

    def _bearings(self, stamp: float, array: MicrophoneArray) -> BearingSet | None:
        """The newest directions of this array, seen from the robot at `stamp` [s]."""
        then = self._heard[-1].stamp
        move = self._recall.moved(stamp, then)
        found = [one for one in self._heard if one.stamp == then]
        if move is None:
            return None
        return BearingSet(
            stamp=then,
            eye=move.pose @ array.mounting,
            bearings=np.array([one.azimuth for one in found]),
            sds=np.array([one.azimuth_sd for one in found]),
            looks=np.zeros(len(found)),
        )

    def _measure(self, sound: Sound) -> None:
        power = float(np.mean(np.asarray(sound.samples, float) ** 2)) if usable(sound.samples) else 0.0
        self._power = max(power, self._power * math.exp(-sound.duration / LEVEL_FADE_S))

    def _judge_array(self, heard: tuple[HeardDirections, ...]) -> None:
        over = [one.directions for one in heard if one.end is not None and one.directions]
        if not over or self._array is None:
            return
        self._utterances.extend(over)
        found = [one for each in self._utterances for one in each]
        fault = contradiction(found, self._array, self._settings)
        self.contradiction = "" if fault is None else fault.fault.statement

    def _follow(self, stamp: float, estimate: Estimate) -> tuple[Voice, ...]:
        """The newest directions → the voices, seen from the world."""
        found = [self._in_world(one) for one in self._heard]
        voices = self._tracker.update(found, stamp)
        for voice in voices:
            near = [one for one in found if one.angle_to(voice.towards) < MIN_APART_RAD]
            if voice.heard == stamp and near:
                self._newest[voice.id] = min(near, key=lambda one: one.angle_to(voice.towards))
                self._places[voice.id] = np.array([estimate.pose.x, estimate.pose.y])
                self._surest[voice.id] = voice.bearing_sd
                self.call = VoiceBearing(
                    stamp=voice.heard,
                    azimuth=wrap(voice.bearing),
                    sd=voice.bearing_sd,
                    x=estimate.pose.x,
                    y=estimate.pose.y,
                    strength=self._newest[voice.id].strength,
                )
        for gone in self._newest.keys() - {voice.id for voice in voices}:
            del self._newest[gone], self._places[gone], self._surest[gone]
        return voices

    def _in_world(self, one: Direction) -> Direction:
        """A direction from the array's frame, by the heading of its moment, whose doubt is added."""
        assert self._array is not None
        stamps, headings, variances = np.array([(at, pose.heading, doubt) for at, pose, doubt in self._poses]).T
        heading = float(np.interp(one.stamp, stamps, np.unwrap(headings)))
        level = float(one.towards[0] ** 2 + one.towards[1] ** 2)
        doubt = np.diag((level * float(np.interp(one.stamp, stamps, variances)), 0.0))
        return replace(one, covariance=one.covariance + doubt).turned(heading + self._array.mounting.heading)

    def _shown(self, voice: Voice, stamp: float, heading: float) -> VoiceDirection:
        newest = self._newest[voice.id]
        return VoiceDirection(
            id=voice.id,
            stamp=voice.heard,
            age=stamp - voice.heard,
            azimuth=wrap(voice.bearing - heading),
            azimuth_world=wrap(voice.bearing),
            sd=voice.bearing_sd,
            sd_heard=self._surest[voice.id],
            elevation=newest.elevation if newest.elevation_sd < MAX_ELEVATION_SD_RAD else None,
            ambiguity=newest.turned(-heading).ambiguity,
            strength=newest.strength,
            heard_at=self._places[voice.id],
        )
