"""A source of sound at a place in the simulated room."""

from collections.abc import Generator

import numpy as np

from core.message import Array
from core.simulation.acoustics.enclosure import Enclosure, enclosure, in_sight
from core.simulation.acoustics.reverberation import Arrivals, Convolver, echo_in_pieces, echo_length, first_images
from core.simulation.settings import HardWall
from core.simulation.world import World

MOVED_M = 0.05  # by which an ear has moved when the echo is computed again
BEHIND_A_WALL = 0.1  # of the pressure that comes straight or by one bounce when a wall stands between


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
