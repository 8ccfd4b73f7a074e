"""An ideal robot on a drawn floor: perfect pose and map, a laser that sees the walls, a base that obeys at once."""

import dataclasses
from collections.abc import Callable

import numpy as np

from core.commands import spec_of
from core.commands.command import Action, Progress
from core.gate import Twist
from core.geometry import Pose, arc
from core.navigation.control_context import ControlContext, SteeredBody
from core.slam.map.occupancy import OccupancyGrid
from core.speech.understanding.grammar import Command, understand

STEP = 0.025  # [s]
OPEN = OccupancyGrid(
    revision=0, resolution=0.05, origin=np.array([-6.0, -6.0]), log_odds=np.full((240, 240), -4, np.float32)
)


class Stage:
    """Obeys one sentence at a time; `walls` (N, 2) [m], world, are what the laser sees and the body runs into."""

    def __init__(self, pose: Pose | None = None, grid: OccupancyGrid = OPEN) -> None:
        self.pose = pose or Pose()
        self.grid = grid
        self.walls = np.zeros((0, 2))
        self.stamp = 0.0
        self.held = self.held_forward = False
        self.jump = self.bend = Pose()
        self.path = np.zeros((0, 2))
        self.nearest = np.inf

    @property
    def here(self) -> ControlContext:
        """What a command sees; `jump` is the estimator's error, `bend` what closed loops did to the map."""
        seen = self.pose.inverse().apply(self.walls) if len(self.walls) else self.walls
        return ControlContext(
            stamp=self.stamp,
            pose=self.bend @ self.pose @ self.jump,
            speed=0.0,
            turn_rate=0.0,
            body=SteeredBody(),
            grid=self.grid,
            scan_points=seen,
            anchored=self.anchored,
        )

    def anchored(self, pose: Pose) -> Callable[[], Pose]:
        """Where a pose is on the map, however that is bent later."""
        there = self.bend.inverse() @ pose
        return lambda: self.bend @ there

    def begin(self, words: str, place: str | None = None, **numbers: float) -> Action:
        """Start obeying; `place`: the name of the place that the numbers are of."""
        command = understand(words)
        assert isinstance(command, Command)
        command = dataclasses.replace(command, numbers={**command.numbers, **numbers}, place=place)
        return spec_of(command.name).begin(command, self.here)

    def step(self, action: Action) -> Progress:
        progress = action.drive(self.here)
        if progress.path is not None:
            self.path = progress.path
        self.move(progress.twist)
        return progress

    def move(self, twist: Twist) -> None:
        """The base obeys for one frame, unless it is held or a wall bars its way."""
        moved = self.pose @ arc(twist.v * STEP, twist.w * STEP)
        gap = float(np.hypot(*(self.walls - (moved.x, moved.y)).T).min()) if len(self.walls) else np.inf
        free = gap > 0.12 or twist.v <= 0
        if not self.held and free and not (self.held_forward and twist.v > 0):
            self.pose = moved
        self.nearest = min(self.nearest, gap)
        self.stamp += STEP

    def obey(self, words: str, seconds: float = 120.0, **numbers: float) -> Progress:
        """Until it is finished."""
        action = self.begin(words, None, **numbers)
        while self.stamp < seconds:
            progress = self.step(action)
            if progress.finished:
                assert not progress.twist.moves
                return progress
        raise AssertionError(f"“{words}” was not finished in {seconds} s.")
