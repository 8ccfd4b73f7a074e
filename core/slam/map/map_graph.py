"""The map of the floor: submaps, views, how they were driven to, and which places were recognised."""

import math
from collections.abc import Iterable, Sequence
from itertools import islice

import numpy as np
import scipy

from core.geometry import Pose, rotation, wrap_all
from core.message import Array
from core.slam.map.closure import Constraint, LoopClosure, inverted
from core.slam.map.keyframe import Keyframe
from core.slam.map.pose_graph import EdgeTable, Equations, GraphEdge, Marginals, compose_covariance, whitening
from core.slam.map.submap import Submap
from core.slam.motion import Increment

# [m], [rad]: where the fine edges leave this sd between two views, a coarse edge is given this sd more; where they
# leave half of it, twice as much.
ADDED_SD = np.diag([0.06, 0.06, math.radians(1.3)])
MAX_VARIANCE = 1.0  # [m²], [rad²] of a coarse edge; one that is less certain stays as it is


def reweighted(coarse: EdgeTable, fine: EdgeTable, headings: Array) -> EdgeTable:
    """Coarse edges, believed the less the more the fine ones tell of both their ends; world headings (N,) [rad].

    C + S I S with S = ADDED_SD², I the information that both ends have from the fine edges, where a way along these
    leads from one end to the other. It goes direction by direction: along a bare corridor, where walls tell nothing,
    C remains. What is systematic in the wheels (a laser aside of where the robot turns) is in every coarse edge and
    does not average out, and the coarse edges may claim millimetres: weighed by that, they would bend the fine ones.
    """
    if not len(fine) or not len(coarse):
        return coarse
    part, information = _parts(fine, len(headings)), _information(fine, headings)
    informed, left = information[:, 2, 2] > 0.0, np.zeros_like(information)
    left[informed] = np.linalg.inv(information[informed])
    a, b = coarse.a, coarse.b
    known = (part[a] == part[b]) & (np.abs(coarse.covariances).max(axis=(1, 2)) < MAX_VARIANCE)
    rows = np.flatnonzero(known & informed[a] & informed[b])
    both = np.linalg.inv(left[a[rows]] + left[b[rows]])
    turn, own = _turns(headings[a[rows]]), coarse.covariances[rows]
    both = turn.transpose(0, 2, 1) @ both @ turn
    grown = own + ADDED_SD**2 @ both @ ADDED_SD**2
    covariances = coarse.covariances.copy()
    covariances[rows] = 0.5 * (grown + grown.transpose(0, 2, 1))
    return coarse.believed(covariances)


def _parts(fine: EdgeTable, count: int) -> Array:
    """The part (N,) that every view belongs to: from one to the other there is a way along fine edges."""
    graph = scipy.sparse.coo_matrix((np.ones(len(fine)), (fine.a, fine.b)), shape=(count, count))
    return scipy.sparse.csgraph.connected_components(graph, directed=False)[1]


def _information(fine: EdgeTable, headings: Array) -> Array:
    """Information (N, 3, 3) that each view has from its fine edges, in the world's axes."""
    roots = whitening(fine.covariances) @ _turns(headings[fine.a]).transpose(0, 2, 1)
    each = roots.transpose(0, 2, 1) @ roots
    information = np.zeros((len(headings), 3, 3))
    np.add.at(information, fine.a, each)
    np.add.at(information, fine.b, each)
    return information


def _turns(headings: Array) -> Array:
    """Headings (K,) [rad] → what turns x, y and leaves the heading (K, 3, 3)."""
    c, s, zero, one = np.cos(headings), np.sin(headings), np.zeros_like(headings), np.ones_like(headings)
    return np.array([[c, -s, zero], [s, c, zero], [zero, zero, one]]).transpose(2, 0, 1)


