"""Places that were recognised, as arches from where the robot was to where it had seen the same before."""

import numpy as np
from viser import SceneApi

from console.scene.drawing.lines import CROSS, Lines, lifted
from console.scene.drawing.palette import CLOSURE, DOUBT, UNSURE, Colour
from core.message import Array
from core.robots import Profile
from core.slam.map.status import ClosureState, ClosureStatus
from core.snapshot import Snapshot

ARCH_PIECES = 24  # of an arch
MIN_ARCH_M, MAX_ARCH_M = 0.25, 2.0  # of an arch's middle
ARCH_STEEPNESS = 0.35  # height of an arch for its length
FOOT_M = 0.05  # of the cross at either end
FLOOR_HEIGHT_M = 0.012
COLOURS: dict[ClosureState, Colour] = {"accepted": CLOSURE, "doubtful": DOUBT, "undone": UNSURE}


class LoopClosureArcs:
    """One node for all arches; those that are undone are dashed."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._arches = Lines(scene, "/closures", CLOSURE, 2.6)
        self._shown: tuple[ClosureStatus, ...] = ()

    def show(self, snapshot: Snapshot) -> None:
        if snapshot.floor.closures is self._shown:
            return
        self._shown = snapshot.floor.closures
        self._arches.draw_each((strokes_of(closure), COLOURS[closure.state]) for closure in self._shown)


def strokes_of(closure: ClosureStatus) -> Array:
    """A closure → segments (N, 2, 3) [m]: an arch and a cross at either end."""
    spans = arch(closure.position_from, closure.position_to)
    if closure.state == "undone":
        spans = spans[::2]
    ends = (closure.position_from, closure.position_to)
    return np.concatenate((spans, *(lifted(at + FOOT_M * CROSS, FLOOR_HEIGHT_M) for at in ends)))


def arch(start: Array, end: Array) -> Array:
    """Feet (2,) [m] → segments (PIECES, 2, 3): half a wave over the line between them."""
    part = np.linspace(0.0, 1.0, ARCH_PIECES + 1)
    height = np.clip(ARCH_STEEPNESS * float(np.hypot(*(end - start))), MIN_ARCH_M, MAX_ARCH_M)
    ground = start + part[:, None] * (end - start)
    points = np.column_stack((ground, FLOOR_HEIGHT_M + height * np.sin(np.pi * part)))
    return np.stack((points[:-1], points[1:]), axis=1)
