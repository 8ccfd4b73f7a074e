"""A likelihood field of earlier laser points, and the pose at which a scan fits it best."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from core.geometry import Pose, rotation, wrap
from core.message import Array

CELL_M = 0.05
BLUR_SD_CELLS = 1.2  # sd of the blur that draws points together into walls
RIDGE_CELLS = 7  # of the neighbourhood whose highest point counts as a wall's middle
MIN_POINTS_PER_CELL = 0.15  # points to a cell after the blur: less is no wall
RIM_CELLS = 16  # around everything, so that shifting never leaves the field
MAX_SHIFT_M = (RIM_CELLS - 1) * CELL_M  # of a shift
MAX_SIDE_CELLS = 1200  # of a side
MAX_ROUNDS = 8  # of the refinement, at most
MAX_MOVE_M = 0.05  # of one round, at most


@dataclass(frozen=True)
class Match:
    """The pose at which points fit a field."""

    pose: Pose
    score: float  # 0..1, mean field value at the points


class LikelihoodField:
    """Values 0..1 on a grid: ridges where points (K, 2) [m] lie, all equally high, be they near and dense or far."""

    def __init__(self, points: Array) -> None:
        low, high = points.min(axis=0), points.max(axis=0)
        self.origin = np.floor(low / CELL_M) * CELL_M - RIM_CELLS * CELL_M
        size = np.minimum(np.ceil((high - self.origin) / CELL_M).astype(int) + RIM_CELLS + 1, MAX_SIDE_CELLS)
        density = cv2.GaussianBlur(self._counts(points, size), (0, 0), BLUR_SD_CELLS)
        ridge = np.maximum(cv2.dilate(density, np.ones((RIDGE_CELLS, RIDGE_CELLS), np.uint8)), MIN_POINTS_PER_CELL)
        self.values = density / ridge
        self._flat = self.values.ravel()
        self._width, self._height = int(size[0]), int(size[1])

    def _counts(self, points: Array, size: Array) -> Array:
        """Points (K, 2) → how many fall on each cell (rows, columns), each shared among the four cells around it."""
        place = (points - self.origin) / CELL_M - 0.5
        place = place[((place >= 0) & (place < size - RIM_CELLS)).all(axis=1)]
        cell = place.astype(int)
        u, v = (place - cell).T
        first, count = cell[:, 1] * size[0] + cell[:, 0], size[0] * size[1]
        counts = np.zeros(count)
        for step, share in ((0, (1 - u) * (1 - v)), (1, u * (1 - v)), (size[0], (1 - u) * v), (size[0] + 1, u * v)):
            counts += np.bincount(first + step, share, count)
        return counts.reshape(size[1], size[0]).astype(np.float32)

    def search(self, points: Array, guess: Pose, reach: float, angle: float, step: float, turn: float) -> Pose:
        """The best pose on a lattice: ±`reach` [m] by `step`, ±`angle` [rad] by `turn` around the guess.

        `reach` beyond FARTHEST is FARTHEST, `angle` beyond π is π.
        """
        most = round(min(reach, MAX_SHIFT_M) / step)
        shift = np.arange(-most, most + 1) * round(step / CELL_M)
        shift = np.clip(shift, 1 - RIM_CELLS, RIM_CELLS - 1)
        offsets = (shift[:, None] * self._width + shift[None, :]).ravel()
        best, found = -1.0, guess
        count = round(min(angle, math.pi) / turn)
        for turned in guess.heading + turn * np.arange(-count, count + 1):
            cells = ((points @ rotation(turned).T + (guess.x, guess.y) - self.origin) / CELL_M).astype(int)
            cells = np.clip(cells, RIM_CELLS, (self._width - RIM_CELLS - 1, self._height - RIM_CELLS - 1))
            flat = cells[:, 1] * self._width + cells[:, 0]
            scores = self._flat[flat[None, :] + offsets[:, None]].mean(axis=1)
            at = int(scores.argmax())
            if scores[at] > best:
                best = float(scores[at])
                row, column = divmod(at, len(shift))
                ahead, aside = CELL_M * float(shift[column]), CELL_M * float(shift[row])
                found = Pose(guess.x + ahead, guess.y + aside, wrap(float(turned)))
        return found

    def refine(self, points: Array, guess: Pose) -> Match:
        """Gauss-Newton on the bilinear field from a guess nearby; without points the guess itself, with score 0."""
        if not len(points):
            return Match(guess, 0.0)
        x, y, heading = guess.x, guess.y, guess.heading
        for _ in range(MAX_ROUNDS):
            values, jacobian = self._slopes(points, x, y, heading)
            move = np.linalg.solve(jacobian.T @ jacobian + np.eye(3), jacobian.T @ (1.0 - values))
            move *= min(1.0, MAX_MOVE_M / max(math.hypot(move[0], move[1]), 1e-9))
            x, y, heading = x + float(move[0]), y + float(move[1]), heading + float(move[2])
            if math.hypot(move[0], move[1]) < 2e-4 and abs(move[2]) < 1e-4:
                break
        values, _ = self._slopes(points, x, y, heading)
        return Match(Pose(x, y, wrap(heading)), float(values.mean()))

    def values_at(self, points: Array, pose: Pose) -> Array:
        """Points (M, 2) at a pose → field values (M,)."""
        return self._slopes(points, pose.x, pose.y, pose.heading)[0]

    def cells_at(self, points: Array) -> Array:
        """Points (..., 2) [m] in the field's frame → the values (...) of their cells; 0 outside."""
        cells = np.floor((points - self.origin) / CELL_M).astype(int)
        u, v = cells[..., 0], cells[..., 1]
        inside = (u >= 0) & (u < self._width) & (v >= 0) & (v < self._height)
        return np.where(inside, self._flat[np.where(inside, v * self._width + u, 0)], 0.0)

    def _slopes(self, points: Array, x: float, y: float, heading: float) -> tuple[Array, Array]:
        """Points (M, 2) at a pose → field values (M,) and their change with x, y, heading (M, 3)."""
        turned = points @ rotation(heading).T
        place = (turned - (self.origin - np.array([x, y]))) / CELL_M - 0.5
        inside = ((place >= 0) & (place < (self._width - 1, self._height - 1))).all(axis=1)
        place = np.where(inside[:, None], place, 0.0)
        cell = place.astype(int)
        u, v = (place - cell).T
        flat = cell[:, 1] * self._width + cell[:, 0]
        a, b = self._flat[flat], self._flat[flat + 1]
        c, d = self._flat[flat + self._width], self._flat[flat + self._width + 1]
        values = np.where(inside, (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d), 0.0)
        along = np.where(inside, ((1 - v) * (b - a) + v * (d - c)) / CELL_M, 0.0)
        across = np.where(inside, ((1 - u) * (c - a) + u * (d - b)) / CELL_M, 0.0)
        return values, np.column_stack((along, across, across * turned[:, 0] - along * turned[:, 1]))
