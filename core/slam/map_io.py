"""From a map graph to a saved map, and back."""

from copy import deepcopy

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.message import Array
from core.sensors import Laser
from core.slam.ekf.covariance import Covariance
from core.slam.ekf.filter import POSE_SIZE
from core.slam.map.closure import Constraint, LoopClosure
from core.slam.map.keyframe import Keyframe
from core.slam.map.map_file import FORM_NUMBER, MapFacts, SavedClosure, SavedMap
from core.slam.map.map_graph import MapGraph
from core.slam.map.pose_graph import GraphEdge
from core.slam.map.submap import Submap
from core.slam.motion import Increment
from core.slam.submap_manager import MapperSettings


def keep(graph: MapGraph, resolution: float) -> SavedMap:
    """Return the map as it is now."""
    views, links = (
        graph.views,
        [(k, link) for k, loop_closure in enumerate(graph.loop_closures) for link in loop_closure.links],
    )
    arrays: dict[str, Array] = {
        "view_stamps": np.array([view.stamp for view in views]),
        "view_submaps": np.array([view.submap for view in views], np.int64),
        "view_locals": _rows([view.local for view in views]),
        "view_poses": _rows(graph.poses),
        "view_eyes": np.array([view.eye for view in views]).reshape(-1, 2),
        "view_beams": np.array([len(view.ends) for view in views], np.int64),
        "beam_ends": np.vstack([view.ends for view in views]),
        "beam_hits": np.concatenate([view.hits for view in views]),
        "driven_moves": _rows([way.pose for way in graph.driven]),
        "driven_covariances": np.array([way.covariance for way in graph.driven]).reshape(-1, 3, 3),
        "tied_ends": np.array([(tie.a, tie.b) for tie in graph.tied], np.int64).reshape(-1, 2),
        "tied_moves": _rows([tie.move for tie in graph.tied]),
        "tied_covariances": np.array([tie.covariance for tie in graph.tied]).reshape(-1, 3, 3),
        "link_ends": np.array([(k, link.a, link.b) for k, link in links], np.int64).reshape(-1, 3),
        "link_moves": _rows([link.move for _, link in links]),
        "link_covariances": np.array([link.covariance for _, link in links]).reshape(-1, 3, 3),
        "link_scores": np.array([(link.score, link.stamp) for _, link in links]).reshape(-1, 2),
    }
    for submap in graph.submaps:
        arrays |= _submap(submap)
    facts = MapFacts(
        form=FORM_NUMBER,
        resolution_m=resolution,
        landmarks=[submap.table.records for submap in graph.submaps],
        closures=[_saved(loop_closure) for loop_closure in graph.loop_closures],
    )
    return SavedMap(arrays=arrays, facts=facts)


def is_of_drive(saved: SavedMap, graph: MapGraph) -> bool:
    """Return whether a saved map begins with the very view that this one begins with: one drive, the same axes."""
    if not graph.views:
        return False
    first, beams = graph.views[0], int(saved.arrays["view_beams"][0])
    same = float(saved.arrays["view_stamps"][0]) == first.stamp
    return same and np.array_equal(saved.arrays["beam_ends"][:beams], first.ends, equal_nan=True)


