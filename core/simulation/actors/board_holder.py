"""A chessboard that is held up in the simulated room and moved smoothly, and the person who holds it."""

import math
from dataclasses import dataclass, replace
from typing import Any

import cv2
import msgspec
import numpy as np

from core.calibration.board.board import Board
from core.errors import BadInput
from core.geometry import Pose, Transform, wrap
from core.message import Array
from core.robots import Profile
from core.robots.requests import PlaceBoard, PlacedBoard, finite
from core.sensors import Camera
from core.simulation.actors.requests import BOARD, HOLDER
from core.simulation.world import SIZES, HeldBoard, Thing, World

MAX_PANEL_M = 2.0  # side of a panel
MAX_MOTION_S = 10.0  # of a motion
MAX_SKEW = 1e-3  # by which a rotation's columns may fail to be orthonormal
MIN_HEIGHT_M = 0.005  # above the floor
SPOTS_PER_SIDE = 7  # points along each side of the panel that must be in free air
BODY_HEIGHT_M = 0.25  # height of what the board must not touch of the robot
ROBOT_GAP_M = 0.01  # between robot and board
MIN_CAMERA_GAP_M = 0.12  # between the camera and the panel
ARM_LENGTHS_M = (0.22, 0.32, 0.45)  # from the farthest part of the board to the holder
ASIDE_OFFSETS_M = (0.2, -0.2, 0.0, 0.4, -0.4)  # the holder stands to the left of the board's middle


@dataclass(frozen=True)
class HeldBoardRequest:
    """A board in its place and who holds it there."""

    board: HeldBoard
    holder: Thing | None

    def put(self, world: World) -> World:
        """The world with them in it."""
        world = world_without(world).with_board(self.board)
        return world if self.holder is None else world.with_thing(self.holder)

    @property
    def described(self) -> PlacedBoard:
        """As the answers have it."""
        x, y, z = self.board.place.tolist()
        return PlacedBoard(
            id=BOARD,
            x_m=x,
            y_m=y,
            z_m=z,
            columns=self.board.columns,
            rows=self.board.rows,
            square_m=self.board.square,
            panel_m=self.board.panel,
            rotation=tuple(map(tuple, self.board.pose.rotation.tolist())),
            outline_m=tuple(map(tuple, self.board.outline.tolist())),
            holder=None if self.holder is None else HOLDER,
        )


def world_without(world: World) -> World:
    """The world with neither board nor holder."""
    held = [thing for thing in world.things if thing.id == HOLDER]
    return (world.without(HOLDER) if held else world).with_board(None)


def holding_asked_for(
    request: PlaceBoard, world: World, robot: Pose, radius: float, camera: Camera | None
) -> HeldBoardRequest:
    """The board of a request where it can be held, and its holder; BadInput says why it cannot."""
    kind, panel = _kind(request)
    pose = _pose(request, kind, robot, camera)
    board = HeldBoard(columns=kind.columns, rows=kind.rows, square=kind.square, panel=panel, pose=pose)
    bare = world_without(world)
    _check_room(board, bare)
    _check_robot(board, robot, radius, camera)
    if not request.holder:
        return HeldBoardRequest(board, None)
    former = next((thing for thing in world.things if thing.id == HOLDER), None)
    return HeldBoardRequest(board, _holder(board, bare, robot, radius, former))


def seconds_asked_for(request: PlaceBoard) -> float:
    """Return the duration of the way to the new place [s]. Raises BadInput for anything but such a time."""
    seconds = finite(request.seconds, "seconds")
    if not 0 <= seconds <= MAX_MOTION_S:
        raise BadInput(f"seconds must lie between 0 and {MAX_MOTION_S:g}.")
    return seconds


