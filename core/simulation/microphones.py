"""The simulated robot's microphones: they hear talkers, a fan, its own motors, and the room's murmur."""

import zlib

import numpy as np

from core.errors import BadInput, Refused
from core.geometry import Pose, rotation
from core.message import Array
from core.sensors.microphones import MicrophoneArray, Sound
from core.simulation.acoustics.noise import Motors, Murmur
from core.simulation.acoustics.shoebox import pink_noise
from core.simulation.acoustics.sound_source import SoundSource
from core.simulation.settings import SILENT, MicrophoneSettings
from core.simulation.world import World

RATE_HZ = 16_000
VOICE_RMS = 0.05  # of full scale: RMS of a voice at 1 m
SETTLING_S = 0.8  # of listening before anybody speaks: the noise is to be known first
PIECE_TIMEOUT_S = 6.0  # that a talker whose sound comes in pieces is waited for
MOST_TALKERS = 3
ECHO_PIECES = 2  # of the work on echoes that are done with one reading, shared by all who talk
MAX_WAITING_S = 30.0  # of sound that may wait to be said
FAN_HEIGHT = 1.0  # [m]
FAN_FROM_WALL = 0.6  # [m]
MIN_MOUTH_DISTANCE_M = 0.15  # of a mouth to the microphones


class SimulatedMicrophones:
    """An array on the robot. The same seed and the same talk give the same sound."""

    def __init__(self, array: MicrophoneArray, settings: MicrophoneSettings, seed: np.random.SeedSequence) -> None:
        self.array, self._settings = array, settings
        chance = [np.random.default_rng(one) for one in seed.spawn(3)]
        self._seed = int(seed.generate_state(1)[0])
        self._spots = np.column_stack((array.mounting.apply(array.positions[:, :2]), array.positions[:, 2]))
        self._spots[:, 2] += array.height  # (M, 3) [m] in the robot's frame
        self._murmur = Murmur(chance[0], array.positions, RATE_HZ, array.speed)
        self._motors = Motors(chance[1], self._spots, RATE_HZ, array.speed)
        self._fan_noise = chance[2]
        self._fan: SoundSource | None = None
        self._talkers: list[SoundSource] = []
        self._begun = self._until = 0  # samples of the robot's time: where listening began, and what was heard
        self._listening = False

    @property
    def talking(self) -> bool:
        """True while a person speaks or is about to."""
        return bool(self._talkers)

    def ears(self, pose: Pose) -> Array:
        """Return the places of the microphones in the world, (M, 3) [m], when the robot is at `pose`."""
        level = self._spots[:, :2] @ rotation(pose.heading).T + (pose.x, pose.y)
        return np.column_stack((level, self._spots[:, 2]))

    def say(self, name: str, mouth: Array, dry: Array, pose: Pose, block: int, *, more: bool = False) -> float:
        """Say `dry` (N,), RMS about 1, at `mouth` (3,) [m]; a person of that name who speaks already goes on.

        `block`: samples of one reading. → seconds that wait to be said. Raises Refused or BadInput.
        """
        talker = next((one for one in self._talkers if one.name == name), None)
        if talker is None:
            if len(self._talkers) >= MOST_TALKERS:
                raise Refused(f"{MOST_TALKERS} people speak already; wait until one has finished.")
            if float(np.linalg.norm(self.ears(pose) - mouth, axis=1).min()) < MIN_MOUTH_DISTANCE_M:
                raise BadInput("That is on top of the robot's microphones; choose a place next to it.")
            seed = zlib.crc32(name.encode(), self._seed)
            room = self._settings
            talker = SoundSource(name, mouth, RATE_HZ, block, room.reverberation, seed, room.hard_wall)
            self._talkers.append(talker)
        if talker.seconds_waiting + len(dry) / RATE_HZ > MAX_WAITING_S:
            raise Refused(f"More than {MAX_WAITING_S:g} s wait to be said already; wait until they are.")
        talker.say(VOICE_RMS * dry)
        talker.open = more
        return talker.seconds_waiting

    def hush(self, name: str) -> Array:
        """Silence the person of that name → their mouth (3,) [m]. Raises BadInput when nobody of that name speaks."""
        talker = next((one for one in self._talkers if one.name == name), None)
        if talker is None:
            raise BadInput("Nobody of that name speaks.")
        self._talkers = [one for one in self._talkers if one is not talker]
        return talker.mouth

    def deaf(self) -> None:
        """Stop listening: the next sound begins without a past."""
        self._listening = False

    def read(self, world: World, stamp: float, pose: Pose, speed: float, turn_rate: float, wheelbase: float) -> Sound:
        """Return the sound since the last reading, up to `stamp` [s], with the robot now at `pose`."""
        end = round(stamp * RATE_HZ)
        if not self._listening:
            self._listening, self._begun = True, self._until
        count, begin = end - self._until, self._until
        self._until = end
        ears = self.ears(pose)
        total = VOICE_RMS * 10 ** (self._settings.murmur / 20) * self._murmur.take(count)
        if self._settings.motor_noise > SILENT:
            left, right = speed - turn_rate * wheelbase / 2, speed + turn_rate * wheelbase / 2
            total += VOICE_RMS * 10 ** (self._settings.motor_noise / 20) * self._motors.take(count, left, right)
        if self._settings.fan_noise > SILENT:
            total += self._blow(world, ears, count)
        settled = (begin - self._begun) / RATE_HZ >= SETTLING_S
        for talker in self._talkers:
            talker.prepare(world, ears, max(1, ECHO_PIECES // len(self._talkers)))
            total += talker.heard(ears, count, settled)
        self._talkers = [one for one in self._talkers if not one.over(PIECE_TIMEOUT_S)]
        whole = np.clip(np.round(total * 32768), -32768, 32767).astype(np.float32) / np.float32(32768)
        samples = np.zeros((count, max(self.array.channels) + 1), np.float32)
        samples[:, list(self.array.channels)] = whole
        return Sound(stamp=begin / RATE_HZ, rate=RATE_HZ, samples=samples)

    def follow(self, stamp: float) -> None:
        """Advance to `stamp` [s] without recording."""
        self._until = round(stamp * RATE_HZ)

    def _blow(self, world: World, ears: Array, count: int) -> Array:
        """The fan's noise at the ears (count, M): straight and by one wall; it is too steady for more to matter."""
        if self._fan is None:
            self._fan = SoundSource("fan", fan_place(world), RATE_HZ, count, 0.0, 0)
        if self._fan.seconds_waiting * RATE_HZ < count:
            noise = pink_noise(self._fan_noise, 1, RATE_HZ, RATE_HZ)[0]
            self._fan.say(VOICE_RMS * 10 ** (self._settings.fan_noise / 20) * noise)
        self._fan.prepare(world, ears)
        return self._fan.heard(ears, count, True)


def fan_place(world: World) -> Array:
    """Return the place of the fan (3,) [m]: the first corner of the floor plan that has room for it."""
    box = world.bounds
    low_x, low_y = box.x0 + FAN_FROM_WALL, box.y0 + FAN_FROM_WALL
    high_x, high_y = box.x1 - FAN_FROM_WALL, box.y1 - FAN_FROM_WALL
    corners = [(high_x, low_y), (low_x, high_y), (low_x, low_y), (high_x, high_y)]
    for inward in (0.0, 0.2, 0.4):
        for x, y in corners:
            spot = np.array([x + inward * ((box.x0 + box.x1) / 2 - x), y + inward * ((box.y0 + box.y1) / 2 - y)])
            if world.open_air(np.append(spot, FAN_HEIGHT)[None]):
                return np.append(spot, FAN_HEIGHT)
    return np.array([0.0, 0.0, FAN_HEIGHT])
