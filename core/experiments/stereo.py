"""Distances of vertical edges by two cameras beside each other, beside the true ones."""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypedDict

import numpy as np

from core.experiments.plan import About, ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, stored
from core.geometry import Pose
from core.perception.landmarks.edges import find_edges
from core.perception.landmarks.stereo import edges_by_pair
from core.robots.requests import CarryRobot
from core.settings import Settings
from core.simulation.robot import SimulatedRobot
from core.simulation.world import World, cast, world_named

BASELINE_M = 0.12  # between the cameras
VIEW_WORLDS, VIEW_COUNT = ("lab", "corridor", "glass"), 40  # and number of poses in each, for one run
CLEARANCE_M = 0.3  # of such a pose
HEIGHTS_M = (0.16, 0.6, 1.2)  # at which the true distance is looked for: an edge may be of a table or a poster
ASIDE_RAD = math.radians(0.5)  # of an edge's direction: it is the end of something
WRONG_SDS = 5.0  # standard deviations from the truth, from which a distance is of no edge that is there

ABOUT = About(
    title="Two cameras instead of one",
    reproduces="The stereo cameras that the abstract names; the chapter has no figures of them. The cameras are "
    "simulated, 12 cm apart, take their pictures at the same moment and are mounted exactly as they are said to be. "
    "The true distance is the one nearest to the measured one within half a degree of an edge's direction.",
    runs=2,
    seed=20,
    counts="times 40 views of every room",
    base_s=1.0,
    run_s=9.0,
    swept=(
        "rooms.0.with_distance",
        "rooms.0.median_error_m",
        "rooms.0.within_two_sds",
        "rooms.0.wrong",
        "rooms.2.median_error_m",
    ),
)
# error [m] of one by the pair, its sd [m], and whether the laser sees nothing there
Distance = tuple[float, float, bool]


class RoomDistances(TypedDict):
    """The distances in one room, as JSON."""

    room: str
    edges: int  # in all pictures of the first camera
    with_distance: float  # share of them
    without_laser: (
        float | None
    )  # share of these in whose direction the laser sees nothing; None: there is no distance
    median_error_m: float | None  # in size
    within_two_sds: float | None  # share; ideal 0.95
    wrong: float | None  # share that is of no edge that is there


class StereoResult(ExperimentResult):
    """The result, as JSON."""

    runs: int
    baseline_m: float
    rooms: list[RoomDistances]


def look_around(settings: Settings, seed: int, number: int) -> tuple[int, list[Distance]]:
    """Views of one world from poses drawn at random → the number of edges, and their distances."""
    name = VIEW_WORLDS[number % len(VIEW_WORLDS)]
    world, chance = world_named(name), np.random.default_rng([seed, number])
    robot = SimulatedRobot(name, seed=seed + number, settings=settings.simulation)
    views, edges, seen = 0, 0, list[Distance]()
    while views < VIEW_COUNT:
        low, high = (world.bounds.x0, world.bounds.y0, -math.pi), (world.bounds.x1, world.bounds.y1, math.pi)
        pose = Pose(*chance.uniform(low, high).tolist())
        if world.free(pose.x, pose.y, CLEARANCE_M):
            robot.ask(CarryRobot(x_m=pose.x, y_m=pose.y, heading_rad=pose.heading))
            views, (count, found) = views + 1, _look(robot, world, pose, settings)
            edges, seen = edges + count, [*seen, *found]
    return edges, seen


def _look(robot: SimulatedRobot, world: World, pose: Pose, settings: Settings) -> tuple[int, Iterator[Distance]]:
    """The edges in the next two pictures of one moment → how many the first has, and distances of those in both."""
    first, second = robot.profile.cameras
    newest = image = robot.read().image
    while newest is None or image is None or not image.camera or image.stamp != newest.stamp:
        newest, image = image or newest, robot.read().image
    edges, others = (find_edges(one, camera, settings.edges) for one, camera in ((newest, first), (image, second)))
    x, y = first.mounting.translation[:2].tolist()
    seen, _ = edges_by_pair(edges, others, (first, second), Pose(x, y), 0.0, settings.edges)
    at = np.array(pose.apply(np.array([[x, y]]))[0])

    def compared() -> Iterator[Distance]:
        for one in seen:
            place = one.position - (x, y)
            reach, bearing = float(np.hypot(*place)), pose.heading + math.atan2(place[1], place[0])
            aside = bearing + np.linspace(-ASIDE_RAD, ASIDE_RAD, 5)
            rays, laser = np.column_stack((np.cos(aside), np.sin(aside))), robot.profile.lasers[0]
            true = np.concatenate([cast(at, rays, world.surfaces(height)).distance for height in HEIGHTS_M])
            unseen = cast(at, rays, world.laser_surfaces(laser.height)).distance.min() > laser.range_max
            yield float(np.abs(true - reach).min()), math.sqrt(float(one.covariance[0, 0])), bool(unseen)

    return len(edges), compared()


def plan(*, runs: int | None = None, seed: int = 0, settings: Settings | None = None) -> ExperimentPlan:
    """Plan `runs` (2) times 40 views of every world."""
    base = settings or Settings()
    base = replace(base, simulation=replace(base.simulation, second_camera=BASELINE_M))
    count = (runs or ABOUT.runs) * len(VIEW_WORLDS)
    views = RunBatch(partial(look_around, base, seed), count, tuple[int, list[Distance]])
    return ExperimentPlan((views,), partial(_result, seed))


def _result(seed: int, out: Path | None, done: list[tuple[int, list[Distance]]]) -> StereoResult:
    rooms: list[RoomDistances] = []
    for number, name in enumerate(VIEW_WORLDS):
        own = done[number :: len(VIEW_WORLDS)]
        error, sd, unseen = np.array([one for _, seen in own for one in seen]).reshape(-1, 3).T
        edges = sum(count for count, _ in own)
        rooms.append(
            {
                "room": name,
                "edges": edges,
                "with_distance": len(error) / max(edges, 1),
                "without_laser": float(np.mean(unseen)) if len(error) else None,
                "median_error_m": float(np.median(error)) if len(error) else None,
                "within_two_sds": float(np.mean(error <= 2 * sd)) if len(error) else None,
                "wrong": float(np.mean(error > WRONG_SDS * sd)) if len(error) else None,
            }
        )
    count = len(done) // len(VIEW_WORLDS)
    result: StereoResult = {
        "runs": count,
        "seed": seed,
        "baseline_m": BASELINE_M,
        "rooms": rooms,
        "text": table(rooms),
        "files": {},
    }
    return stored(result, out, "stereo")


def table(rooms: list[RoomDistances]) -> str:
    """The rooms, one a line."""
    lines = [
        f"Two cameras {100 * BASELINE_M:.0f} cm apart: distances of upright edges beside the true ones",
        f"{'room':12}{'edges':>8}{'distance':>10}{'no laser':>10}{'median error':>14}{'in 2 sd':>9}{'wrong':>8}",
    ]
    for one in rooms:
        shares = (one["with_distance"], one["without_laser"], one["within_two_sds"], one["wrong"])
        given, unseen, within, wrong = ("–" if share is None else f"{100 * share:.0f} %" for share in shares)
        error = "–" if one["median_error_m"] is None else f"{100 * one['median_error_m']:.1f} cm"
        lines.append(f"{one['room']:12}{one['edges']:8}{given:>10}{unseen:>10}{error:>14}{within:>9}{wrong:>8}")
    return "\n".join(lines)