class GrowingTable:
    """Rows of numbers in one array, with room to spare."""

    def __init__(self, columns: int) -> None:
        self._rows = np.zeros((64, columns))
        self.count = 0

    def extend(self, rows: Iterable[Sequence[float] | Array]) -> None:
        """Rows at the end."""
        for row in rows:
            if self.count == len(self._rows):
                self._rows = np.vstack((self._rows, np.zeros_like(self._rows)))
            self._rows[self.count] = row
            self.count += 1

    @property
    def array(self) -> Array:
        """All rows (N, columns), as a copy."""
        return self._rows[: self.count].copy()


UNSURE_WAY, UNSURE_FROM = 20.0, 0.2  # [m per m], [m]: way that is added for every metre of an edge's sd above 0.2 m
MIN_EDGE_M = 0.01  # length of the shortest edge
BENT_MOVE = 0.1  # [m], [rad]: a revision that moves a view farther counts among the `bends`


class MapGraph:
    """Views are the nodes of the pose graph; a submap lies where its first view does."""

    def __init__(self) -> None:
        self.submaps: list[Submap] = []
        self.views: list[Keyframe] = []
        self.poses: list[Pose] = []  # world, one per view
        self._rows = GrowingTable(3)  # the poses again: x, y [m], heading [rad]
        self.driven: list[Increment] = []  # from every view to the next one
        self._reckoned: list[tuple[float, float, float]] = []  # the views by the driven ways alone
        self.tied: list[GraphEdge] = []  # from submaps' anchors to their views, as the filters have it
        self._homes = GrowingTable(1)  # submaps of the views
        self._edges = [GrowingTable(EdgeTable.COLUMNS) for _ in range(3)]  # driven ways, ties, alignments
        self._reaches = GrowingTable(3), GrowingTable(3)  # of the driven ways and the ties: from, to, length [m]
        self._marginals: tuple[int, Marginals] | None = None  # and the revision that they are of
        self._between: dict[tuple[int, int], LoopClosure] = {}
        self.aligned: dict[tuple[int, int], GraphEdge] = {}  # views laid on each other
        self.loop_closures: list[LoopClosure] = []
        self.revision = 0
        self.bends = 0  # revisions that have moved a view by more than BENT_MOVE

    def add(self, view: Keyframe, driven: Increment | None, tie: GraphEdge | None, pose: Pose) -> None:
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
        """Return the pose of a submap in the world."""
        anchor = self.submaps[submap].anchor
        return self.poses[anchor.id] @ anchor.local.inverse()

    def edges(self, links: Iterable[Constraint] = (), poses: Array | None = None) -> EdgeTable:
        """Everything that holds the views together, these links last.

        Driven ways and ties give way to alignments; `poses` (N, 3) of the world, if not the present ones.
        """
        ways, ties, aligned = self._edges
        ways.extend(self._step(k).row for k in range(ways.count, len(self.driven)))
        ties.extend(tie.row for tie in self.tied[ties.count :])
        aligned.extend(edge.row for edge in islice(self.aligned.values(), aligned.count, None))
        coarse = EdgeTable.of_rows(np.vstack((ways.array, ties.array)))
        fine = EdgeTable.of_rows(aligned.array)
        fine = fine.where(self.connected(fine.a, fine.b))
        headings = (self.pose_array() if poses is None else poses)[:, 2]
        return reweighted(coarse, fine, headings) + fine + EdgeTable.of(link.edge for link in links)

    def connected(self, a: Array, b: Array) -> Array:
        """Return (K,) bool: views a (K,) and b (K,) are known to lie where the map has them beside each other."""
        self._homes.extend([(view.submap,) for view in self.views[self._homes.count :]])
        homes, joined = self._homes.array[:, 0].astype(int), np.eye(len(self.submaps), dtype=bool)
        held = np.array(
            [(loop_closure.older, loop_closure.newer) for loop_closure in self.loop_closures if loop_closure.holds],
            int,
        ).reshape(-1, 2)
        joined[held[:, 0], held[:, 1]] = joined[held[:, 1], held[:, 0]] = True
        return joined[homes[a], homes[b]]

    def _step(self, number: int) -> GraphEdge:
        way = self.driven[number]
        return GraphEdge(number, number + 1, way.pose, way.covariance)

    def links(self) -> list[Constraint]:
        """Return the links of all loop closures that hold."""
        return [link for loop_closure in self.loop_closures if loop_closure.holds for link in loop_closure.accepted]

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
        ways.extend([_reach(self._step(k)) for k in range(ways.count, len(self.driven))])
        ties.extend([_reach(tie) for tie in self.tied[ties.count :]])
        links = self.links()
        linked = np.array(([link.a for link in links], [link.b for link in links], [MIN_EDGE_M] * len(links)))
        a, b, lengths = np.hstack((ways.array.T, ties.array.T, linked))
        count, shortest = len(self.views), np.argsort(lengths, kind="stable")
        # of several edges between two views the shortest one: a sparse matrix would add them up
        pairs, first = np.unique((a * count + b)[shortest].astype(int), return_index=True)
        graph = scipy.sparse.csr_matrix((lengths[shortest[first]], divmod(pairs, count)), shape=(count, count))
        return scipy.sparse.csgraph.dijkstra(graph, directed=False, indices=view, limit=limit)

    def spread_of(self, submap: int) -> Array:
        """Covariance (3, 3) of a submap's place in the world."""
        anchor = self.submaps[submap].anchor
        if not anchor.id:
            return np.zeros((3, 3))
        known = self._marginals
        if known is None or known[0] != self.revision or anchor.id >= known[1].count:
            equations = Equations(self.edges(self.links()), len(self.views))
            known = self._marginals = self.revision, Marginals(equations.order, equations.at(self.pose_array())[0])
        covariance = known[1].at(anchor.id)
        return compose_covariance(self.poses[anchor.id], covariance, anchor.local.inverse(), np.zeros((3, 3)))

    def loop_closure(self, one: int, other: int) -> LoopClosure:
        """Return the loop closure between two submaps; it is made where there was none."""
        known = self.closure_between(one, other)
        if known is not None:
            return known
        older, newer = min(one, other), max(one, other)
        self.loop_closures.append(LoopClosure(len(self.loop_closures) + 1, older, newer, newer == older + 1))
        return self.loop_closures[-1]

    def closure_between(self, one: int, other: int) -> LoopClosure | None:
        """Return the loop closure between two submaps, if there is one."""
        if len(self._between) != len(self.loop_closures):
            self._between = {
                (loop_closure.older, loop_closure.newer): loop_closure for loop_closure in self.loop_closures
            }
        return self._between.get((min(one, other), max(one, other)))

    def bent(self, poses: Array) -> Array:
        """World poses (K, 3) of the first views → those (N, 3) of all; the later ones follow the last of these."""
        follow = Pose(*poses[-1].tolist()) @ self.poses[len(poses) - 1].inverse()
        later = [follow @ pose for pose in self.poses[len(poses) :]]
        return np.vstack((poses, np.array([pose.vector for pose in later]).reshape(-1, 3)))

    def revise(self, poses: Array, marginals: Marginals | None = None) -> None:
        """New world poses (K, 3) of the first views, the later ones follow; `marginals`: how sure they then are."""
        moved = poses - self.pose_array()[: len(poses)]
        self.bends += bool(
            np.hypot(moved[:, 0], moved[:, 1]).max() > BENT_MOVE or np.abs(wrap_all(moved[:, 2])).max() > BENT_MOVE
        )
        self.poses = [Pose(*row) for row in self.bent(poses).tolist()]
        self._rows = GrowingTable(3)
        self.revision += 1
        if marginals is not None:
            self._marginals = self.revision, marginals


def _reach(edge: GraphEdge) -> tuple[float, float, float]:
    """From, to, and how long [m] an edge counts on a way."""
    return edge.a, edge.b, max(MIN_EDGE_M, math.hypot(edge.move.x, edge.move.y)) + _detour(edge)


def _detour(edge: GraphEdge) -> float:
    """Way [m] that is as uncertain as this edge, where it is much more so than a driven way."""
    return UNSURE_WAY * max(0.0, math.sqrt(float(edge.covariance[0, 0] + edge.covariance[1, 1])) - UNSURE_FROM)