def _kind(request: PlaceBoard) -> tuple[Board, tuple[float, float]]:
    """The kind of board, and its panel (width, height) [m]; without one half a square of blank paper is around it."""
    panel = None
    if request.panel_m is not None:
        panel = _numbers(request.panel_m, (2,), "panel_m must be the panel's width and height in metres.")
    given = None if panel is None else (float(panel[0]), float(panel[1]))
    square = finite(request.square_m, "square_m")
    board = Board(columns=request.columns, rows=request.rows, square=square, panel=given)
    size = given or (board.width + 3 * board.square, board.height + 3 * board.square)
    if max(size) > MAX_PANEL_M:
        raise BadInput(f"Nobody holds up a board larger than {MAX_PANEL_M:g} m.")
    return board, size


def _pose(request: PlaceBoard, board: Board, robot: Pose, camera: Camera | None) -> Transform:
    in_camera = request.in_camera
    if in_camera is None:
        middle = np.array([finite(getattr(request, key), key) for key in ("x_m", "y_m", "z_m")])
        rotation = _facing(robot, middle) if request.rotation is None else _rotation(request.rotation)
        return Transform(rotation=rotation, translation=middle - rotation @ board.centre)
    if camera is None:
        raise BadInput("This robot has no camera; say where in the room the board shall be, with x_m, y_m and z_m.")
    place = _numbers(in_camera.translation_m, (3,), "translation_m must be three numbers, in metres.")
    seen = Transform(rotation=_rotation(in_camera.rotation), translation=place)
    return Transform.of_pose(robot) @ camera.mounting @ seen


def _facing(robot: Pose, middle: Array) -> Array:
    away = math.atan2(middle[1] - robot.y, middle[0] - robot.x)
    c, s = math.cos(away), math.sin(away)
    return np.array([[s, 0.0, c], [-c, 0.0, s], [0.0, -1.0, 0.0]])


def _rotation(rows: tuple[tuple[float, ...], ...]) -> Array:
    """Nine numbers → the nearest rotation (3, 3)."""
    matrix = _numbers(rows, (3, 3), "rotation must be 3 rows of 3 numbers.")
    if np.abs(matrix @ matrix.T - np.eye(3)).max() > MAX_SKEW or np.linalg.det(matrix) < 0:
        raise BadInput("rotation must be a rotation matrix: its columns are the board's axes, at right angles.")
    left, _, right = np.linalg.svd(matrix)
    return left @ right


def _numbers(given: tuple[Any, ...], shape: tuple[int, ...], sentence: str) -> Array:
    """Numbers, or rows of them, as an array of `shape`; BadInput(`sentence`) where they are not finite or so many."""
    flat: list[Any] = [given]
    for size in shape:
        if not all(len(part) == size for part in flat):
            raise BadInput(sentence)
        flat = [each for part in flat for each in part]
    if any(not abs(each) < 1e6 for each in flat):
        raise BadInput(sentence)
    return np.array(flat, float).reshape(shape)


def _check_room(board: HeldBoard, world: World) -> None:
    spots = board.spots(SPOTS_PER_SIDE)
    if spots[:, 2].min() < MIN_HEIGHT_M:
        raise BadInput("The board would go through the floor there; hold it higher, or nearer to the camera.")
    if spots[:, 2].max() > world.height:
        raise BadInput("The board would go through the ceiling there; hold it lower.")
    if not world.open_air(spots):
        raise BadInput("The board would go through a wall or a piece of furniture there; hold it somewhere else.")


def _check_robot(board: HeldBoard, robot: Pose, radius: float, camera: Camera | None) -> None:
    spots = board.spots(2 * SPOTS_PER_SIDE)
    low = spots[spots[:, 2] < BODY_HEIGHT_M]
    touched = bool((np.hypot(low[:, 0] - robot.x, low[:, 1] - robot.y) < radius + ROBOT_GAP_M).any())
    if camera is not None:
        eye = (Transform.of_pose(robot) @ camera.mounting).translation
        touched = touched or bool((np.linalg.norm(spots - eye, axis=1) < MIN_CAMERA_GAP_M).any())
    if touched:
        raise BadInput("The board would touch the robot there; hold it farther away.")


