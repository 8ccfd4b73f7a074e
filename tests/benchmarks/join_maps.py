"""Two maps of sim:floor from two drives, joined: `python -m tests.benchmarks.join_maps --seeds 1 2 3`.

The first drive goes round most of the corridors, the second begins elsewhere, in axes of its own, and shares a part
of them; wheels bend both. How far landmarks lie from the corners of the floor plan: of each map alone, of the newer
one merely laid on the older one (before), and of the joined one (after).
"""

import time
from collections.abc import Sequence

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.message import Array
from core.simulation.world import world_named
from core.slam.map.map_file import SavedMap
from core.slam.map_join import join_maps, match_maps
from core.slam.mapper import Mapper
from tests.benchmarks.command import print_row, run_command
from tests.core.slam.ring import LASER, Moment, drive, told

FIRST_WAY_M = ((11.7, -0.1), (11.7, 7.5), (4.0, 7.5))
SECOND_WAY_M = ((11.7, -0.1), (11.7, 7.5), (-2.1, 7.5), (-2.1, -0.1), (2.0, -0.1))
BEGIN_AT = 60  # moments of the second drive that pass before it maps
CORNER_M = 0.5  # from a corner of the plan within which a landmark is of it


def mapped(moments: Sequence[Moment]) -> tuple[SavedMap, Pose]:
    """The map of a drive, and where its origin truly lies."""
    floor = Mapper(laser=LASER, watched=False)
    for moment in moments:
        told(floor, moment)
    floor.finish()
    saved = floor.saved()
    assert saved is not None
    return saved, moments[0].truth


def landmarks(saved: SavedMap) -> Array:
    """Landmarks (N, 2) [m] in the world of the map."""
    return np.array([one.position for one in Mapper(saved=saved, watched=False).landmarks]).reshape(-1, 2)


def errors(places: Array, truth: Pose) -> Array:
    """How far (N,) [m] landmarks lie from the nearest corner of the plan; `truth`: where the map's origin lies."""
    corners = world_named("floor").walls.reshape(-1, 2)
    gaps = np.hypot(*(truth.apply(places)[:, None] - corners[None]).transpose(2, 0, 1)).min(axis=1)
    return gaps[gaps < CORNER_M]


def figures(gaps: Array) -> dict[str, float | int]:
    """Median and 90 % of errors [m]."""
    return {
        "landmarks": len(gaps),
        "median_m": round(float(np.median(gaps)), 3),
        "p90_m": round(float(np.quantile(gaps, 0.9)), 3),
    }


def joined(seed: int) -> dict[str, object]:
    """One pair of drives."""
    older, truth = mapped(list(drive(seed, FIRST_WAY_M)))
    newer, start = mapped(list(drive(seed + 100, SECOND_WAY_M))[BEGIN_AT:])
    begun = time.perf_counter()
    parts = Mapper().parts
    match = match_maps(older, newer, parts)
    both = join_maps(older, newer, match, parts)
    seconds = time.perf_counter() - begun
    true = truth.inverse() @ start
    laid = np.vstack((landmarks(older), match.pose.apply(landmarks(newer))))
    return {
        "seed": seed,
        "agree": f"{match.agree} of {match.searched}",
        "links": len(match.links),
        "overlap": round(match.overlap, 3),
        "conflict": round(match.conflict, 3),
        "off_m": round(match.pose.distance_to(true.x, true.y), 3),
        "off_deg": round(float(np.degrees(match.pose.heading - true.heading)), 2),
        "older": figures(errors(landmarks(older), truth)),
        "newer_alone": figures(errors(landmarks(newer), start)),
        "before": figures(errors(laid, truth)),
        "after": figures(errors(landmarks(both), truth)),
        "seconds": round(seconds, 1),
    }


def main(*, seeds: Sequence[int] = (1,)) -> None:
    for seed in seeds:
        try:
            told_ = joined(seed)
        except BadInput as refused:
            told_ = {"seed": seed, "refused": str(refused)}
        print_row(told_)


if __name__ == "__main__":
    run_command(main)
