"""Speakers in the simulated room: who speaks where, and the sound of every frame."""

import numpy as np

from core.errors import BadInput, Unavailable
from core.geometry import Pose
from core.message import Array
from core.robots.requests import Hush, ListeningState, SetListening, Speak, SpokenSound, finite
from core.sensors.microphones import Sound
from core.sensors.resampling import resampled
from core.simulation.microphones import RATE_HZ, SimulatedMicrophones
from core.simulation.settings import MicrophoneSettings
from core.simulation.world import World
from core.speech.synthesis import PERSONS_VOICE, VoiceSettings, speak

MOUTH_HEIGHT_M = 1.55  # above the floor
MOUTH_BELOW_CROWN_M = 0.15
MOUTH_HEIGHTS_M = (0.1, 2.5)  # of a mouth
RATE_BOUNDS_HZ = (8_000, 48_000)  # of samples that are brought along
MAX_REQUEST_S = 15.0  # of one request
LISTENING_TIME_S = 60.0  # for which the microphones go on after a person spoke
LOUD_SHARE = 0.1  # of the loudest moment, from which a moment belongs to the speech
MOMENT_S = 0.02
MIN_RMS = 0.01  # RMS of full scale that is still brought up to a voice's
LOUDNESS_FADE = 0.97  # of the loudness so far that is kept with every piece


class Speakers:
    """The simulated robot's ears and all who speak to it."""

    def __init__(
        self, settings: MicrophoneSettings, seed: np.random.SeedSequence, rate: float, wheelbase: float
    ) -> None:
        array = settings.mounted
        self._microphones = None if array is None else SimulatedMicrophones(array, settings, seed)
        self._block = round(RATE_HZ / rate)
        self._wheelbase = wheelbase
        self._listen = False  # it was requested
        self._heard_until = 0.0  # [s] until which the microphones listen because a person spoke
        self._strangers = 0
        self._levels: dict[str, float] = {}  # how loud those are whose sound comes in pieces

    def read(self, world: World, stamp: float, pose: Pose, speed: float, turn_rate: float) -> Sound | None:
        """Take one frame → the sound since the last one, while it is recorded."""
        ears = self._microphones
        if ears is None:
            return None
        if ears.talking:
            self._heard_until = stamp + LISTENING_TIME_S
        if not self._listen and stamp >= self._heard_until:
            ears.deaf()
            ears.follow(stamp)
            return None
        return ears.read(world, stamp, pose, speed, turn_rate, self._wheelbase)

    def listen(self, request: SetListening) -> ListeningState:
        """Listen without a pause, or not. Raises Unavailable for a deaf robot."""
        self._ears()
        self._listen = request.on
        return ListeningState(self._listen)

    def say(self, request: Speak, world: World, pose: Pose, stamp: float) -> SpokenSound:
        """Let it sound in the room. Raises BadInput, Refused or Unavailable that says what is wrong."""
        ears = self._ears()
        mouth, name = self._speaker(request, world)
        dry = _spoken(request)
        level = max(loudness(dry), LOUDNESS_FADE * self._levels.pop(name, 0.0))
        self._heard_until = stamp + LISTENING_TIME_S
        waiting = ears.say(name, mouth, dry / max(level, MIN_RMS), pose, self._block, more=request.more)
        if request.more:
            self._levels[name] = level
        return SpokenSound(id=name, seconds=round(waiting, 3), x_m=float(mouth[0]), y_m=float(mouth[1]))

    def hush(self, request: Hush) -> SpokenSound:
        """Silence a person. Raises BadInput when nobody of that name speaks, Unavailable for a deaf robot."""
        mouth = self._ears().hush(request.id)
        self._levels.pop(request.id, None)
        return SpokenSound(id=request.id, seconds=0.0, x_m=float(mouth[0]), y_m=float(mouth[1]))

    def _ears(self) -> SimulatedMicrophones:
        if self._microphones is None:
            raise Unavailable("This simulated robot is deaf: it has no microphones.")
        return self._microphones

    def _speaker(self, request: Speak, world: World) -> tuple[Array, str]:
        """Return the place of the mouth (3,) [m], and the name under which it speaks."""
        name = request.id
        if name is not None and not 0 < len(name) <= 40:
            raise BadInput("id must be a text of 1 to 40 characters.")
        person = next((one for one in world.things if one.id == name and one.what == "person"), None)
        if person is not None and request.x_m is None:
            mouth = np.array([person.pose.x, person.pose.y, person.height - MOUTH_BELOW_CROWN_M])
        else:
            height = MOUTH_HEIGHT_M if request.z_m is None else finite(request.z_m, "z_m")
            mouth = np.array([finite(request.x_m, "x_m"), finite(request.y_m, "y_m"), height])
        if not MOUTH_HEIGHTS_M[0] <= mouth[2] <= MOUTH_HEIGHTS_M[1]:
            raise BadInput(f"z_m must lie between {MOUTH_HEIGHTS_M[0]:g} and {MOUTH_HEIGHTS_M[1]:g}.")
        if not world.open_air(mouth[None]):
            raise BadInput("Nobody can speak from there; choose a place in the room, not in a wall or a thing.")
        if name is None:
            self._strangers += 1
            name = f"voice {self._strangers}"
        return mouth, name


def _spoken(request: Speak) -> Array:
    if request.pcm is not None:
        if not RATE_BOUNDS_HZ[0] <= request.rate_hz <= RATE_BOUNDS_HZ[1]:
            raise BadInput(f"rate_hz must be a whole number from {RATE_BOUNDS_HZ[0]:,} to {RATE_BOUNDS_HZ[1]:,}.")
        return _at_rate(_samples(request.pcm), request.rate_hz)
    if request.text is None:
        raise BadInput("Say what is to be said: text, or pcm.")
    speed = VoiceSettings().speed if request.speed is None else request.speed
    sound = speak(request.text, VoiceSettings(voice=request.voice or PERSONS_VOICE, speed=speed))
    return _at_rate(sound.samples[:, 0], sound.rate)


def _samples(pcm: bytes) -> Array:
    """16-bit samples → (N,) of full scale ±1."""
    if not pcm or len(pcm) % 2:
        raise BadInput("pcm must be an even number of bytes: 16-bit samples of one channel.")
    return np.frombuffer(pcm, "<i2") / 32768


def _at_rate(samples: Array, rate: int) -> Array:
    if len(samples) / rate > MAX_REQUEST_S:
        raise BadInput(f"Say at most {MAX_REQUEST_S:g} s at once; send the rest after it.")
    return resampled(samples, rate, RATE_HZ)


def loudness(samples: Array) -> float:
    """RMS of samples (N,) at RATE where they are loud."""
    length = round(MOMENT_S * RATE_HZ)
    moments = np.sqrt(np.mean(np.pad(samples, (0, -len(samples) % length)).reshape(-1, length) ** 2, axis=1))
    loud = moments[moments > LOUD_SHARE * moments.max()] if len(moments) else moments
    return float(np.sqrt(np.mean(loud**2))) if len(loud) else 0.0