def _holder(board: HeldBoard, world: World, robot: Pose, radius: float, former: Thing | None) -> Thing:
    """Place a person behind the board as the robot sees it, where there is room, near where they stood before."""
    length, depth, height = SIZES["person"]
    middle = board.place[:2]
    heading = math.atan2(middle[1] - robot.y, middle[0] - robot.x)
    away, left = np.array([math.cos(heading), math.sin(heading)]), np.array([-math.sin(heading), math.cos(heading)])
    back = float(((board.outline[:, :2] - middle) @ away).max())
    places = [middle + (back + arm) * away + aside * left for aside in ASIDE_OFFSETS_M for arm in ARM_LENGTHS_M]
    if former is not None:
        places.sort(key=lambda place: former.pose.distance_to(*place))
    reach = length / 2
    for x, y in places:
        if robot.distance_to(x, y) > reach + radius and world.free(x, y, reach):
            pose = Pose(float(x), float(y), math.atan2(robot.y - y, robot.x - x))
            return Thing(id=HOLDER, what="person", pose=pose, length=length, depth=depth, height=height)
    raise BadInput("Nobody can stand behind the board there; choose a place with room behind it.")


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
        return HeldBoardRequest(
            _board_between(self.start.board, self.end.board, gone), _holder_between(self.start, self.end, gone)
        )


def smooth(share: float) -> float:
    """Share of the time (0..1) → share of the way, without a jerk at either end (least-jerk polynomial)."""
    return share**3 * (10 - 15 * share + 6 * share**2)


def _board_between(start: HeldBoard, end: HeldBoard, gone: float) -> HeldBoard:
    turn, _ = cv2.Rodrigues(end.pose.rotation @ start.pose.rotation.T)
    rotation = cv2.Rodrigues(gone * turn)[0] @ start.pose.rotation
    place = start.place + gone * (end.place - start.place)
    return replace(end, pose=Transform(rotation=rotation, translation=place - rotation @ end.middle))


def _holder_between(start: HeldBoardRequest, end: HeldBoardRequest, gone: float) -> Thing | None:
    if start.holder is None or end.holder is None:
        return end.holder
    a, b = start.holder.pose, end.holder.pose
    heading = wrap(a.heading + gone * wrap(b.heading - a.heading))
    return replace(end.holder, pose=Pose(a.x + gone * (b.x - a.x), a.y + gone * (b.y - a.y), heading))


class BoardMotion:
    """The board's place at every instant, if there is a board. Owned by the simulated robot."""

    def __init__(self, profile: Profile) -> None:
        self._profile = profile
        self._trajectory: BoardTrajectory | None = None

    def hold(self, request: PlaceBoard, world: World, robot: Pose, now: float) -> PlacedBoard:
        """Begin the request at `now` [s] → what is held, and how long the way takes.

        A board that was not there before is in its place at once. BadInput says what is wrong.
        """
        seconds = seconds_asked_for(request)
        wanted = holding_asked_for(request, world, robot, self._profile.radius, self._profile.camera)
        start = None if self._trajectory is None else self._trajectory.at(now)
        self._trajectory = BoardTrajectory(start or wanted, wanted, now, seconds if start else 0.0)
        return msgspec.structs.replace(wanted.described, seconds=self._trajectory.seconds)

    def put_down(self, name: str) -> None:
        """Take the board away. BadInput when there is none, or only its holder is named."""
        if self._trajectory is None:
            raise BadInput("There is no chessboard in the room.")
        if name == HOLDER:
            raise BadInput(f"The board's holder goes with it; remove the id {BOARD}.")
        self._trajectory = None

    def in_world(self, world: World, stamp: float) -> World:
        """The world as it is at `stamp` [s]: the same object while nothing moves."""
        if self._trajectory is None:
            return world if world.board is None else world_without(world)
        holding = self._trajectory.at(stamp)
        return world if world.board is holding.board else holding.put(world)

    def described(self, stamp: float) -> list[PlacedBoard]:
        """The board as the list of things has it, if there is one."""
        return [] if self._trajectory is None else [self._trajectory.at(stamp).described]
