"""What is done with every scan does not grow with the map."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from core.geometry import Pose
from core.perception.landmarks.frame_perception import Beams
from core.slam.loop_closure import loop_closer
from core.slam.loop_closure.loop_closer import LoopCloser
from core.slam.map import map_graph as atlas_module
from core.slam.map.closure import ClosureSettings, Constraint
from core.slam.map.keyframe import keyframe
from core.slam.map.map_graph import MapGraph, reweighted
from core.slam.map.pose_graph import EdgeTable, GraphEdge
from core.slam.map.submap import Submap
from core.slam.motion import Increment
from core.slam.scan_matching.field_matching import ScanMatchingSettings

STEP, SURE = 0.5, np.diag([1e-4, 1e-4, 1e-5])
ENDS, HITS = np.array([(2.0, -0.1), (2.0, 0.0), (2.0, 0.1)]), np.ones(3, bool)
PER_SUBMAP = 50


def go_on(graph: MapGraph) -> None:
    """One view more, straight ahead; a new submap where it is time to."""
    number = len(graph.views)
    if number % PER_SUBMAP == 0:
        graph.submaps.append(Submap(len(graph.submaps)))
    submap = len(graph.submaps) - 1
    local = Pose(STEP * (number % PER_SUBMAP))
    view = keyframe(number, submap, float(number), local, Beams(ends=ENDS, hits=HITS))
    driven = Increment(Pose(STEP), SURE) if number else None
    anchor = submap * PER_SUBMAP
    tie = GraphEdge(anchor, number, local, SURE) if number > anchor else None
    graph.add(view, driven, tie, Pose(STEP * number))


def line(views: int) -> MapGraph:
    graph = MapGraph()
    for _ in range(views):
        go_on(graph)
    return graph


def counted(monkeypatch: pytest.MonkeyPatch, name: str) -> list[int]:
    """How often something of the atlas's module is called from now on."""
    calls, real = [0], getattr(atlas_module, name)

    def call(*given: Any) -> Any:
        calls[0] += 1
        return real(*given)

    monkeypatch.setattr(atlas_module, name, call)
    return calls


