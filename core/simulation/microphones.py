"""The simulated robot's microphones: they hear talkers, a fan, its own motors, and the room's murmur."""

import math
import zlib
from collections.abc import Generator

import numpy as np

from core.errors import BadInput, Refused
from core.geometry import Pose, rotation
from core.message import Array
from core.sensors.microphones import MicrophoneArray, Sound
from core.simulation.acoustics.enclosure import Enclosure, enclosure, in_sight
from core.simulation.acoustics.reverberation import Arrivals, Convolver, echo_in_pieces, echo_length, first_images
from core.simulation.acoustics.shoebox import SPEED_OF_SOUND_M_S, pink_noise
from core.simulation.settings import SILENT_DB, HardWall, MicrophoneSettings
from core.simulation.world import World

SPECTRUM_SAMPLES = 512  # samples of a spectrum of the murmur
FLAT_BELOW_HZ = 50.0
HISS_SHARE = 0.05  # of a microphone, of the murmur's pressure
MOTORS = np.array([[0.0, 0.045, 0.03], [0.0, -0.045, 0.03]])  # [m] in the robot's frame, left and right
FULL_SPEED_M_S = 0.1  # of a wheel at which its motor is at its nominal level
WHINE_HZ_PER_M_S = 2600.0  # [Hz per m/s] of the gears' teeth
OVERTONES = np.array([1.0, 0.5, 0.6, 0.25, 0.3, 0.15])
MOVED_M = 0.05  # by which an ear has moved when the echo is computed again
BEHIND_A_WALL = 0.1  # of the pressure that comes straight or by one bounce when a wall stands between
RATE_HZ = 16_000
VOICE_RMS = 0.05  # of full scale: RMS of a voice at 1 m
SETTLING_S = 0.8  # of listening before anybody speaks: the noise is to be known first
PIECE_TIMEOUT_S = 6.0  # that a talker whose sound comes in pieces is waited for
MOST_TALKERS = 3
ECHO_PIECES = 2  # of the work on echoes that are done with one reading, shared by all who talk
MAX_WAITING_S = 30.0  # of sound that may wait to be said
FAN_HEIGHT_M = 1.0
FAN_FROM_WALL_M = 0.6
MIN_MOUTH_DISTANCE_M = 0.15  # of a mouth to the microphones


