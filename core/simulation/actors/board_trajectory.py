"""The way of a held board from one place to another: smooth, at rest at both ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2

from core.geometry import Pose, Transform, wrap
from core.simulation.actors.board_holder import HeldBoardRequest
from core.simulation.world import HeldBoard, Thing


@dataclass(frozen=True)
class BoardTrajectory:
    """From `start` at time `begun` [s] to `end`, `seconds` later."""

    start: HeldBoardRequest
    end: HeldBoardRequest
    begun: float
    seconds: float

    def over(self, stamp: float) -> bool:
        """Return whether the board has arrived at `stamp` [s]."""
        return stamp >= self.begun + self.seconds

    def at(self, stamp: float) -> HeldBoardRequest:
        """Return the board and its holder at `stamp` [s]."""
        share = (stamp - self.begun) / self.seconds if self.seconds > 0 else 1.0
        if share >= 1:
            return self.end
        gone = smooth(max(share, 0.0))
        return HeldBoardRequest(_board(self.start.board, self.end.board, gone), _holder(self.start, self.end, gone))


def smooth(share: float) -> float:
    """Share of the time (0..1) → share of the way, without a jerk at either end (least-jerk polynomial)."""
    return share**3 * (10 - 15 * share + 6 * share**2)


def _board(start: HeldBoard, end: HeldBoard, gone: float) -> HeldBoard:
    """The middle goes straight while the board turns about one axis."""
    turn, _ = cv2.Rodrigues(end.pose.rotation @ start.pose.rotation.T)
    rotation = cv2.Rodrigues(gone * turn)[0] @ start.pose.rotation
    place = start.place + gone * (end.place - start.place)
    return replace(end, pose=Transform(rotation=rotation, translation=place - rotation @ end.middle))


def _holder(start: HeldBoardRequest, end: HeldBoardRequest, gone: float) -> Thing | None:
    if start.holder is None or end.holder is None:
        return end.holder
    a, b = start.holder.pose, end.holder.pose
    heading = wrap(a.heading + gone * wrap(b.heading - a.heading))
    return replace(end.holder, pose=Pose(a.x + gone * (b.x - a.x), a.y + gone * (b.y - a.y), heading))