def test_ways_are_measured_near_by_and_every_edge_once(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = line(400)
    graph.ways_from(399, 30.0)
    calls = counted(monkeypatch, "_reach")
    go_on(graph)
    ways = graph.ways_from(400, 30.0)
    assert calls[0] <= 2
    assert ways[400] == 0.0 and ways[399] == pytest.approx(STEP) and ways[360] == pytest.approx(20.0)
    assert math.isinf(ways[300]) and len(ways) == 401


def test_a_second_edge_between_two_views_makes_no_way_longer() -> None:
    graph = line(40)
    before = graph.ways_from(39, 30.0)
    for view in range(1, 40):
        step = graph._step(view - 1)
        graph.tied.append(replace(step, move=Pose(2 * step.move.x, 0.0, 0.0)))
    assert np.array_equal(graph.ways_from(39, 30.0), before), "the longer one counts for nothing"
    graph.tied.extend(replace(graph._step(view - 1), move=Pose(STEP / 2, 0.0, 0.0)) for view in range(1, 40))
    assert np.allclose(graph.ways_from(39, 30.0), before / 2), "the shorter one is the way"


def test_the_graph_is_factored_once_for_the_places_of_all_submaps(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = line(400)
    calls = counted(monkeypatch, "Marginals")
    spreads = [np.trace(graph.spread_of(submap)) for submap in (1, 3, 5, 3, 1)]
    assert calls[0] == 1
    assert 0 < spreads[0] == spreads[4] < spreads[1] == spreads[3] < spreads[2]
    go_on(graph)  # the first of a submap that the graph was not factored with
    graph.spread_of(8)
    assert calls[0] == 2
    graph.revise(graph.pose_array())
    graph.spread_of(1)
    assert calls[0] == 3


def test_edges_are_those_of_all_that_was_added_and_of_alignments_that_hold() -> None:
    graph = line(120)
    loop_closure = graph.loop_closure(0, 2)
    pairs = [(3, 9), (3, 110), (60, 70), (3, 60)]
    for number, (a, b) in enumerate(pairs):
        graph.aligned[a, b] = GraphEdge(a, b, Pose(STEP * (b - a), 0.01 * number, 0.02), SURE, doubted=True)
        graph.edges()
        go_on(graph)
    for state, held in (("doubtful", [(3, 9), (60, 70)]), ("accepted", [(3, 9), (3, 110), (60, 70)])):
        loop_closure.state = state
        link = Constraint(5, 115, Pose(55.0, 0.1, 0.2), 2 * SURE, 0.8, 0.0)
        told, fine = graph.edges([link]), [graph.aligned[pair] for pair in held]
        way = [GraphEdge(k, k + 1, move.pose, move.covariance) for k, move in enumerate(graph.driven)]
        coarse = reweighted(EdgeTable.of(way + graph.tied), EdgeTable.of(fine), graph.pose_array()[:, 2])
        wanted = coarse + EdgeTable.of(fine) + EdgeTable.of([link.edge])
        for name in ("a", "b", "moves", "covariances", "doubted"):
            assert np.array_equal(getattr(told, name), getattr(wanted, name)), name
        assert graph.connected(*np.array(pairs).T).tolist() == [pair in held for pair in pairs]


def test_poses_are_told_as_they_are_now() -> None:
    graph = line(70)
    graph.pose_array()[:] = 7.0
    go_on(graph)
    assert graph.pose_array()[:, 0] == pytest.approx(STEP * np.arange(71))
    graph.revise(np.add(graph.pose_array(), (1.0, 0.0, 0.0)))
    go_on(graph)
    assert graph.pose_array()[:71, 0] == pytest.approx(1.0 + STEP * np.arange(71))


class Counting(dict[int, int]):
    """Counts how often it is asked."""

    asked = 0

    def get(self, *given: Any) -> Any:
        self.asked += 1
        return super().get(*given)


def surveyed(graph: MapGraph) -> LoopCloser:
    return LoopCloser(graph, ScanMatchingSettings(), ClosureSettings())


def test_once_everything_was_looked_at_nobody_goes_through_all_views_again() -> None:
    graph = line(300)
    surveyor = surveyed(graph)
    surveyor.finish()
    assert set(surveyor._looked) == set(range(300))
    surveyor._looked = asked = Counting(surveyor._looked)
    assert surveyor.work(5) == 5
    assert asked.asked <= 2
    graph.bends += 1
    surveyor.finish()
    assert all(surveyor._looked[view] == 1 for view in range(300))


def test_views_that_waited_too_long_are_looked_at_later() -> None:
    graph = line(1)
    surveyor = surveyed(graph)
    surveyor.finish()
    for number in range(1, 200):
        go_on(graph)
        surveyor.look_at(number, float(number))
    surveyor.finish()
    assert set(surveyor._looked) == set(range(200))


@pytest.mark.parametrize(("fresh", "straightened"), [(5, 0), (40, 1)])
def test_a_large_map_is_not_solved_again_for_a_few_new_alignments(fresh: int, straightened: int) -> None:
    graph = line(300)
    surveyor = surveyed(graph)
    surveyor.finish()
    ends = [(a, b) for b in range(299) for a in range(b)][:1000]
    graph.aligned |= {(a, b): GraphEdge(a, b, Pose(STEP * (b - a)), SURE, doubted=True) for a, b in ends}
    surveyor._fresh = fresh
    surveyor.work(100)
    assert graph.revision == straightened
    surveyor.finish()
    assert graph.revision == 1


def test_after_straightening_it_is_known_how_sure_all_places_are(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = line(300)
    surveyor = surveyed(graph)
    surveyor.finish()
    surveyor._crooked = True
    surveyor.finish()
    assert graph.revision == 1
    calls = counted(monkeypatch, "Marginals")
    before = graph.spread_of(3)
    assert not calls[0] and before.any()
    graph._marginals = None
    assert graph.spread_of(3) == pytest.approx(before, rel=1e-9)
    assert calls[0] == 1


def test_no_frame_carries_two_pieces_on_a_large_graph(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = line(300)
    surveyor = surveyed(graph)
    surveyor.finish()
    monkeypatch.setattr(loop_closer, "EDGES_PER_PIECE", 60)  # of about 600: a piece on them counts as ten
    surveyor._crooked, frames, pieces = True, 0, list[int]()
    while not graph.revision:
        before = surveyor._due
        assert not surveyor.work(7)
        pieces.append((before + 7 - surveyor._due) // surveyor._size)
        frames += 1
    assert max(pieces) == 1
    assert frames >= 8
