"""The planned path and its goal; and the preview of a pending command, gone when it begins or is dropped."""

import math
from collections.abc import Callable

import numpy as np
from viser import SceneApi

from console.control.command_preview import caller, preview
from console.scene.drawing.lines import CIRCLE, NOTHING, Lines, joined, lifted
from console.scene.drawing.palette import PLAN, PREVIEW
from console.scene.drawing.shapes import turned
from core.commands.command import Command, CommandPreview
from core.message import Array
from core.perception.people.voice_bearing import VoiceBearing
from core.robots import Profile
from core.snapshot import Snapshot

HEIGHT_M = 0.012
RING_RADII_M = (0.05, 0.11)
PIN = [(0.002, 0.012), (0.004, 0.03), (0.024, 0.15), (0.030, 0.17), (0.024, 0.19), (0.001, 0.20)]
PREVIEW_HEIGHT_M = 0.016
DASH_M = 0.07  # of a stroke, and of the gap after it
RAY_LENGTH_M = 3.0  # towards who spoke
ARROW_HEAD_M = 0.05  # of the two strokes that end a turn
GOAL_RADII = 1.15  # radii of the robot of the ring around the goal


class Plan:
    """A line to a pin with two rings."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._path = Lines(scene, "/path", PLAN, 3.2)
        self._goal = scene.add_frame("/goal", show_axes=False, visible=False)
        vertices, faces = turned(PIN)
        scene.add_mesh_simple("/goal/pin", vertices, faces, color=PLAN, side="double")
        for number, radius in enumerate(RING_RADII_M):
            ring = radius * np.column_stack((np.cos(CIRCLE), np.sin(CIRCLE)))
            Lines(scene, f"/goal/ring{number}", PLAN, 2.6 - number).draw(joined(ring, HEIGHT_M))
        self._shown: tuple[Array | None, Array | None] = (None, None)

    def show(self, snapshot: Snapshot) -> None:
        if self._shown[0] is snapshot.path and self._shown[1] is snapshot.goal:
            return
        self._shown = (snapshot.path, snapshot.goal)
        self._path.draw(joined(snapshot.path, HEIGHT_M))
        if snapshot.goal is not None:
            self._goal.position = np.array([snapshot.goal[0], snapshot.goal[1], 0.0])
        self._goal.visible = snapshot.goal is not None


class PreviewLines:
    """Broken lines, in one node."""

    def __init__(self, scene: SceneApi, robot: Profile, waiting: Callable[[], Command | None]) -> None:
        """`waiting`, from any thread: the command that waits, if one does."""
        self._strokes = Lines(scene, "/intended", PREVIEW, 3.0)
        self._radius = robot.radius
        self._waiting = waiting
        self._drawn = NOTHING

    def show(self, snapshot: Snapshot) -> None:
        """Draw the preview again when it has changed by a millimetre: the robot may still move."""
        command = self._waiting()
        if command is None:
            segments = NOTHING
        else:
            seen, call = preview(command, snapshot, self._radius), caller(command, snapshot)
            segments = np.round(strokes_of(seen, call, self._radius), 3)
        if not np.array_equal(segments, self._drawn):
            self._drawn = segments
            self._strokes.draw(segments)


def strokes_of(seen: CommandPreview, call: VoiceBearing | None, radius: float) -> Array:
    """Preview of a command → segments (N, 2, 3) [m], world; `radius` [m] of the robot."""
    pieces = [dashed(seen.path, DASH_M)]
    if seen.goal is not None:
        ring = np.array(seen.goal) + GOAL_RADII * radius * np.column_stack((np.cos(CIRCLE), np.sin(CIRCLE)))
        pieces.append(dashed(ring, 0.4 * DASH_M))
    if seen.heading is not None:
        pieces.append(_head(seen.path))
    if call is not None:
        ray = call.ray
        start = np.array([ray.x, ray.y])
        pieces.append(dashed(np.array([start, start + RAY_LENGTH_M * _unit(ray.azimuth)]), DASH_M))
    return lifted(np.concatenate(pieces), PREVIEW_HEIGHT_M)


def dashed(points: Array, dash: float) -> Array:
    """A line through points (P, 2) [m] → strokes (N, 2, 2) `dash` [m] long, with gaps as long between them."""
    if len(points) < 2:
        return np.zeros((0, 2, 2))
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    starts = np.arange(0.0, along[-1], 2 * dash)
    both = np.stack((starts, np.minimum(starts + dash, along[-1])), axis=1)
    return np.stack([np.interp(both, along, column) for column in points.T], axis=2)


def _head(way: Array) -> Array:
    """An arrow's head at the end of a way → its strokes (2, 2, 2)."""
    before, end = way[-2:]
    back = math.atan2(*(before - end)[::-1])
    return np.array([(end, end + ARROW_HEAD_M * _unit(back + side)) for side in (0.5, -0.5)])


def _unit(angle: float) -> Array:
    return np.array([math.cos(angle), math.sin(angle)])
