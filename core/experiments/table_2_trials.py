"""The eight commands of Table 2 as trials: where one begins, what is said there, and what counts as success.

Every definition is printed next to its figure; `core.experiments.table_2` runs them.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from core.commands.follow_wall import AT_THE_WALL
from core.errors import BadInput
from core.experiments.spoken_room import ANN, SentenceOutcome, SpokenRoom
from core.geometry import Pose, wrap
from core.message import Array
from core.robots.requests import RemoveThing
from core.simulation.world import World, cast
from core.snapshot import Snapshot


def aside(truth: Pose, faces: Array, posts: Array, distance: float = 0.5, alone: float = 0.8) -> float | None:
    """Deviation [m] of a straight wall on the right from `distance` [m]; None with more than that one wall.

    `faces` (F, 4) x0 y0 x1 y1 [m] with the open side on the left, `posts` (P, 3) x y radius. It counts where nothing
    else that turns its open side to the robot lies within `alone` [m], the wall lies to the robot's right, and both
    its ends are farther along it than `distance`: nearer to them the way already turns.
    """
    start, edge = faces[:, :2], faces[:, 2:] - faces[:, :2]
    length = np.hypot(*edge.T)
    along = edge / length[:, None]
    away = (truth.x, truth.y) - start
    foot = np.einsum("ij,ij->i", away, along)
    side = along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0]
    gap = np.where(side > 0, np.hypot(side, foot - np.clip(foot, 0.0, length)), np.inf)
    if len(posts) and (np.hypot(*(posts[:, :2] - (truth.x, truth.y)).T) - posts[:, 2] < alone).any():
        return None
    near = np.flatnonzero(gap < alone)
    if len(near) != 1 or not distance < foot[near[0]] < length[near[0]] - distance:
        return None
    turned = wrap(math.atan2(along[near[0], 1], along[near[0], 0]) - truth.heading)
    return float(gap[near[0]] - distance) if abs(turned) < math.radians(45) else None


PLACES = ("lab", "floor")
MAX_TRIES = 3
FREE_RADIUS_M = 0.35  # of free floor around a start and a goal
WAY_HALF_WIDTH_M = 0.17  # to either side of a way that has to be free: the body, what the guard keeps, and a little
WAY_RAYS = 18  # side by side over that way: 2 cm apart, so that no table's leg stands between two
MAX_TURN_ERROR_RAD, MAX_CREEP_M = math.radians(2), 0.05  # of a turn, and [m] that it may leave its place
MAX_WAY_ERROR_M = 0.05  # of CONTINUE
MAX_PLACE_ERROR_M = 0.10  # of STOP AT
MAX_STOPPING_S = 1.0  # after the end of "stop moving" by which the wheels stand
COME_DISTANCES_M = (0.4, 0.6)  # of COME HERE
FOLLOW_DISTANCES_M = (0.6, 1.8)  # of FOLLOW ME
FOLLOWED_SHARE = 0.9  # of the minute of FOLLOW ME, at least, at these distances
MINUTE_S = 60.0
SETTLING_S, MAX_FOLLOWING_S = 10.0, 900.0  # of FOLLOW WALL: after it has come to the wall, and altogether at most
MIN_MEASURED_M = 5.0  # of straight wall beside which its distance is measured, at least
MAX_WALL_RMS_M = 0.03  # RMS
WAY_LENGTHS_M = (0.5, 0.8, 1.0, 1.2, 1.5, 2.0)  # of CONTINUE
PLACES_OF_WALK = ((1.5, 1.0), (2.6, 1.2), (2.4, 0.2), (1.0, -0.6), (0.0, -1.2), (-1.2, -0.4), (-0.6, 0.8))
"""[m] in sim:lab, between which Ann walks in FOLLOW ME."""
PERSON_SPEED_M_S = 0.2  # of hers
LEADING_DISTANCE_M = 0.8  # by which her way passes the robot as she sets out: who leads does not walk into it
WAY_SLACK_M = 0.01  # by which a way that leads away from the robot may come nearer to it
ARRIVED_M, WAY_STEPS = 0.05, 30  # from a place; places of a way that are looked at
MIN_LEG_M = 0.8  # of such a way, at least
ROUND = Pose(0.0, 0.0, 0.0)  # where FOLLOW ME begins: its walk is in sim:lab


@dataclass(frozen=True)
class TrialOutcome:
    """The outcome of a run besides its words."""

    success: bool
    why: str = ""
    figure: float | None = None  # what the definition measures


@dataclass(frozen=True)
class CommandTrial:
    """One command of the table."""

    definition: str
    unit: str  # of the figure
    start: Callable[[World, np.random.Generator], tuple[Pose, str]]  # a place to begin, and what is said there
    obey: Callable[[SpokenRoom, str], tuple[SentenceOutcome, TrialOutcome]]
    places: tuple[str, ...] = PLACES


# where it begins


def anywhere(words: str, world: World, chance: np.random.Generator) -> tuple[Pose, str]:
    """A place with free floor around it, and a heading."""
    box = world.bounds
    while True:
        x, y = float(chance.uniform(box.x0, box.x1)), float(chance.uniform(box.y0, box.y1))
        if world.free(x, y, FREE_RADIUS_M):
            return Pose(x, y, float(chance.uniform(-math.pi, math.pi))), words


def _before_free_floor(words: str, world: World, chance: np.random.Generator) -> tuple[Pose, str]:
    """Set the stage so that the longest way is free."""
    length = 3.0 if "stop" in words else float(chance.choice(WAY_LENGTHS_M))
    while True:
        pose, _ = anywhere("", world, chance)
        if _free_ahead(world, pose) > length + 0.6:
            return pose, words.format(x=f"{length:g}")


def _before_a_goal(words: str, world: World, chance: np.random.Generator) -> tuple[Pose, str]:
    """A goal on the free floor, in sight."""
    while True:
        pose, _ = anywhere("", world, chance)
        x, y = (round(float(chance.uniform(-2.5, 2.5)), 1) for _ in range(2))
        goal = pose.apply(np.array([[x, y]]))[0]
        towards = Pose(pose.x, pose.y, math.atan2(goal[1] - pose.y, goal[0] - pose.x))
        if (
            abs(x) + abs(y) > 0.6
            and world.free(float(goal[0]), float(goal[1]), FREE_RADIUS_M)
            and _free_ahead(world, towards) > math.hypot(x, y)
        ):
            return pose, words.format(x=_spoken(x), y=_spoken(y))


def _beside_a_wall(words: str, world: World, chance: np.random.Generator) -> tuple[Pose, str]:
    while True:
        pose, _ = anywhere("", world, chance)
        if world.clearance(pose.x, pose.y) < 1.2:
            return pose, words


def _in_the_round(words: str, world: World, chance: np.random.Generator) -> tuple[Pose, str]:
    return ROUND @ Pose(*chance.uniform((-0.2, -0.2, -3.1), (0.2, 0.2, 3.1)).tolist()), words


def _free_ahead(world: World, pose: Pose) -> float:
    """Free distance [m] straight ahead of the body."""
    c, s = math.cos(pose.heading), math.sin(pose.heading)
    side = np.array([[-s, c]]) * np.linspace(-WAY_HALF_WIDTH_M, WAY_HALF_WIDTH_M, WAY_RAYS)[:, None]
    origins = np.array([[pose.x, pose.y]]) + side
    return float(min([cast(origin, np.array([[c, s]]), world.obstacles).distance[0] for origin in origins]))


def _spoken(value: float) -> str:
    return f"minus {-value:g}" if value < 0 else f"{abs(value):g}"


# what is done, and whether it was right


def _turn(room: SpokenRoom, words: str) -> tuple[SentenceOutcome, TrialOutcome]:
    before = room.robot.truth
    room.place()
    heard, state, why = _done(room, words, 30.0)
    after = room.robot.truth
    off = wrap(after.heading - before.heading - math.copysign(math.pi / 2, 1 if "left" in words else -1))
    good = state == "done" and abs(off) < MAX_TURN_ERROR_RAD and before.distance_to(after.x, after.y) < MAX_CREEP_M
    return heard, TrialOutcome(success=good, why=why, figure=math.degrees(abs(off)))


def _go(room: SpokenRoom, words: str) -> tuple[SentenceOutcome, TrialOutcome]:
    before = room.robot.truth
    length = float(words.split()[1])
    room.place(off=along(before, length))
    heard, state, why = _done(room, words, 90.0)
    after = before.inverse() @ room.robot.truth
    off = math.hypot(after.x - length, after.y)
    return heard, TrialOutcome(success=state == "done" and off < MAX_WAY_ERROR_M, why=why, figure=off)


def _stop_at(room: SpokenRoom, words: str) -> tuple[SentenceOutcome, TrialOutcome]:
    before = room.robot.truth
    x, y = (float(part.replace("minus ", "-")) for part in words.removeprefix("stop at ").split(" and "))
    towards = before @ Pose(0.0, 0.0, math.atan2(y, x))
    room.place(off=along(towards, math.hypot(x, y)))
    heard, state, why = _done(room, words, 120.0)
    after = before.inverse() @ room.robot.truth
    off = math.hypot(after.x - x, after.y - y)
    return heard, TrialOutcome(success=state == "done" and off < MAX_PLACE_ERROR_M, why=why, figure=off)


def _stop(room: SpokenRoom, words: str) -> tuple[SentenceOutcome, TrialOutcome]:
    room.place(off=along(room.robot.truth, 3.0))
    going = room.robot.tell("continue 3 meters")
    room.robot.run(float(room.chance.uniform(1.0, 4.0)))
    heard = room.command(words, MAX_TRIES)
    if heard.number is None:
        return heard, TrialOutcome(success=False, why=heard.why)
    stood = math.inf
    for snapshot in room.robot.frames(3.0):
        if abs(room.robot.gate.twist.v) < 1e-9 and stood == math.inf:
            stood = snapshot.stamp
    ended = room.robot.ended(going)
    late = max(stood - heard.ended, 0.0)
    good = ended is not None and ended.state != "done" and late < MAX_STOPPING_S
    return heard, TrialOutcome(
        success=good, why="" if good else f"it stood {late:.2f} s after the words", figure=late
    )


def _follow_wall(room: SpokenRoom, words: str) -> tuple[SentenceOutcome, TrialOutcome]:
    room.place()
    heard = room.command(words, MAX_TRIES)
    if heard.number is None:
        return heard, TrialOutcome(success=False, why=heard.why)
    surfaces, off, since = room.world.surfaces(0.12), list[float](), math.inf
    before: Pose | None = None  # where its distance was measured last
    measured = 0.0  # [m]

    def watch(snapshot: Snapshot) -> None:
        nonlocal since, before, measured
        if snapshot.active_command is not None and snapshot.active_command.remark.startswith(AT_THE_WALL):
            since = min(since, snapshot.stamp)
        here = snapshot.truth
        if snapshot.stamp - since < SETTLING_S or here is None:
            return
        error = aside(here, surfaces.faces, surfaces.posts)
        if error is not None:
            off.append(error)
            measured += 0.0 if before is None else before.distance_to(here.x, here.y)
        before = None if error is None else here

    room.robot.robot.ask(RemoveThing(id=ANN))
    ended, began = None, room.robot.snapshot.stamp
    while ended is None and measured < MIN_MEASURED_M and room.robot.snapshot.stamp < began + MAX_FOLLOWING_S:
        ended = room.robot.wait(heard.number, 5.0, watch)
    straight = float(np.sqrt(np.mean(np.square(off)))) if off else None
    why = (
        ended.remark
        if ended
        else ""
        if measured >= MIN_MEASURED_M
        else f"only {measured:.1f} m of wall were measured"
    )
    good = not why and straight is not None and straight < MAX_WALL_RMS_M
    return heard, TrialOutcome(success=good, why=why, figure=straight)


def _come(room: SpokenRoom, words: str) -> tuple[SentenceOutcome, TrialOutcome]:
    x, y = room.place()
    truth = room.robot.truth
    heard = room.command(words, MAX_TRIES)
    if heard.call is not None:
        room.errors["sound_rad"].append(wrap(heard.call.azimuth - _azimuth(room, truth, x, y)))
    if heard.number is None:
        return heard, TrialOutcome(success=False, why=heard.why)
    ended = room.robot.wait(heard.number, 120.0, room.measure(x, y))
    apart = room.robot.truth.distance_to(x, y)
    state, why = (ended.state, ended.remark) if ended else ("running", "it took too long")
    good = state == "done" and COME_DISTANCES_M[0] <= apart <= COME_DISTANCES_M[1]
    return heard, TrialOutcome(success=good, why="" if good else why, figure=apart)


def _follow_me(room: SpokenRoom, words: str) -> tuple[SentenceOutcome, TrialOutcome]:
    room.put(ANN, x_m=1.6, y_m=0.2, clothes="red/blue")
    heard = room.command(words, MAX_TRIES)
    if heard.number is None:
        return heard, TrialOutcome(success=False, why=heard.why)
    kept = 0  # frames at the right distance
    goal: tuple[float, float] | None = None  # of Ann

    def watch(snapshot: Snapshot) -> None:
        nonlocal kept, goal
        if snapshot.truth is None:
            return
        ann = room.where(ANN)
        kept += FOLLOW_DISTANCES_M[0] <= snapshot.truth.distance_to(*ann) <= FOLLOW_DISTANCES_M[1]
        if goal is None or math.dist(ann, goal) < ARRIVED_M:
            goal = lead_on(room, ann, snapshot.truth)

    ended = room.robot.wait(heard.number, 4.0)
    if ended is None:
        crossing = {"path_m": [[1.2, -1.6], [1.2, 2.4]], "speed_m_s": 0.4, "again": True}
        room.put("Bob", x_m=1.2, y_m=2.4, clothes="white/green", **crossing)
        ended = room.robot.wait(heard.number, MINUTE_S, watch)
    frames = round(MINUTE_S * room.robot.robot.profile.rate)
    away = 100 * (1 - min(kept / frames, 1.0))  # what follows after it has given up counts, too
    why = ended.remark if ended else ""
    good = ended is None and away <= 100 * (1 - FOLLOWED_SHARE)
    return heard, TrialOutcome(success=good, why=why, figure=away)


def lead_on(room: SpokenRoom, ann: tuple[float, float], robot: Pose) -> tuple[float, float] | None:
    """Send Ann to another place, on a way that keeps off the robot → the place; None: she stands.

    Who stands nearer than that goes where she does not come nearer still.
    """
    apart = min(LEADING_DISTANCE_M, math.dist(ann, (robot.x, robot.y)) - WAY_SLACK_M)
    for number in room.chance.permutation(len(PLACES_OF_WALK)):
        goal = PLACES_OF_WALK[int(number)]
        way = np.linspace(ann, goal, WAY_STEPS)
        if math.dist(ann, goal) < MIN_LEG_M or np.hypot(*(way - (robot.x, robot.y)).T).min() < apart:
            continue
        try:
            room.put(ANN, x_m=ann[0], y_m=ann[1], path_m=[list(goal)], speed_m_s=PERSON_SPEED_M_S)
        except BadInput:  # no free floor between
            continue
        return goal
    return None


def _done(room: SpokenRoom, words: str, seconds: float) -> tuple[SentenceOutcome, str, str]:
    heard = room.command(words, MAX_TRIES)
    if heard.number is None:
        return heard, "", heard.why
    ended = room.robot.wait(heard.number, seconds)
    room.robot.run(0.5)
    if ended is None:
        return heard, "running", "it took too long"
    return heard, ended.state, ended.remark


def along(pose: Pose, length: float) -> list[tuple[float, float]]:
    """Places (x, y) [m] of the first `length` [m] straight ahead."""
    ahead = np.stack((np.linspace(0.0, length, 9), np.zeros(9)), axis=1)
    return [(x, y) for x, y in pose.apply(ahead).tolist()]


def _azimuth(room: SpokenRoom, truth: Pose, x: float, y: float) -> float:
    """Azimuth [rad] of a person, on the robot's own map."""
    return truth.bearing_to(x, y) + room.robot.snapshot.estimate.pose.heading


