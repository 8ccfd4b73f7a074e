"""Marks of people on the map: named places as labels, zones as outlines on the floor."""

import itertools
from collections.abc import Callable

import numpy as np
from viser import LabelHandle, SceneApi

from console.scene.drawing.lines import NOTHING, Lines, joined
from console.scene.drawing.palette import CLOSURE, DOUBT
from core.message import Array
from core.navigation.places import NamedPlace
from core.navigation.zones import MapZone
from core.robots import Profile
from core.snapshot import Snapshot

HEIGHT_M = 0.015
LABEL_HEIGHT_M = 0.12
ShownMarks = tuple[tuple[NamedPlace, ...], tuple[MapZone, ...]]


class MarksOnMap:
    def __init__(self, scene: SceneApi, robot: Profile, newest: Callable[[], ShownMarks]) -> None:
        """`newest`: places and zones where they are now, from any thread."""
        self._scene, self._newest = scene, newest
        self._zones = {
            "keep_out": Lines(scene, "/zones/keep_out", CLOSURE, 3.0),
            "slow": Lines(scene, "/zones/slow", DOUBT, 3.0),
        }
        self._numbers = itertools.count(1)
        self._labels: list[LabelHandle] = []
        self._shown: ShownMarks = ((), ())

    def show(self, snapshot: Snapshot) -> None:
        """Draw what is newest, whatever the snapshot."""
        marks = self._newest()
        if all(one is other for one, other in zip(marks, self._shown, strict=True)):
            return
        self._shown = marks
        places, zones = marks
        for kind, lines in self._zones.items():
            lines.draw(outlines([zone for zone in zones if zone.kind == kind]))
        for label in self._labels:
            label.remove()
        spots = [(place.name, (place.x_m, place.y_m)) for place in places]
        spots += [(zone.name, tuple(zone.points.mean(axis=0))) for zone in zones]
        self._labels = [
            self._scene.add_label(f"/marks/{next(self._numbers)}", name, position=(x, y, LABEL_HEIGHT_M))
            for name, (x, y) in spots
        ]


def outlines(zones: list[MapZone]) -> Array:
    """Zones → the segments (N, 2, 3) [m] around them."""
    rings = [joined(np.vstack((zone.points, zone.points[:1])), HEIGHT_M) for zone in zones]
    return np.concatenate([NOTHING, *rings])
