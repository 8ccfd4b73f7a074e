"""Effect of a second camera beside the first, which gives vertical edges a distance where the laser sees nothing.

The drives are those of `audio-visual`. Besides, the robot looks from places drawn at random, and the distances of the
edges in its two pictures are compared with the true ones.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from core.experiments.about import About
from core.experiments.audio_visual import PLACES, AudioVisualPlace, RowErrors, Work, figures_of, table
from core.experiments.plan import ExperimentPlan, RunBatch
from core.experiments.result import ExperimentResult, stored
from core.geometry import Pose
from core.perception.landmarks.edges import ImageEdge, find_edges
from core.perception.landmarks.stereo import edges_by_pair
from core.robots.requests import CarryRobot
from core.settings import Settings
from core.simulation.robot import SimulatedRobot
from core.simulation.world import World, cast, world_named

BASELINE_M = 0.12  # between the cameras
ROWS = ("laser", "laser + camera", "laser + pair", "pair")
IN = tuple(place for place in PLACES if place.name in ("lab", "glass", "corridor, 1.5 m"))
VIEW_WORLDS, VIEW_COUNT = ("lab", "corridor", "glass"), 40  # and number of poses in each, for one drive
CLEARANCE_M = 0.3  # of such a pose
HEIGHTS_M = (0.16, 0.6, 1.2)  # at which the true distance is looked for: an edge may be of a table or a poster
ASIDE_RAD = math.radians(0.5)  # of an edge's direction: it is the end of something
WRONG_SDS = 5.0  # standard deviations from the truth, from which a distance is of no edge that is there

ABOUT = About(
    title="Two cameras instead of one",
    reproduces="The stereo cameras that the abstract names; the chapter has no figures of them. The cameras are "
    "simulated, 12 cm apart, take their pictures at the same moment and are mounted exactly as they are said to be; "
    "the drives are those of audio-visual.",
    runs=2,
    seed=20,
    counts="drives in every place",
    base_s=0.0,
    run_s=0.0,
)

Distance = tuple[float, float]  # error [m] of an edge's distance by the pair, and its sd [m]


class StereoResult(ExperimentResult):
    """The result, as JSON."""

    runs: int
    baseline_m: float
    edges: int  # in all pictures of the first camera
    with_distance: float  # share of them
    median_error_m: float  # of their distances, in size
    within_two_sds: float  # share of them; ideal 0.95
    wrong: float  # share of them that is of no edge that is there
    places: list[AudioVisualPlace]


def look_around(settings: Settings, seed: int, number: int) -> tuple[int, list[Distance]]:
    """Views of one world from poses drawn at random → the number of edges, and their distances."""
    name = VIEW_WORLDS[number % len(VIEW_WORLDS)]
    world, chance = world_named(name), np.random.default_rng([seed, number])
    robot = SimulatedRobot(name, seed=seed + number, settings=settings.simulation)
    poses, edges, seen = 0, 0, list[Distance]()
    while poses < VIEW_COUNT:
        low, high = (world.bounds.x0, world.bounds.y0, -math.pi), (world.bounds.x1, world.bounds.y1, math.pi)
        pose = Pose(*chance.uniform(low, high).tolist())
        if world.free(pose.x, pose.y, CLEARANCE_M):
            robot.ask(CarryRobot(x_m=pose.x, y_m=pose.y, heading_rad=pose.heading))
            both = _edges_of_both(robot, settings)
            poses, edges = poses + 1, edges + len(both[0])
            seen += _distances(*both, pose, world, robot, settings)
    return edges, seen


def _edges_of_both(robot: SimulatedRobot, settings: Settings) -> tuple[tuple[ImageEdge, ...], tuple[ImageEdge, ...]]:
    """The edges in the next two pictures that were taken at the same moment."""
    first, second = robot.profile.cameras
    newest = None
    while True:
        image = robot.read().image
        if image is not None and newest is not None and image.camera and image.stamp == newest.stamp:
            return find_edges(newest, first, settings.edges), find_edges(image, second, settings.edges)
        newest = image or newest


def _distances(
    edges: tuple[ImageEdge, ...],
    others: tuple[ImageEdge, ...],
    pose: Pose,
    world: World,
    robot: SimulatedRobot,
    settings: Settings,
) -> Iterator[Distance]:
    """Distances by the pair beside the true ones: of what stands nearest to it in an edge's direction."""
    first, second = robot.profile.cameras
    x, y = first.mounting.translation[:2].tolist()
    eye = pose @ Pose(x, y)
    for seen in edges_by_pair(edges, others, (first, second), Pose(x, y), 0.0, settings.edges)[0]:
        place = seen.position - (x, y)
        reach, bearing = float(np.hypot(*place)), eye.heading + math.atan2(place[1], place[0])
        aside = bearing + np.linspace(-ASIDE_RAD, ASIDE_RAD, 5)
        rays, at = np.column_stack((np.cos(aside), np.sin(aside))), np.array([eye.x, eye.y])
        true = np.concatenate([cast(at, rays, world.surfaces(height)).distance for height in HEIGHTS_M])
        nearest = float(true[np.argmin(np.abs(true - reach))])
        yield reach - nearest, math.sqrt(float(seen.covariance[0, 0]))


def plan(*, runs: int | None = None, seed: int = 0, settings: Settings | None = None) -> ExperimentPlan:
    """Plan `runs` drives (2) in every place, with seeds from `seed` on, and as often the views of every world."""
    count, base = runs or ABOUT.runs, settings or Settings()
    simulation, edges = replace(base.simulation, second_camera=BASELINE_M), replace(base.edges, by_pair=True)
    base = replace(base, simulation=simulation, edges=edges)
    drives = RunBatch(Work(IN, base, seed, count, ROWS), count * len(IN), dict[str, RowErrors | float])
    views = RunBatch(partial(look_around, base, seed), count * len(VIEW_WORLDS), tuple[int, list[Distance]])
    return ExperimentPlan((drives, views), partial(_result, seed))


def _result(
    seed: int, out: Path | None, drives: list[dict[str, RowErrors | float]], views: list[tuple[int, list[Distance]]]
) -> StereoResult:
    places, count = figures_of(IN, drives), len(drives) // len(IN)
    error, sd = np.abs([one for _, seen in views for one in seen]).reshape(-1, 2).T
    edges = sum(number for number, _ in views)
    result: StereoResult = {
        "runs": count,
        "seed": seed,
        "baseline_m": BASELINE_M,
        "edges": edges,
        "with_distance": len(error) / max(edges, 1),
        "median_error_m": float(np.median(error)),
        "within_two_sds": float(np.mean(error <= 2 * sd)),
        "wrong": float(np.mean(error > WRONG_SDS * sd)),
        "places": places,
        "text": table(places, count, seed),
        "files": {},
    }
    return stored(result, out, "stereo")
