"""From an atlas to a saved map, and back."""

from __future__ import annotations

import dataclasses

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.message import Array
from core.sensors import Laser
from core.slam.covariance import Covariance
from core.slam.ekf import EkfSlam
from core.slam.filter import ROBOT
from core.slam.floor.atlas import Atlas
from core.slam.floor.closure import Bond, Link
from core.slam.floor.keyframe import Keyframe
from core.slam.floor.pose_graph import Edge
from core.slam.floor.rooms import Parts
from core.slam.floor.saved import FORM, SavedMap
from core.slam.floor.submap import Submap
from core.slam.life import Life
from core.slam.motion import Increment
from core.slam.occupancy import OccupancyMap


def keep(atlas: Atlas, resolution: float) -> SavedMap:
    """The atlas as it is now."""
    views, links = atlas.views, [(k, link) for k, bond in enumerate(atlas.bonds) for link in bond.links]
    arrays: dict[str, Array] = {
        "view_stamps": np.array([view.stamp for view in views]),
        "view_submaps": np.array([view.submap for view in views], np.int64),
        "view_locals": _rows([view.local for view in views]),
        "view_poses": _rows(atlas.poses),
        "view_eyes": np.array([view.eye for view in views]).reshape(-1, 2),
        "view_beams": np.array([len(view.ends) for view in views], np.int64),
        "beam_ends": np.vstack([view.ends for view in views]),
        "beam_hits": np.concatenate([view.hits for view in views]),
        "driven_moves": _rows([way.pose for way in atlas.driven]),
        "driven_covariances": np.array([way.covariance for way in atlas.driven]).reshape(-1, 3, 3),
        "tied_ends": np.array([(tie.a, tie.b) for tie in atlas.tied], np.int64).reshape(-1, 2),
        "tied_moves": _rows([tie.move for tie in atlas.tied]),
        "tied_covariances": np.array([tie.covariance for tie in atlas.tied]).reshape(-1, 3, 3),
        "link_ends": np.array([(k, link.a, link.b) for k, link in links], np.int64).reshape(-1, 3),
        "link_moves": _rows([link.move for _, link in links]),
        "link_covariances": np.array([link.covariance for _, link in links]).reshape(-1, 3, 3),
        "link_scores": np.array([(link.score, link.stamp) for _, link in links]).reshape(-1, 2),
    }
    for submap in atlas.submaps:
        arrays |= _room(submap)
    facts = {
        "form": FORM,
        "resolution_m": resolution,
        "landmarks": [[dataclasses.asdict(row) for row in submap.slam.table.rows] for submap in atlas.submaps],
        "bonds": [_words(bond) for bond in atlas.bonds],
    }
    return SavedMap(arrays=arrays, facts=facts)


def restore(saved: SavedMap, atlas: Atlas, parts: Parts, laser: Laser | None) -> None:
    """Fill an empty atlas with a saved map. Raises BadInput where it does not suit the present settings."""
    arrays, facts = saved.arrays, saved.facts
    if abs(facts["resolution_m"] - parts.occupancy.resolution) > 1e-9:
        raise BadInput(f"The map has cells of {facts['resolution_m']:g} m; set occupancy.resolution to that.")
    for number, rows in enumerate(facts["landmarks"]):
        slam = EkfSlam(parts.ekf, parts.motion, laser)
        _refill(slam, arrays, number)
        slam.resume([Life(**row) for row in rows])
        tile = OccupancyMap(parts.occupancy)
        try:
            tile.lay(arrays[f"origin_{number}"], arrays[f"tile_{number}"])
        except ValueError as trouble:
            raise BadInput(f"The map cannot be used with these settings: {trouble}.") from None
        atlas.submaps.append(Submap(number, slam, tile))
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
        atlas.add(view, driven, None, _pose(arrays["view_poses"][number]))
    ties = zip(arrays["tied_ends"].tolist(), arrays["tied_moves"], arrays["tied_covariances"], strict=True)
    atlas.tied.extend(Edge(a, b, _pose(move), covariance) for (a, b), move, covariance in ties)
    _bind(saved, atlas)


def _bind(saved: SavedMap, atlas: Atlas) -> None:
    """The bonds with their links."""
    arrays = saved.arrays
    links: list[list[Link]] = [[] for _ in saved.facts["bonds"]]
    for (bond, a, b), move, covariance, (score, stamp) in zip(
        arrays["link_ends"].tolist(),
        arrays["link_moves"],
        arrays["link_covariances"],
        arrays["link_scores"].tolist(),
        strict=True,
    ):
        links[bond].append(Link(a, b, _pose(move), covariance, score, stamp))
    for told, own in zip(saved.facts["bonds"], links, strict=True):
        atlas.bonds.append(
            Bond(
                id=told["id"],
                older=told["older"],
                newer=told["newer"],
                next_door=told["next_door"],
                links=own,
                accepted=[own[k] for k in told["accepted"]],
                state=told["state"],
                shown=None if told["shown"] is None else own[told["shown"]],
            )
        )


def _words(bond: Bond) -> dict[str, object]:
    order = {id(link): k for k, link in enumerate(bond.links)}
    return {
        "id": bond.id,
        "older": bond.older,
        "newer": bond.newer,
        "next_door": bond.next_door,
        "state": bond.state,
        "accepted": [order[id(link)] for link in bond.accepted],
        "shown": None if bond.shown is None else order[id(bond.shown)],
    }


def _room(submap: Submap) -> dict[str, Array]:
    form, number = submap.slam.filter, submap.id
    form.settle()
    origin, tile = submap.tile.cells
    return {
        f"tile_{number}": tile.copy(),
        f"origin_{number}": np.array(origin, np.float64),
        f"places_{number}": form.places.copy(),
        f"covariance_{number}": form.covariance.dense(),
        f"pose_{number}": form.pose.vector,
    }


def _refill(slam: EkfSlam, arrays: dict[str, Array], number: int) -> None:
    """The filter's landmarks and covariance."""
    whole, form = arrays[f"covariance_{number}"], slam.filter
    form.places = arrays[f"places_{number}"].astype(np.float64)
    form.covariance = Covariance(whole[:ROBOT, :ROBOT])
    if len(form.places):
        form.covariance.append(whole[ROBOT:, :ROBOT], whole[ROBOT:, ROBOT:])
    form.pose = _pose(arrays[f"pose_{number}"])
    form.seat(_pose(arrays[f"pose_{number}"]), np.diag([1.0, 1.0, 1.0]))


def _rows(poses: list[Pose]) -> Array:
    return np.array([(pose.x, pose.y, pose.heading) for pose in poses], np.float64).reshape(-1, 3)


def _pose(row: Array) -> Pose:
    return Pose(float(row[0]), float(row[1]), float(row[2]))