def restore(saved: SavedMap, graph: MapGraph, parts: MapperSettings, laser: Laser | None) -> None:
    """Fill an empty map graph with a saved map. Raises BadInput where it does not suit the present settings."""
    arrays, facts = saved.arrays, saved.facts
    if abs(facts.resolution_m - parts.occupancy.resolution) > 1e-9:
        raise BadInput(f"The map has cells of {facts.resolution_m:g} m; set occupancy.resolution to that.")
    for number, rows in enumerate(facts.landmarks):
        submap = parts.new_submap(number, laser)
        _refill(submap, arrays, number)
        submap.resume(rows)
        try:
            submap.tile.load(arrays[f"origin_{number}"], arrays[f"tile_{number}"])
        except ValueError as trouble:
            raise BadInput(f"The map cannot be used with these settings: {trouble}.") from None
        graph.submaps.append(submap)
    last = np.cumsum(arrays["view_beams"])
    for number, (end, beams) in enumerate(zip(last.tolist(), arrays["view_beams"].tolist(), strict=True)):
        view = Keyframe(
            id=number,
            submap=int(arrays["view_submaps"][number]),
            stamp=float(arrays["view_stamps"][number]),
            local=_pose(arrays["view_locals"][number]),
            ends=arrays["beam_ends"][end - beams : end].astype(np.float32),
            hits=arrays["beam_hits"][end - beams : end].astype(bool),
            eye=arrays["view_eyes"][number],
        )
        driven = None
        if number:
            driven = Increment(_pose(arrays["driven_moves"][number - 1]), arrays["driven_covariances"][number - 1])
        graph.add(view, driven, None, _pose(arrays["view_poses"][number]))
    ties = zip(arrays["tied_ends"].tolist(), arrays["tied_moves"], arrays["tied_covariances"], strict=True)
    graph.tied.extend(GraphEdge(a, b, _pose(move), covariance) for (a, b), move, covariance in ties)
    _restore_closures(saved, graph)


def _restore_closures(saved: SavedMap, graph: MapGraph) -> None:
    arrays = saved.arrays
    links: list[list[Constraint]] = [[] for _ in saved.facts.closures]
    for (loop_closure, a, b), move, covariance, (score, stamp) in zip(
        arrays["link_ends"].tolist(),
        arrays["link_moves"],
        arrays["link_covariances"],
        arrays["link_scores"].tolist(),
        strict=True,
    ):
        links[loop_closure].append(Constraint(a, b, _pose(move), covariance, score, stamp))
    for row, own in zip(saved.facts.closures, links, strict=True):
        graph.loop_closures.append(
            LoopClosure(
                id=row.id,
                older=row.older,
                newer=row.newer,
                next_door=row.next_door,
                links=own,
                accepted=[own[k] for k in row.accepted],
                state=row.state,
                shown=None if row.shown is None else own[row.shown],
            )
        )


def _saved(loop_closure: LoopClosure) -> SavedClosure:
    order = {id(link): k for k, link in enumerate(loop_closure.links)}
    return SavedClosure(
        id=loop_closure.id,
        older=loop_closure.older,
        newer=loop_closure.newer,
        next_door=loop_closure.next_door,
        state=loop_closure.state,
        accepted=[order[id(link)] for link in loop_closure.accepted],
        shown=None if loop_closure.shown is None else order[id(loop_closure.shown)],
    )


def _submap(submap: Submap) -> dict[str, Array]:
    form, number = submap.filter, submap.id
    if not form.pending.still:  # a copy settles: saving a map changes nothing of what is estimated
        form = deepcopy(form)
        form.settle()
    origin, tile = submap.tile.cells
    return {
        f"tile_{number}": tile.copy(),
        f"origin_{number}": np.array(origin, np.float64),
        f"places_{number}": form.places.copy(),
        f"covariance_{number}": form.covariance.block(0, POSE_SIZE + 2 * len(form.places)),
        f"pose_{number}": form.pose.vector,
    }


def _refill(submap: Submap, arrays: dict[str, Array], number: int) -> None:
    whole, form = arrays[f"covariance_{number}"], submap.filter
    form.points = arrays[f"places_{number}"].astype(np.float64)
    form.covariance = Covariance(whole[:POSE_SIZE, :POSE_SIZE])
    if len(form.places):
        form.covariance.append(whole[POSE_SIZE:, :POSE_SIZE], whole[POSE_SIZE:, POSE_SIZE:])
    form.pose = _pose(arrays[f"pose_{number}"])
    form.reset_pose(_pose(arrays[f"pose_{number}"]), np.diag([1.0, 1.0, 1.0]))


def _rows(poses: list[Pose]) -> Array:
    return np.array([(pose.x, pose.y, pose.heading) for pose in poses], np.float64).reshape(-1, 3)


def _pose(row: Array) -> Pose:
    return Pose(float(row[0]), float(row[1]), float(row[2]))
