"""A practice room for the laser: an assistant holds the board before both sensors, among walls and furniture."""

from dataclasses import dataclass, field

import numpy as np

from core.calibration.board.board import Board
from core.calibration.laser.range_lines import unit_rays
from core.calibration.laser.session import beams_on_panel
from core.calibration.practice import BoardPlacement, held, seen
from core.calibration.projection import Poses, exponential
from core.geometry import OPTICAL, Transform
from core.message import Array, message
from core.optics import CameraModel
from core.sensors.laser import Laser


@dataclass(frozen=True)
class RoomSettings:
    """How the room measures."""

    noise: float = 0.03  # [m] standard deviation of one range
    lost: float = 0.01  # share of beams without a measurement
    corner_noise: float = 0.2  # [pixel]
    walls: tuple[float, float, float, float] = (-1.5, 3.5, -2.0, 2.0)  # [m] x from, to, y from, to
    cupboard: tuple[float, float, float] = (2.2, -1.1, 0.35)  # [m] x, y, radius of a round thing by the wall
    least_beams: int = 15  # that have to hit the board
    holding: BoardPlacement = field(
        default_factory=lambda: BoardPlacement(
            nearest=0.35, farthest=1.1, least_tilt=np.deg2rad(20), most_tilt=np.deg2rad(55)
        )
    )


@message
class Shot:
    """One still pose of the board: what both sensors deliver, and the truth."""

    corners: Array  # (N, 2) [pixel]
    scans: Array  # (K, B) [m]; NaN = no measurement
    on_board: Array  # (B,) bool, truth: beams on the board
    rotation: Array  # (3, 3), truth: camera_from_board
    translation: Array  # (3,) [m]


@dataclass
class PracticeRoom:
    """Camera, laser, their true mount, and chance."""

    model: CameraModel
    laser: Laser
    board: Board
    laser_from_camera: Transform
    rng: np.random.Generator
    settings: RoomSettings = field(default_factory=RoomSettings)

    @property
    def rays(self) -> Array:
        """(B, 3): the beams' unit vectors in the laser frame."""
        return unit_rays(self.laser.angle_min + self.laser.angle_step * np.arange(self.laser.beams))

    def background(self, scans: int = 50) -> Array:
        """Scans (scans, B) [m] of the room without board and assistant."""
        return self._measured(self._room(), scans)

    def shots(self, count: int, scans: int, *, poses: Poses | None = None) -> list[Shot]:
        """Still poses of the board that both sensors see, each with `scans` scans; by default random ones."""
        taken: list[Shot] = []
        for _ in range(100):
            batch = (
                held(self.rng, 4 * count, self.model, self.board, self.settings.holding) if poses is None else poses
            )
            for number in range(len(batch.rotations)):
                shot = self._shot(batch.take(slice(number, number + 1)), scans)
                if shot is not None:
                    taken.append(shot)
                if len(taken) == count:
                    return taken
            if poses is not None:
                return taken
        raise ValueError("The laser does not meet the board in these poses.")

    def _shot(self, pose: Poses, scans: int) -> Shot | None:
        laser_from_board = self.laser_from_camera @ Transform(
            rotation=pose.rotations[0], translation=pose.translations[0]
        )
        board = self._board(laser_from_board)
        ranges = np.minimum(np.minimum(self._room(), self._assistant(laser_from_board)), board)
        on_board = (ranges == board) & np.isfinite(board)
        if np.count_nonzero(on_board) < self.settings.least_beams:
            return None
        return Shot(
            corners=seen(self.rng, self.model, pose, self.board, self.settings.corner_noise)[0],
            scans=self._measured(ranges, scans),
            on_board=on_board,
            rotation=pose.rotations[0],
            translation=pose.translations[0],
        )

    def _measured(self, ranges: Array, scans: int) -> Array:
        noisy = ranges + self.rng.normal(0.0, self.settings.noise, (scans, len(ranges)))
        lost = (self.rng.random(noisy.shape) < self.settings.lost) | (noisy > self.laser.range_max)
        return np.where(lost | ~np.isfinite(noisy), np.nan, np.maximum(noisy, self.laser.range_min))

    def _room(self) -> Array:
        """Ranges (B,) [m] to walls and furniture."""
        x, y = self.rays[:, 0], self.rays[:, 1]
        west, east, south, north = self.settings.walls
        with np.errstate(divide="ignore"):
            along = np.where(x > 0, east / x, west / x)
            across = np.where(y > 0, north / y, south / y)
        return np.minimum(np.minimum(along, across), self._post(np.array(self.settings.cupboard)))

    def _board(self, laser_from_board: Transform) -> Array:
        """Ranges (B,) [m] to the panel; inf where the beam misses it."""
        beams, hit = beams_on_panel(self.rays, laser_from_board, self.board)
        ranges = np.full(len(self.rays), np.inf)
        ranges[beams] = hit
        return ranges

    def _assistant(self, laser_from_board: Transform) -> Array:
        """Ranges (B,) [m] to the one who holds the board: a body behind and beside it, a hand at its rim."""
        centre = laser_from_board.apply(self.board.centre[None])[0][:2]
        away = centre / np.linalg.norm(centre)
        aside = np.array([-away[1], away[0]]) * self.rng.choice([-1.0, 1.0])
        half = self.board.half_size[0]
        body = centre + away * self.rng.uniform(0.25, 0.45) + aside * self.rng.uniform(0.0, 0.35)
        hand = centre + aside * (half + self.rng.uniform(0.0, 0.03)) + away * self.rng.uniform(-0.03, 0.05)
        return np.minimum(self._post(np.append(body, 0.18)), self._post(np.append(hand, 0.04)))

    def _post(self, post: Array) -> Array:
        """Ranges (B,) [m] to an upright round thing: x, y, radius [m]; inf where the beam misses it."""
        along = self.rays[:, :2] @ post[:2]
        gap = post[2] ** 2 - (post[:2] @ post[:2] - along**2)
        ranges = along - np.sqrt(np.maximum(gap, 0.0))
        return np.where((gap > 0) & (ranges > 0), ranges, np.inf)


def some_mount(rng: np.random.Generator, turn: float = np.deg2rad(2), shift: float = 0.03) -> Transform:
    """A mount near the nominal one, off by `turn` [rad] and `shift` [m] (standard deviations per axis)."""
    off = exponential(rng.normal(0.0, turn, (1, 3)))[0]
    return Transform(rotation=off @ OPTICAL, translation=np.array([0.04, 0.0, 0.04]) + rng.normal(0.0, shift, 3))
