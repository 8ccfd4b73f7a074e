"""Views in a row that look through each other's walls, and the place at which they do not."""

import math

import numpy as np

from core.geometry import Pose
from core.slam.map.keyframe import Keyframe
from core.slam.map.map_graph import MapGraph
from core.slam.scan_matching.field_matching import search_wide
from core.slam.scan_matching.likelihood_field import LikelihoodField

VIEWS_BEFORE = 9  # views before that make the place
SEARCH_REACH_M, SEARCH_ANGLE_RAD = 1.2, math.radians(36)  # around what was believed
MIN_SCORE = 0.25  # of the scan at the better place, at least: it may show much that is new


def contradiction(one: Keyframe, other: Keyframe, between: Pose) -> float:
    """Share 0..1 of the points that two views look through, `between` one_from_other; the mean of both ways."""
    shares: list[float] = []
    for first, second, pose in ((one, other, between), (other, one, between.inverse())):
        on, through = first.judge(pose.apply(second.points))
        shares.append(through.sum() / max(1, int((on | through).sum())))
    return sum(shares) / 2


def place_again(graph: MapGraph, view: Keyframe, seen: Pose) -> Pose | None:
    """Search the pose of a view, seen from the newest view of the map, around `seen`; None where it fits nowhere."""
    newest, back = graph.views[-1], graph.poses[-1].inverse()
    before = range(max(0, newest.id - VIEWS_BEFORE + 1), newest.id + 1)
    points = np.vstack([(back @ graph.poses[number]).apply(graph.views[number].points) for number in before])
    *_, found = search_wide(LikelihoodField(points), view.points, seen, SEARCH_REACH_M, SEARCH_ANGLE_RAD)
    likely = [match for match in found if match.score >= MIN_SCORE]
    best = min(likely, key=lambda match: contradiction(newest, view, match.pose) - match.score, default=None)
    return None if best is None else best.pose