PRECONDITIONS = (
    "sim:lab and sim:floor in turn; follow me in sim:lab alone, follow wall in sim:floor alone, because sim:lab has"
    " 0.9 m of wall in all beside which nothing else stands and no corner is near",
    "a start with 0.35 m of free floor around it",
    "the speaker stands 1 to 3.8 m away on free floor where two thirds of the body are in sight of the camera,"
    " and a metre from the way of a drive; it leaves before follow wall is measured",
    f"what is not understood is said again, {MAX_TRIES} times in all",
    "continue and stop at: the way ahead is free for the body",
    f"follow wall: something lies within 1.2 m; the robot has {MAX_FOLLOWING_S / 60:g} minutes for the"
    f" {MIN_MEASURED_M:g} m, of which stretches near corners, doors and posts are none",
    f"follow me: begins in the middle of sim:lab; Ann, 1.6 m away, leads from place to place at"
    f" {PERSON_SPEED_M_S:g} m/s on ways that pass {LEADING_DISTANCE_M:g} m or more from where the robot stands as she"
    " sets out, or lead away from it where she stands nearer; Bob crosses at 0.4 m/s",
    "people walk around a robot that stands in their way",
    "no noise but the robot's own; one room acoustics per place; synthetic voices",
)
"""Conditions that make a run easier than any place and any person; printed with the table."""

