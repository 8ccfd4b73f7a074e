import math
from dataclasses import replace

import numpy as np
import pytest

from core.geometry import Pose, rotation, wrap
from core.slam.map.occupancy import OccupancyGrid
from core.slam.relocalization.global_search import PoseFit, judge, same, search, search_near
from core.slam.relocalization.hypotheses import MAX_SHIFTED_SHARE, PlaceHypotheses, PlaceHypothesis
from core.slam.relocalization.search_pyramid import POOL_M, SearchPyramid, thinned
from tests.core.slam.carried_scenes import CORRIDOR, ELSEWHERE, LAB, OBLONG, anywhere, charted, finish, mapped, seen


@pytest.fixture(scope="module")
def lab() -> SearchPyramid:
    return charted(LAB)


@pytest.fixture(scope="module")
def oblong() -> SearchPyramid:
    return charted(OBLONG)


def away(pose: Pose, truth: Pose) -> tuple[float, float]:
    return truth.distance_to(pose.x, pose.y), math.degrees(abs(wrap(pose.heading - truth.heading)))


@pytest.mark.parametrize("seed", range(3))
def test_a_scan_is_found_wherever_on_the_map_it_was_taken(lab: SearchPyramid, seed: int) -> None:
    truth = anywhere(LAB, np.random.default_rng(seed))
    fits, _ = finish(search(lab, seen(LAB, truth, seed=seed)))
    distance, turned = away(fits[0].pose, truth)
    assert distance < 0.1 and turned < 2.0
    assert fits[0].score > 0.75 and fits[0].conflict < 0.1


def test_the_coarse_score_is_never_lower_than_the_fine_one(lab: SearchPyramid) -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        pose = anywhere(LAB, rng)
        points = seen(LAB, pose).points @ rotation(pose.heading).T
        place = rng.uniform(-0.5, 0.5, 2) + np.array([pose.x, pose.y])
        fine = lab.field.cells_at(points + place).mean()
        cells = np.floor(points / POOL_M).astype(int) + np.floor((place - lab.field.origin) / POOL_M).astype(int)
        inside = ((cells >= 0) & (cells < lab.bound.shape[::-1])).all(axis=1)
        coarse = lab.bound[cells[inside, 1], cells[inside, 0]].sum() / len(points)
        assert coarse >= fine - 1e-6


def test_the_work_comes_in_many_small_pieces_and_twice_the_same(lab: SearchPyramid) -> None:
    view = seen(LAB, Pose(0.5, 0.3, 1.0))
    first, pieces = finish(search(lab, view))
    again, _ = finish(search(lab, view))
    assert pieces >= 15
    assert [fit.pose for fit in first] == [fit.pose for fit in again]


def test_a_room_that_looks_the_same_when_turned_is_never_believed(oblong: SearchPyramid) -> None:
    thoughts = PlaceHypotheses(oblong)
    for step in range(5):
        pose = Pose(1.4, 1.1, 0.4 + step * math.radians(50))
        finish(thoughts.consider(seen(OBLONG, pose, seed=step)))
        assert thoughts.believed() is None
    turned = Pose(5.0, 3.0, math.pi)
    assert len(thoughts.places) == 2
    assert all(any(same(p.pose, t) for p in thoughts.places) for t in (pose, turned @ pose))
    assert thoughts.doubt() == "other places look the same"


def test_a_corridor_leaves_the_way_along_it_open() -> None:
    thoughts = PlaceHypotheses(charted(CORRIDOR))
    for step in range(3):
        pose = Pose(15.0, 0.9, 0.2 + step * math.radians(40))
        finish(thoughts.consider(seen(CORRIDOR, pose, seed=step)))
        assert thoughts.believed() is None
    assert thoughts.looseness(thoughts.places[0]) > MAX_SHIFTED_SHARE


