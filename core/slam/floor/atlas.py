"""The map of the floor: submaps, views, how they were driven to, and which places were recognised."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from core.geometry import Pose, rotation, wrap_all
from core.message import Array
from core.slam.floor.closure import Bond, Link, inverted
from core.slam.floor.easing import eased
from core.slam.floor.growing import GrowingTable
from core.slam.floor.keyframe import Keyframe
from core.slam.floor.pose_graph import Edge, Marginals, compose_covariance
from core.slam.floor.submap import Submap
from core.slam.motion import Increment

UNSURE_WAY, UNSURE_FROM = 20.0, 0.2  # [m per m], [m]: sd of an edge beyond which it counts as a longer way
SHORTEST = 0.01  # [m] that an edge counts at least
BENT = 0.1  # [m], [rad] that a view must have moved for that


class Atlas:
    """Views are the nodes of the pose graph; a submap lies where its first view does."""

    def __init__(self) -> None:
        self.submaps: list[Submap] = []
        self.views: list[Keyframe] = []
        self.poses: list[Pose] = []  # world, one per view
        self._rows = GrowingTable(3)  # the same as an array
        self.driven: list[Increment] = []  # from every view to the next one
        self._reckoned: list[tuple[float, float, float]] = []  # the views by the driven ways alone
        self.tied: list[Edge] = []  # from submaps' anchors to their views, as the filters have it
        self._reaches = GrowingTable(3), GrowingTable(3)  # of the driven ways and the ties: from, to, length [m]
        self._marginals: tuple[int, Marginals] | None = None  # and the revision that they are of
        self._between: dict[tuple[int, int], Bond] = {}
        self.aligned: dict[tuple[int, int], Edge] = {}  # views laid on each other
        self.bonds: list[Bond] = []
        self.revision = 0
        self.bends = 0  # revisions that have moved anything so far that a second look is worth it

    def add(self, view: Keyframe, driven: Increment | None, tie: Edge | None, pose: Pose) -> None:
        """A new view at a world pose; `driven` from the newest one, `tie` from an anchor."""
        self.views.append(view)
        self.poses.append(pose)
        self.submaps[view.submap].views.append(view)
        if driven is not None:
            self.driven.append(driven)
            pose = Pose(*self._reckoned[-1]) @ driven.pose
        self._reckoned.append((pose.x, pose.y, pose.heading))
        if tie is not None:
            self.tied.append(tie)

    def world_from(self, submap: int) -> Pose:
        """Where a submap lies."""
        anchor = self.submaps[submap].anchor
        return self.poses[anchor.id] @ anchor.local.inverse()

    def edges(self, links: Iterable[Link] = (), fine: bool = True) -> list[Edge]:
        """Everything that holds the views together, and these links.

        `fine`: those of alignments too; driven ways and ties then give way to them.
        """
        way = [Edge(k, k + 1, move.pose, move.covariance) for k, move in enumerate(self.driven)]
        coarse, closures = way + self.tied, [link.edge for link in links]
        if not fine:
            return coarse + closures
        aligned = [edge for (a, b), edge in self.aligned.items() if self.connected(a, b)]
        return eased(coarse, aligned, np.array([pose.heading for pose in self.poses])) + aligned + closures

    def connected(self, a: int, b: int) -> bool:
        """Whether two views are known to lie where the map has them beside each other."""
        one, other = self.views[a].submap, self.views[b].submap
        if one == other:
            return True
        bond = self.bond_between(one, other)
        return bond is not None and bond.holds

    def links(self) -> list[Link]:
        """The links of all bonds that hold."""
        return [link for bond in self.bonds if bond.holds for link in bond.accepted]

    def pose_array(self) -> Array:
        """World poses (N, 3) of all views."""
        self._rows.extend([(pose.x, pose.y, pose.heading) for pose in self.poses[self._rows.count :]])
        return self._rows.array

    def way(self, a: int, b: int) -> Increment:
        """From view a to view b as it was driven, no recognised place in between.

        The same as all steps composed one after the other: a step's error turns what comes after it.
        """
        if a > b:
            return inverted(self.way(b, a))
        if a == b:
            return Increment()
        reckoned, steps = np.array(self._reckoned[a : b + 1]), np.array([way.covariance for way in self.driven[a:b]])
        start = Pose(*reckoned[0].tolist())
        move = start.inverse() @ Pose(*reckoned[-1].tolist())
        arms = (reckoned[-1, :2] - reckoned[1:, :2]) @ rotation(start.heading)
        turned = reckoned[:-1, 2] - reckoned[0, 2]
        c, s, none, one = np.cos(turned), np.sin(turned), np.zeros(b - a), np.ones(b - a)
        carry = np.array([[c, -s, -arms[:, 1]], [s, c, arms[:, 0]], [none, none, one]]).transpose(2, 0, 1)
        return Increment(move, np.einsum("kij,kjl,kml->im", carry, steps, carry))

    def ways_from(self, view: int, limit: float) -> Array:
        """Length [m] of the shortest way to every view (N,) along what holds the views together.

        Infinite where it is longer than `limit` [m]: so far off nothing is looked at.
        """
        ways, ties = self._reaches
        driven = enumerate(self.driven[ways.count :], ways.count)
        ways.extend([_reach(Edge(k, k + 1, move.pose, move.covariance)) for k, move in driven])
        ties.extend([_reach(tie) for tie in self.tied[ties.count :]])
        linked = np.array([(link.a, link.b, SHORTEST) for link in self.links()]).reshape(-1, 3)
        a, b, lengths = np.vstack((ways.array, ties.array, linked)).T
        graph = sparse.csr_matrix((lengths, (a.astype(int), b.astype(int))), shape=(len(self.views), len(self.views)))
        return csgraph.dijkstra(graph, directed=False, indices=view, limit=limit)

    def spread_of(self, submap: int) -> Array:
        """Covariance (3, 3) of a submap's place in the world."""
        anchor = self.submaps[submap].anchor
        if not anchor.id and not anchor.local.vector.any():
            return np.zeros((3, 3))
        known = self._marginals
        if known is None or known[0] != self.revision or anchor.id >= known[1].count:
            known = self._marginals = self.revision, Marginals(self.pose_array(), self.edges(self.links()))
        covariance = known[1].at(anchor.id)
        return compose_covariance(self.poses[anchor.id], covariance, anchor.local.inverse(), np.zeros((3, 3)))

    def bond(self, one: int, other: int) -> Bond:
        """The bond between two submaps, made where there was none."""
        known = self.bond_between(one, other)
        if known is not None:
            return known
        older, newer = min(one, other), max(one, other)
        self.bonds.append(Bond(len(self.bonds) + 1, older, newer, newer == older + 1))
        return self.bonds[-1]

    def bond_between(self, one: int, other: int) -> Bond | None:
        """The bond between two submaps, if there is one."""
        if len(self._between) != len(self.bonds):
            self._between = {(bond.older, bond.newer): bond for bond in self.bonds}
        return self._between.get((min(one, other), max(one, other)))

    def revise(self, poses: Array, count: int) -> None:
        """New world poses (count, 3) of the first views; the later ones follow the last of these."""
        follow = Pose(*poses[-1].tolist()) @ self.poses[count - 1].inverse()
        later = [follow @ pose for pose in self.poses[count:]]
        moved = poses - self.pose_array()[:count]
        self.bends += bool(
            np.hypot(moved[:, 0], moved[:, 1]).max() > BENT or np.abs(wrap_all(moved[:, 2])).max() > BENT
        )
        self.poses = [Pose(*row) for row in poses.tolist()] + later
        self._rows = GrowingTable(3)
        self.revision += 1


def _reach(edge: Edge) -> tuple[float, float, float]:
    """From, to, and how long [m] an edge counts on a way."""
    return edge.a, edge.b, max(SHORTEST, math.hypot(edge.move.x, edge.move.y)) + _detour(edge)


def _detour(edge: Edge) -> float:
    """Way [m] that is as uncertain as this edge, where it is much more so than a driven way."""
    return UNSURE_WAY * max(0.0, math.sqrt(float(edge.covariance[0, 0] + edge.covariance[1, 1])) - UNSURE_FROM)
