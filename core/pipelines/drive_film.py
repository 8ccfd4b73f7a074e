"""A film of a recorded drive: the map as the page shows it, and what the camera saw, side by side."""

from pathlib import Path
from typing import Literal

import cv2
import numpy as np

from core.errors import BadInput, Unavailable
from core.geometry import Pose
from core.install import install_packages
from core.message import Array
from core.pilot.recorded_drive import AsRecorded, ComputedNow, robot_of
from core.pipelines.nav2_map import map_pixels
from core.recording.drive import NO_OWN_RECORDING, DriveRecording, is_drive
from core.settings import Settings
from core.slam.map.occupancy import OccupancyGrid
from core.snapshot import Snapshot

FilmForm = Literal["webp", "gif"]
FILM_HEIGHT, MAP_WIDTH, CAMERA_WIDTH = 360, 400, 480  # [px]
FRAME_PERIOD_S = 0.2
MAX_FRAMES = 240  # a longer part is shown quicker
SPAN_M = 8.0  # that the map shows around the robot, at least
BACKGROUND, TRAIL, SCAN, ROBOT_COLOUR = (24, 20, 17), (235, 145, 30), (60, 90, 240), (60, 190, 90)  # blue-green-red
ROBOT_RADIUS_PX = 7


def film_of(path: Path, begin_s: float, end_s: float, form: FilmForm) -> bytes:
    """The part from `begin_s` to `end_s` [s] after the start → an animated picture. Raises BadInput, Unavailable."""
    if not hasattr(cv2, "imencodeanimation"):
        raise Unavailable(f"Films need a newer OpenCV: {install_packages('opencv-python-headless>=4.12')}")
    if not is_drive(path):
        raise BadInput(NO_OWN_RECORDING)
    drive = DriveRecording(path)
    try:
        if not 0 <= begin_s < min(end_s, drive.duration):
            raise BadInput(f"A part begins before it ends, and lies between 0 and {drive.duration:.1f} s.")
        period_s = max(FRAME_PERIOD_S, (min(end_s, drive.duration) - begin_s) / MAX_FRAMES)
        frames = _frames(drive, begin_s, end_s, period_s)
    finally:
        drive.close()
    if not frames:
        raise BadInput("Nothing was seen or estimated in this part.")
    film = cv2.Animation()
    film.frames, film.durations = frames, [round(1000 * FRAME_PERIOD_S)] * len(frames)
    return cv2.imencodeanimation(f".{form}", film)[1].tobytes()


def _frames(drive: DriveRecording, begin_s: float, end_s: float, period_s: float) -> list[Array]:
    """Pictures (FILM_HEIGHT, MAP_WIDTH + CAMERA_WIDTH, 3) of the part."""
    frames: list[Array] = []
    camera: Array | None = None
    due, shown = begin_s, _shown(drive, begin_s)
    for moment in drive.moments(begin_s):
        at = moment.logged - drive.start
        if at > end_s or len(frames) >= MAX_FRAMES:
            break
        snapshot = shown.take(moment)
        camera = camera if moment.frame.image is None else moment.frame.image.pixels
        if at >= due and snapshot is not None:
            frames.append(np.hstack([_map_picture(snapshot), _camera_picture(camera)]))
            due = at + period_s
    return frames


def _shown(drive: DriveRecording, begin_s: float) -> AsRecorded | ComputedNow:
    """The results of that day; of a recording of readings alone, what is computed of them now."""
    if not drive.has_results:
        return ComputedNow(drive, Settings())
    recorded = AsRecorded(robot_of(drive, begin_s).used)
    recorded.begin(drive.latest("/map", begin_s), ())
    return recorded


def _camera_picture(pixels: Array | None) -> Array:
    panel = np.full((FILM_HEIGHT, CAMERA_WIDTH, 3), BACKGROUND, np.uint8)
    if pixels is not None:
        scale = min(CAMERA_WIDTH / pixels.shape[1], FILM_HEIGHT / pixels.shape[0])
        shown = cv2.resize(pixels, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        rows, columns = shown.shape[:2]
        top, left = (FILM_HEIGHT - rows) // 2, (CAMERA_WIDTH - columns) // 2
        panel[top : top + rows, left : left + columns] = shown
    return panel


def _map_picture(snapshot: Snapshot) -> Array:
    """The map around the robot, y up, with its way, its scan and itself."""
    pose = snapshot.estimate.pose
    scale = MAP_WIDTH / SPAN_M  # [px/m]
    panel = _laid(snapshot.grid, pose, scale)
    if len(snapshot.trail) > 1:
        trail = _pixels_of(snapshot.trail, pose, scale)
        cv2.polylines(panel, [trail], isClosed=False, color=TRAIL, thickness=2)
    for x, y in _pixels_of(snapshot.scan_points, pose, scale).tolist():
        if 0 <= x < MAP_WIDTH and 0 <= y < FILM_HEIGHT:
            panel[y, x] = SCAN
    centre = (MAP_WIDTH // 2, FILM_HEIGHT // 2)
    ahead = np.array([np.cos(pose.heading), -np.sin(pose.heading)]) * 2 * ROBOT_RADIUS_PX
    cv2.circle(panel, centre, ROBOT_RADIUS_PX, ROBOT_COLOUR, cv2.FILLED, cv2.LINE_AA)
    cv2.line(panel, centre, (round(centre[0] + ahead[0]), round(centre[1] + ahead[1])), ROBOT_COLOUR, 2, cv2.LINE_AA)
    return panel


def _laid(grid: OccupancyGrid, pose: Pose, scale: float) -> Array:
    """The grid's part around the robot, of which nothing is known beyond its edge."""
    if not grid.log_odds.size:
        return np.full((FILM_HEIGHT, MAP_WIDTH, 3), BACKGROUND, np.uint8)
    top_left = grid.origin + np.array([0.0, grid.log_odds.shape[0] * grid.resolution])
    x, y = _pixels_of(top_left[None], pose, scale)[0].tolist()
    cell = grid.resolution * scale  # [px]
    turn = np.array([[cell, 0.0, x], [0.0, cell, y]])
    grey = cv2.warpAffine(
        map_pixels(grid), turn, (MAP_WIDTH, FILM_HEIGHT), flags=cv2.INTER_NEAREST, borderValue=(205.0,)
    )
    return cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR)


def _pixels_of(points: Array, pose: Pose, scale: float) -> Array:
    """Points (N, 2) [m] of the world → pixels (N, 2) of the panel, int32."""
    apart = (points.reshape(-1, 2) - [pose.x, pose.y]) * [scale, -scale]
    return np.rint(apart + np.array([MAP_WIDTH / 2, FILM_HEIGHT / 2])).astype(np.int32)
