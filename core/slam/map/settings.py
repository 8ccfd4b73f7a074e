"""Settings of the submaps: their size, the views that are kept, and the work done in spare moments."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from core.setting import Meta, Section


@dataclass(frozen=True)
class SubmapSettings(Section):
    """The scan layer's own settings; matching and closures have theirs in their own files."""

    size: Annotated[float, Meta("m", 1, 50, "distance from a submap's origin at which it is left")] = 6.0
    landmarks: Annotated[int, Meta("", 5, 1000, "landmarks of a submap from which it is left earlier")] = 60
    smallest: Annotated[float, Meta("m", 0, 50, "distance from a submap's origin up to which it is never left")] = 3.0
    view_distance: Annotated[float, Meta("m", 0.05, 2, "distance between views that are kept")] = 0.3
    view_turn: Annotated[
        float, Meta("rad", 0.02, 3.2, "turn between views that are kept, where the distance is shorter")
    ] = math.radians(15)
    alike: Annotated[int, Meta("", 1, 50, "views from one place in one direction that are enough")] = 3
    crowd: Annotated[
        int, Meta("", 1, 100, "views of a submap from about one place that are enough: a map does not grow with time")
    ] = 6
    crowd_distance: Annotated[float, Meta("m", 0.05, 5, "distance between such views, at most")] = 0.5
    crowd_turn: Annotated[float, Meta("rad", 0.02, 3.2, "difference of their headings, at most")] = math.radians(45)
    contradiction: Annotated[
        float, Meta("", 0.01, 1, "share of points that two successive views looked through: one is misplaced")
    ] = 0.15
    lately: Annotated[int, Meta("", 1, 100, "newest views that a scan is matched on")] = 8
    nearby: Annotated[int, Meta("", 1, 100, "nearest views that a scan is matched on, besides the newest")] = 14
    return_distance: Annotated[
        float, Meta("m", 0.1, 10, "distance to a view of a known submap at which it may be entered again")
    ] = 1.0
    inside: Annotated[
        float,
        Meta("m", 0, 10, "distance from its rim that the robot must then have, so that it does not leave at once"),
    ] = 1.0
    return_reach: Annotated[float, Meta("m", 0.05, 1.5, "distance around the expected place searched then")] = 0.4
    return_angle: Annotated[float, Meta("rad", 0.01, 1, "angle around the expected heading then")] = math.radians(6)
    return_score: Annotated[float, Meta("", 0.1, 1, "score of the match then, at least")] = 0.6
    return_way: Annotated[
        float, Meta("m", 1, 1000, "a submap at the end of a longer way must have been recognised first")
    ] = 30.0
    pieces: Annotated[float, Meta("1/s", 1, 1000, "pieces of background work per second of robot time")] = 40.0
    most_pieces: Annotated[int, Meta("", 1, 2000, "pieces of background work with one frame, at most")] = 400
    tie_sd: Annotated[float, Meta("m", 1e-4, 1, "least sd of a filter's place in its submap")] = 0.02
    tie_heading_sd: Annotated[float, Meta("rad", 1e-4, 1, "least sd of a filter's heading in it")] = math.radians(0.3)