def test_views_from_apart_are_believed_and_one_is_not(lab: SearchPyramid) -> None:
    thoughts, start = PlaceHypotheses(lab), Pose(0.5, 0.3, -2.0)
    odometry = Pose(-3.0, 8.0, 1.0)  # a frame of its own
    finish(thoughts.consider(seen(LAB, start, odometry)))
    assert thoughts.doubt() == "one view only"
    nearby = seen(LAB, start @ Pose(0.0, 0.0, math.radians(9)), odometry @ Pose(0.0, 0.0, math.radians(10)), seed=1)
    assert not thoughts.is_news(nearby)
    turned = seen(LAB, start @ Pose(0.0, 0.0, math.radians(24)), odometry @ Pose(0.0, 0.0, math.radians(25)), seed=2)
    assert thoughts.is_news(turned)
    finish(thoughts.consider(turned))
    assert thoughts.believed() is None and "one side" in thoughts.doubt()
    further = seen(LAB, start @ Pose(0.0, 0.0, math.radians(44)), odometry @ Pose(0.0, 0.0, math.radians(45)), seed=3)
    finish(thoughts.consider(further))
    believed = thoughts.believed()
    assert believed is not None
    distance, angle = away(believed.pose, start @ Pose(0.0, 0.0, math.radians(44)))
    assert distance < 0.05 and angle < 1.0


def test_views_that_the_odometry_does_not_tie_together_are_not_believed(lab: SearchPyramid) -> None:
    thoughts = PlaceHypotheses(lab)
    finish(thoughts.consider(seen(LAB, Pose(0.5, 0.3, 0.0), Pose())))
    finish(thoughts.consider(seen(LAB, Pose(0.5, 0.3, 2.0), Pose(0.0, 0.0, 0.6))))  # carried once more meanwhile
    assert thoughts.believed() is None
    assert len(thoughts.views) == 1  # the newest begins anew


def test_a_place_that_is_not_on_the_map_is_not_believed(lab: SearchPyramid) -> None:
    thoughts = PlaceHypotheses(lab)
    for step in range(5):
        pose = Pose(1.5, 1.0, step * math.radians(50))
        finish(thoughts.consider(seen(ELSEWHERE, pose, seed=step)))
        assert thoughts.believed() is None


def test_a_guess_with_any_heading_is_searched_around(lab: SearchPyramid) -> None:
    truth = Pose(0.6, 0.4, 2.1)
    fits, _ = finish(search_near(lab, seen(LAB, truth), Pose(1.1, -0.1, 0.0), 1.0, math.pi))
    distance, angle = away(fits[0].pose, truth)
    assert distance < 0.05 and angle < 1.0


def test_beams_that_go_through_walls_are_told_from_those_that_end_at_them() -> None:
    log_odds = np.zeros((60, 80), np.float32)
    log_odds[:, :] = -2.0
    log_odds[13:50, 40:42] = 3.0  # a wall across the way at x = 2.0; the last beam grazes its end
    pyramid, _ = finish(
        SearchPyramid.prepare(OccupancyGrid(revision=1, resolution=0.05, origin=np.zeros(2), log_odds=log_odds))
    )
    assert pyramid is not None
    ends = np.array([[2.02, 1.5], [1.5, 1.5], [3.0, 1.5], [2.1, 1.5], [3.0, 0.1]])
    assert pyramid.crossed(np.array([0.5, 1.5]), ends).tolist() == [False, False, True, False, False]
    assert pyramid.known(ends).tolist() == [1, -1, -1, 1, -1]


def test_no_robot_stands_where_the_map_knows_no_floor(lab: SearchPyramid) -> None:
    outside = Pose(LAB.bounds.x1 + 2.0, 0.0, 0.0)
    assert judge(lab, seen(LAB, Pose(0.5, 0.3, 0.0)), outside) is None


def test_an_empty_map_makes_no_chart() -> None:
    grid = OccupancyGrid(revision=0, resolution=0.05, origin=np.zeros(2), log_odds=np.zeros((0, 0), np.float32))
    assert finish(SearchPyramid.prepare(grid))[0] is None


