"""Places that were recognised: links between views, gathered by pairs of submaps, each of which can be undone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Annotated

import numpy as np

from core.geometry import Pose, rotation
from core.message import Array
from core.setting import Meta, Section
from core.slam.map.pose_graph import GraphEdge
from core.slam.map.status import ClosureState
from core.slam.motion import Increment


@dataclass(frozen=True)
class ClosureSettings(Section):
    """Conditions under which a place counts as recognised.

    Watch:
        score: loops closed; raise it for wrong ones, lower it for missed ones
        others: loops closed; raise it for wrong ones, lower it for late ones
        near: the map after a loop; raise it for doubled walls
    """

    rival: float = 0.9  # share of the best place's score that the second best may reach
    vague: float = 0.25  # [m] sd of where the view fits nearly as well, at most: along a bare corridor it slides
    reverse: float = 0.6  # share of what the older views show here that lies on what is seen now, at least
    conflict: float = 0.1  # share of either view's points that the other looked through, at most
    agree: float = 11.34  # [χ²] squared distance up to which two links do not contradict each other; 99 % at 3 dof
    certain: float = 0.35  # [m] sd of the way between two links, at most: on a longer way anything agrees
    apart: float = 0.8  # [m] distance between views of links supporting each other, at least
    doubt: float = 3.0  # residual at which a link weighs half
    contradiction: float = 30.0  # [χ²] squared distance from which the map does not bend to a link; 3 dof
    reach: float = 0.3  # [m] distance around the expected place searched at least
    reach_per_way: float = 0.05  # [m/m] further distance per way since
    widest: float = 3.0  # [m] distance that is searched, at most
    angle: float = math.radians(4.0)  # [rad] angle around the expected heading, at least
    angle_per_way: float = math.radians(0.6)  # [rad/m] further angle per way since
    widest_angle: float = math.radians(24.0)  # [rad] angle that is searched, at most
    place_sd: float = 0.02  # [m] least sd of a link's place
    heading_sd: float = math.radians(0.4)  # [rad] least sd of a link's heading
    score: Annotated[float, Meta("", 0.1, 1, "score of the match, at least")] = 0.55
    others: Annotated[int, Meta("", 1, 20, "links that must agree with a new one, and with each other")] = 2
    near: Annotated[float, Meta("m", 0.5, 30, "distance from an older view within which its place is searched")] = 4.0


@dataclass(frozen=True, eq=False)
class Constraint:
    """A newer view matched to older ones."""

    a: int  # the older view
    b: int  # the newer view
    move: Pose  # a_from_b
    covariance: Array  # (3, 3) in the frame of a
    score: float
    stamp: float  # [s] when it was found

    @cached_property
    def edge(self) -> GraphEdge:
        """The same for the pose graph."""
        return GraphEdge(self.a, self.b, self.move, self.covariance, doubted=True)

    def forwards(self) -> Constraint:
        """The same from the older view to the newer one."""
        if self.a < self.b:
            return self
        back = inverted(self.increment)
        return Constraint(self.b, self.a, back.pose, back.covariance, self.score, self.stamp)

    @property
    def increment(self) -> Increment:
        """The same as a move from a to b."""
        return Increment(self.move, self.covariance)


@dataclass
class LoopClosure:
    """All links between two submaps; they are believed, undone and redone together."""

    id: int
    older: int  # submap
    newer: int  # submap
    next_door: bool  # the robot went from one straight to the other: no loop is closed
    links: list[Constraint] = field(default_factory=list[Constraint])
    accepted: list[Constraint] = field(default_factory=list[Constraint])
    state: ClosureState = "doubtful"
    shown: Constraint | None = None  # the one that stands for all; None: never accepted

    @property
    def holds(self) -> bool:
        """True if the map bends to it."""
        return self.state == "accepted"

    @property
    def undone(self) -> bool:
        """True if the operator undid it: then nothing is searched there any more."""
        return self.state == "undone"


def inverted(move: Increment) -> Increment:
    """The way back, as sure as the way there."""
    back = move.pose.inverse()
    onto = np.eye(3)
    onto[:2, :2] = rotation(back.heading)
    onto[:2, 2] = back.y, -back.x
    return Increment(back, onto @ move.covariance @ onto.T)


def agreement(one: Constraint, other: Constraint, way: Callable[[int, int], Increment]) -> tuple[float, float]:
    """Around the circle of two links → squared distance (3 degrees of freedom), and the sd [m] of its place.

    `way` returns the move between two views as it was driven.
    """
    circle = one.increment.then(way(one.b, other.b)).then(inverted(other.increment)).then(way(other.a, one.a))
    error = circle.pose.vector
    sd = float(np.sqrt(np.trace(circle.covariance[:2, :2]) / 2))
    return float(error @ np.linalg.solve(circle.covariance, error)), sd


def departure(link: Constraint, driven: Increment) -> float:
    """Squared distance (3 degrees of freedom) of a link from the way driven between its ends."""
    circle = link.increment.then(inverted(driven))
    error = circle.pose.vector
    return float(error @ np.linalg.solve(circle.covariance, error))


def agreeing(
    new: Constraint, others: Sequence[Constraint], way: Callable[[int, int], Increment], settings: ClosureSettings
) -> list[Constraint]:
    """The largest set of links with the new one in which all agree, if it is large and spread enough; else none.

    (Pairwise consistency, Mangelson et al., ICRA 2018; the sets are small, so they grow greedily from every pair.)
    """

    @cache
    def agree(one: Constraint, other: Constraint) -> bool:
        squared, sd = agreement(one, other, way)
        return squared < settings.agree and sd < settings.certain

    friends = [other for other in others if other.b != new.b and agree(new, other)]
    best: list[Constraint] = []
    for start in friends:
        group = [new, start]
        for other in friends:
            if other.b not in {member.b for member in group} and all(agree(other, member) for member in group[1:]):
                group.append(other)
        if len(group) > len(best):
            best = group
    places = [way(new.b, link.b).pose for link in best]
    wide = any(one.distance_to(two.x, two.y) >= settings.apart for one, two in itertools.combinations(places, 2))
    return best if len(best) > settings.others and wide else []