TRIALS = {
    "turn_left": CommandTrial(
        "within 2° of 90° to the left, on the spot (5 cm)", "deg", partial(anywhere, "turn left"), _turn
    ),
    "turn_right": CommandTrial(
        "within 2° of 90° to the right, on the spot (5 cm)", "deg", partial(anywhere, "turn right"), _turn
    ),
    "stop_moving": CommandTrial(
        "the wheels stand within 1 s after the words", "s", partial(_before_free_floor, "stop moving"), _stop
    ),
    "continue": CommandTrial(
        "within 5 cm of the place straight ahead", "m", partial(_before_free_floor, "continue {x} meters"), _go
    ),
    "stop_at": CommandTrial(
        "within 10 cm of the place", "m", partial(_before_a_goal, "stop at {x} and {y}"), _stop_at
    ),
    "follow_wall": CommandTrial(
        f"RMS of its 0.5 m below 3 cm along at least 5 m of straight wall, within {MAX_FOLLOWING_S / 60:g} minutes",
        "m",
        partial(_beside_a_wall, "follow wall"),
        _follow_wall,
        ("floor",),
    ),
    "come_here": CommandTrial("stands 0.5 ± 0.1 m from the person", "m", partial(anywhere, "come here"), _come),
    "follow_me": CommandTrial(
        "0.6 to 1.8 m from the walking person during 90 % of a minute in which another one crosses",
        "% away",
        partial(_in_the_round, "follow me"),
        _follow_me,
        ("lab",),
    ),
}
"""The eight commands, in the table's order."""
