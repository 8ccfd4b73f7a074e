"""Recognising a place: a view searched on older views, and every check that speaks against it."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np

from core.geometry import Pose, turned_covariance
from core.message import Array
from core.slam.map.closure import ClosureSettings, Constraint
from core.slam.map.keyframe import Keyframe
from core.slam.scan_matching.field_matching import ScanMatchingSettings, ambiguity, search_wide, spread
from core.slam.scan_matching.likelihood_field import LikelihoodField, Match


@dataclass(frozen=True)
class RecognizedPlace:
    """Older views around one of them, in its frame."""

    base: Keyframe
    views: tuple[tuple[Pose, Keyframe], ...]  # base_from_view; the base is among them
    field: LikelihoodField

    @staticmethod
    def of(base: Keyframe, views: Sequence[tuple[Pose, Keyframe]]) -> RecognizedPlace:
        """The base view and those around it, base_from_view."""
        points = np.vstack([pose.apply(view.points) for pose, view in views])
        return RecognizedPlace(base, tuple(views), LikelihoodField(points))


def recognise(
    view: Keyframe,
    place: RecognizedPlace,
    guess: Pose,
    reach: tuple[float, float],
    matching: ScanMatchingSettings,
    settings: ClosureSettings,
    stamp: float,
) -> Generator[None, None, Constraint | None]:
    """Search a view on a place within `reach` ([m], [rad]) of where it is thought to lie, base_from_view.

    The link, or None where nothing fits or anything speaks against it. One piece of work with every `next`.
    """
    found: list[Match] = []
    for places in search_wide(place.field, view.points, guess, *reach):
        found = places
        yield
    if not found or found[0].score < settings.score:
        return None
    if len(found) > 1 and found[1].score > settings.rival * found[0].score:
        return None
    best = found[0]
    yield
    if conflict(view, place, best.pose) > settings.conflict:
        return None
    if confirmed(view, place, best.pose) < settings.reverse:
        return None
    yield
    elsewhere = ambiguity(place.field, view.points, best)
    if float(np.linalg.eigvalsh(elsewhere)[-1]) > settings.vague**2:
        return None
    own = spread(place.field, view.points, best.pose, matching)
    own = own + np.diag([settings.place_sd**2, settings.place_sd**2, settings.heading_sd**2])
    covariance = turned_covariance(own, best.pose.heading)
    covariance[:2, :2] += elsewhere
    return Constraint(place.base.id, view.id, best.pose, covariance, best.score, stamp)


def conflict(view: Keyframe, place: RecognizedPlace, pose: Pose) -> float:
    """The larger share of points, 0..1, that one side shows where the other looked through."""
    forth, looked = 0, 0
    points = pose.apply(view.points)
    for at, older in _nearest(place, pose):
        on, through = older.judge(at.inverse().apply(points))
        forth, looked = forth + int(through.sum()), looked + int((on | through).sum())
    on, through = view.judge(_shown(place, pose))
    back = through.sum() / max(1, int((on | through).sum()))
    return float(max(forth / max(1, looked), back))


def confirmed(view: Keyframe, place: RecognizedPlace, pose: Pose) -> float:
    """Share of the older views' points within sight, 0..1, that lie on what the view shows: the match in reverse."""
    on, through = view.judge(_shown(place, pose))
    behind = ~(on | through)
    return float(on.sum() / max(1, len(on) - int(behind.sum())))


def _shown(place: RecognizedPlace, pose: Pose) -> Array:
    """Points (K, 2) of the nearest older views, in the frame of the view at `pose`."""
    return np.vstack([(pose.inverse() @ at).apply(older.points) for at, older in _nearest(place, pose)])


def _nearest(place: RecognizedPlace, pose: Pose, count: int = 3) -> list[tuple[Pose, Keyframe]]:
    return sorted(place.views, key=lambda each: each[0].distance_to(pose.x, pose.y))[:count]