class Murmur:
    """Pink noise that comes from everywhere alike, for microphones (M, 3) [m]; power 1."""

    def __init__(
        self, rng: np.random.Generator, positions: Array, rate: int, speed: float = SPEED_OF_SOUND_M_S
    ) -> None:
        self._rng, self._count = rng, len(positions)
        frequency = np.fft.rfftfreq(SPECTRUM_SAMPLES, 1 / rate)
        away = np.linalg.norm(positions[:, None] - positions, axis=2)
        alike = np.sinc(2 * frequency[:, None, None] * away / speed)  # coherence of a diffuse field
        mixing = np.linalg.cholesky(alike + 1e-6 * np.eye(self._count))
        colour = 1 / np.sqrt(np.maximum(frequency, FLAT_BELOW_HZ))
        colour[0] = colour[-1] = 0.0
        power = 4 * float(np.sum(colour**2)) / SPECTRUM_SAMPLES**2
        self._mixing = mixing * colour[:, None, None] / math.sqrt(power)
        self._window = np.sin(np.pi * (np.arange(SPECTRUM_SAMPLES) + 0.5) / SPECTRUM_SAMPLES)[:, None]
        self._ready = np.zeros((0, self._count))
        self._open = np.zeros((SPECTRUM_SAMPLES // 2, self._count))

    def take(self, count: int) -> Array:
        """The next (count, M)."""
        while len(self._ready) < count:
            shape = (SPECTRUM_SAMPLES // 2 + 1, self._count, 1)
            drawn = self._rng.normal(size=shape) + 1j * self._rng.normal(size=shape)
            block = np.fft.irfft((self._mixing @ drawn)[..., 0], SPECTRUM_SAMPLES, axis=0) * self._window
            self._ready = np.concatenate((self._ready, self._open + block[: SPECTRUM_SAMPLES // 2]))
            self._open = block[SPECTRUM_SAMPLES // 2 :]
        murmur, self._ready = self._ready[:count], self._ready[count:]
        return murmur + HISS_SHARE * self._rng.normal(size=murmur.shape)


class Motors:
    """Two geared motors under the microphones, silent at rest."""

    def __init__(
        self, rng: np.random.Generator, positions: Array, rate: int, speed: float = SPEED_OF_SOUND_M_S
    ) -> None:
        """`positions` (M, 3) [m] of the microphones in the robot's frame."""
        self._rng, self._rate = rng, rate
        self._away = np.linalg.norm(MOTORS[:, None] - positions, axis=2)  # (2, M)
        self._ways = [Arrivals(rate, speed) for _ in MOTORS]
        self._phases = [0.0, 0.0]
        self._speeds = [0.0, 0.0]

    def take(self, count: int, left: float, right: float) -> Array:
        """The next (count, M) with the wheels at these speeds [m/s]; power about 1 at FULL_SPEED."""
        total = np.zeros((count, self._away.shape[1]))
        if not (left or right or any(self._speeds)):
            return total
        for number, speed in enumerate((left, right)):
            away = self._away[number][None]
            total += self._ways[number].feed(self._motor(number, abs(speed), count), away, away, away)
        return total / math.sqrt(2)

    def _motor(self, number: int, speed: float, count: int) -> Array:
        """One motor's own sound (count,): whine of the gears and rush, both as loud as it is fast."""
        speeds = np.linspace(self._speeds[number], speed, count)
        phase = self._phases[number] + 2 * math.pi * WHINE_HZ_PER_M_S / self._rate * np.cumsum(speeds)
        self._speeds[number], self._phases[number] = speed, float(phase[-1] % (2 * math.pi))
        whine = OVERTONES @ np.sin(np.arange(1, len(OVERTONES) + 1)[:, None] * phase)
        rush = self._rng.normal(size=count)
        return speeds / FULL_SPEED_M_S * (0.6 * whine / math.sqrt(float(OVERTONES @ OVERTONES) / 2) + 0.8 * rush)


class SoundSource:
    """One source of sound. It begins to sound when its first echo is worked out."""

    def __init__(
        self, name: str, mouth: Array, rate: int, block: int, rt60: float, seed: int, hard: HardWall = "none"
    ) -> None:
        self.name, self.mouth = name, mouth
        self.open = False  # more is to come
        self._rate, self._rt60, self._seed = rate, rt60, seed
        self._hard: HardWall = hard
        self._waiting = np.zeros(0)  # that was not heard yet
        self._speed = 343.0  # [m/s]
        self._straight = Arrivals(rate, self._speed)
        self._echo = Convolver(echo_length(rt60, rate), block) if rt60 else None
        self._box: Enclosure | None = None
        self._images, self._gains = np.zeros((0, 3)), np.zeros(0)
        self._work: Generator[None, None, Array] | None = None
        self._worked_at: Array | None = None  # (M, 3) ears of the newest echo
        self._before: Array | None = None  # (K, M) [m] of the ways at the end of the last block
        self._muffled = 1.0
        self._silence = 0.0  # [s] since its last sound
        self.ready = self._echo is None

    def say(self, dry: Array) -> None:
        """More sound (N,), pressure at 1 m."""
        self._waiting = np.concatenate((self._waiting, dry))
        self._silence = 0.0

    @property
    def seconds_waiting(self) -> float:
        """[s] of sound that was not heard yet."""
        return len(self._waiting) / self._rate

    def over(self, patience: float) -> bool:
        """Return whether its last echo has died away; if more is to come, whether none came for `patience` [s]."""
        return self._silence > (patience if self.open else self._rt60 + 0.3)

    def prepare(self, world: World, ears: Array, pieces: int = 1) -> None:
        """Work on: know the room around ears (M, 3) [m] and `pieces` more of its echo, some milliseconds each."""
        if self._box is None or not self._box.holds(np.vstack((ears, self.mouth))):
            self._box = enclosure(world, np.vstack((ears, self.mouth)), self._rt60)
            room = self._box.room
            mouth = self._box.inside(self.mouth)
            images, self._gains = first_images(room.size, mouth, room.reflection, self._hard)
            self._images = images + self._box.corner
            self._before = self._worked_at = self._work = None
        moved = self._worked_at is None or float(np.abs(ears - self._worked_at).max()) > MOVED_M
        if self._work is None and moved:
            self._muffled = 1.0 if in_sight(world, ears.mean(0), self.mouth) else BEHIND_A_WALL
            self._worked_at = ears
            if self._echo is not None:
                inside = self._box.inside
                self._work = echo_in_pieces(self._box.room, inside(self.mouth), inside(ears), self._rate, self._seed)
        for _ in range(pieces):
            self._work_on()

    def _work_on(self) -> None:
        if self._work is None or self._echo is None:
            return
        try:
            next(self._work)
        except StopIteration as done:
            self._echo.change(done.value)
            self._work, self.ready = None, True

    def heard(self, ears: Array, count: int, begin: bool) -> Array:
        """The next `count` samples at ears (M, 3) [m], (count, M); silence until it is ready and may `begin`."""
        dry = np.zeros(count)
        if begin and self.ready:
            there = self._waiting[:count]
            dry[: len(there)] = there
            self._waiting = self._waiting[count:]
            self._silence = 0.0 if len(there) else self._silence + count / self._rate
        now = np.linalg.norm(self._images[:, None] - ears, axis=2)  # (K, M)
        before = now if self._before is None else self._before
        self._before = now
        gains = np.broadcast_to(self._muffled * self._gains[:, None], now.shape)
        total = self._straight.feed(dry, before, now, gains)
        echo = None if self._echo is None else self._echo.feed(dry)
        return total if echo is None else total + echo


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
        if self._settings.motor_noise > SILENT_DB:
            left, right = speed - turn_rate * wheelbase / 2, speed + turn_rate * wheelbase / 2
            total += VOICE_RMS * 10 ** (self._settings.motor_noise / 20) * self._motors.take(count, left, right)
        if self._settings.fan_noise > SILENT_DB:
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
    low_x, low_y = box.x0 + FAN_FROM_WALL_M, box.y0 + FAN_FROM_WALL_M
    high_x, high_y = box.x1 - FAN_FROM_WALL_M, box.y1 - FAN_FROM_WALL_M
    corners = [(high_x, low_y), (low_x, high_y), (low_x, low_y), (high_x, high_y)]
    for inward in (0.0, 0.2, 0.4):
        for x, y in corners:
            spot = np.array([x + inward * ((box.x0 + box.x1) / 2 - x), y + inward * ((box.y0 + box.y1) / 2 - y)])
            if world.open_air(np.append(spot, FAN_HEIGHT_M)[None]):
                return np.append(spot, FAN_HEIGHT_M)
    return np.array([0.0, 0.0, FAN_HEIGHT_M])
