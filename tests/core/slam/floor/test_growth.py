"""What is done with every scan does not grow with the map."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from core.geometry import Pose
from core.slam.ekf import EkfSlam
from core.slam.floor import atlas as atlas_module
from core.slam.floor.atlas import Atlas
from core.slam.floor.closure import ClosureSettings
from core.slam.floor.keyframe import keyframe
from core.slam.floor.matching import MatchingSettings
from core.slam.floor.pose_graph import Edge
from core.slam.floor.submap import Submap
from core.slam.floor.surveyor import Surveyor
from core.slam.motion import Increment
from core.slam.occupancy import OccupancyMap

STEP, SURE = 0.5, np.diag([1e-4, 1e-4, 1e-5])
ENDS, HITS = np.array([(2.0, -0.1), (2.0, 0.0), (2.0, 0.1)]), np.ones(3, bool)
PER_SUBMAP = 50


def go_on(atlas: Atlas) -> None:
    """One view more, straight ahead; a new submap where it is time to."""
    number = len(atlas.views)
    if number % PER_SUBMAP == 0:
        atlas.submaps.append(Submap(len(atlas.submaps), EkfSlam(), OccupancyMap()))
    submap = len(atlas.submaps) - 1
    local = Pose(STEP * (number % PER_SUBMAP))
    view = keyframe(number, submap, float(number), local, ENDS, HITS, Pose())
    driven = Increment(Pose(STEP), SURE) if number else None
    anchor = submap * PER_SUBMAP
    tie = Edge(anchor, number, local, SURE) if number > anchor else None
    atlas.add(view, driven, tie, Pose(STEP * number))


def line(views: int) -> Atlas:
    atlas = Atlas()
    for _ in range(views):
        go_on(atlas)
    return atlas


def counted(monkeypatch: pytest.MonkeyPatch, name: str) -> list[int]:
    """How often something of the atlas's module is called from now on."""
    calls, real = [0], getattr(atlas_module, name)

    def call(*given: Any) -> Any:
        calls[0] += 1
        return real(*given)

    monkeypatch.setattr(atlas_module, name, call)
    return calls


def test_ways_are_measured_near_by_and_every_edge_once(monkeypatch: pytest.MonkeyPatch) -> None:
    atlas = line(400)
    atlas.ways_from(399, 30.0)
    calls = counted(monkeypatch, "_reach")
    go_on(atlas)
    ways = atlas.ways_from(400, 30.0)
    assert calls[0] <= 2
    assert ways[400] == 0.0 and ways[399] == pytest.approx(STEP) and ways[360] == pytest.approx(20.0)
    assert math.isinf(ways[300]) and len(ways) == 401


def test_the_graph_is_factored_once_for_the_places_of_all_submaps(monkeypatch: pytest.MonkeyPatch) -> None:
    atlas = line(400)
    calls = counted(monkeypatch, "Marginals")
    spreads = [np.trace(atlas.spread_of(submap)) for submap in (1, 3, 5, 3, 1)]
    assert calls[0] == 1
    assert 0 < spreads[0] == spreads[4] < spreads[1] == spreads[3] < spreads[2]
    go_on(atlas)  # the first of a submap that the graph was not factored with
    atlas.spread_of(8)
    assert calls[0] == 2
    atlas.revise(atlas.pose_array(), len(atlas.views))
    atlas.spread_of(1)
    assert calls[0] == 3


def test_poses_are_told_as_they_are_now() -> None:
    atlas = line(70)
    atlas.pose_array()[:] = 7.0
    go_on(atlas)
    assert atlas.pose_array()[:, 0] == pytest.approx(STEP * np.arange(71))
    atlas.revise(np.add(atlas.pose_array(), (1.0, 0.0, 0.0)), 71)
    go_on(atlas)
    assert atlas.pose_array()[:71, 0] == pytest.approx(1.0 + STEP * np.arange(71))


class Counting(dict[int, int]):
    """Counts how often it is asked."""

    asked = 0

    def get(self, *given: Any) -> Any:
        self.asked += 1
        return super().get(*given)


def surveyed(atlas: Atlas) -> Surveyor:
    return Surveyor(atlas, MatchingSettings(), ClosureSettings())


def test_once_everything_was_looked_at_nobody_goes_through_all_views_again() -> None:
    atlas = line(300)
    surveyor = surveyed(atlas)
    surveyor.finish()
    assert set(surveyor._looked) == set(range(300))
    surveyor._looked = asked = Counting(surveyor._looked)
    assert surveyor.work(5) == 5
    assert asked.asked <= 2
    atlas.bends += 1
    surveyor.finish()
    assert all(surveyor._looked[view] == 1 for view in range(300))


def test_views_that_waited_too_long_are_looked_at_later() -> None:
    atlas = line(1)
    surveyor = surveyed(atlas)
    surveyor.finish()
    for number in range(1, 200):
        go_on(atlas)
        surveyor.look_at(number, float(number))
    surveyor.finish()
    assert set(surveyor._looked) == set(range(200))


@pytest.mark.parametrize(("fresh", "straightened"), [(5, 0), (40, 1)])
def test_a_large_map_is_not_solved_again_for_a_few_new_alignments(fresh: int, straightened: int) -> None:
    atlas = line(300)
    surveyor = surveyed(atlas)
    surveyor.finish()
    ends = [(a, b) for b in range(299) for a in range(b)][:1000]
    atlas.aligned |= {(a, b): Edge(a, b, Pose(STEP * (b - a)), SURE, doubted=True) for a, b in ends}
    surveyor._fresh = fresh
    surveyor.work(100)
    assert atlas.revision == straightened
    surveyor.finish()
    assert atlas.revision == 1