def test_a_blind_view_is_found_nowhere(lab: SearchPyramid) -> None:
    view = seen(LAB, Pose(0.5, 0.3, 0.0))
    blind = type(view)(stamp=0.0, odometry=Pose(), start=view.start, points=view.points[:5], misses=np.zeros((0, 2)))
    assert finish(search(lab, blind))[0] == []
    for misses in (np.zeros((0, 2)), view.misses):
        assert judge(lab, replace(blind, points=np.zeros((0, 2)), misses=misses), Pose(0.5, 0.3, 0.0)) is None


def test_of_every_square_one_point_is_kept() -> None:
    points = np.array([[0.01, 0.01], [0.02, 0.09], [0.11, 0.01], [-0.01, 0.01], [0.01, 0.02]])
    assert thinned(points, 0.1).tolist() == [[0.01, 0.01], [0.11, 0.01], [-0.01, 0.01]]


def test_the_map_is_made_ready_from_its_cells_or_from_the_points_themselves() -> None:
    grid = mapped(OBLONG, 5)
    points = np.vstack([seen(OBLONG, Pose(1.4, 1.1, a)).points for a in (0.0, 2.0, 4.0)])
    points = np.vstack([Pose(1.4, 1.1, a).apply(seen(OBLONG, Pose(1.4, 1.1, a)).points) for a in (0.0, 2.0, 4.0)])
    for given in (None, points):
        pyramid, _ = finish(SearchPyramid.prepare(grid, given))
        assert pyramid is not None
        fit = judge(pyramid, seen(OBLONG, Pose(1.4, 1.1, 0.3), seed=5), Pose(1.42, 1.08, 0.31))
        assert fit is not None and away(fit.pose, Pose(1.4, 1.1, 0.3))[0] < 0.03


def fitted(
    pyramid: SearchPyramid, score: float, conflicts: tuple[float, ...], rival: float = 0.0, usual: float = 0.0
) -> str:
    """Why a place is not believed that views of a turn fit so well, with another place of so much of its merit."""
    thoughts = PlaceHypotheses(pyramid, usual=usual)
    poses = [Pose(0.5, 0.3, math.radians(40 * n)) for n in range(len(conflicts))]
    thoughts.views = [seen(LAB, pose, pose, seed=n) for n, pose in enumerate(poses)]
    place = PlaceHypothesis(
        tuple(PoseFit(pose, score, conflict) for pose, conflict in zip(poses, conflicts, strict=True))
    )
    other = PlaceHypothesis(tuple(PoseFit(Pose(5.0, 3.0, 0.0), rival * place.merit, 0.0) for _ in conflicts))
    thoughts.places = [place, other]
    return thoughts.doubt()


def test_a_place_must_fit_well_and_the_better_the_less_the_map_is_used_to_conflicts(lab: SearchPyramid) -> None:
    assert fitted(lab, 0.80, (0.0, 0.0, 0.0)) == ""
    assert fitted(lab, 0.71, (0.0, 0.0, 0.0)) == "the walls fit badly"
    assert fitted(lab, 0.71, (0.0, 0.0, 0.0), usual=0.03) == ""


def test_small_conflicts_of_all_views_count_together(lab: SearchPyramid) -> None:
    assert fitted(lab, 0.80, (0.036, 0.0, 0.0)) == ""
    assert fitted(lab, 0.80, (0.02, 0.02, 0.02)) == "I see through walls of the map"
    assert fitted(lab, 0.80, (0.02, 0.02, 0.02), usual=0.03) == ""


def test_a_place_with_conflicts_must_be_the_clearer_the_only_one(lab: SearchPyramid) -> None:
    assert fitted(lab, 0.80, (0.0, 0.0, 0.0), rival=0.88) == ""
    assert fitted(lab, 0.80, (0.01, 0.01, 0.01), rival=0.88) == "other places look the same"
    assert fitted(lab, 0.80, (0.01, 0.01, 0.01), rival=0.8) == ""
