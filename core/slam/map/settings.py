"""Settings of the submaps: their size, the views that are kept, and the work done in spare moments."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class SubmapSettings:
    """The scan layer's own settings; matching and closures have theirs in their own files."""

    size: float = 6.0  # [m] from a submap's origin at which it is left
    landmarks: int = 60  # in a submap at which it is left
    smallest: float = 3.0  # [m] from a submap's origin to which it is never left
    view_distance: float = 0.3  # [m] between views that are kept …
    view_turn: float = math.radians(15)  # [rad] … or this
    alike: int = 3  # views from one place and direction are enough
    crowd: int = 6  # views are enough of a submap from as near as …
    crowd_distance: float = 0.5  # [m] and with their headings within …
    crowd_turn: float = math.radians(45)  # [rad]: a map grows with what it shows, not with how long it is driven in
    contradiction: float = 0.15  # share of points that two views in a row looked through: one of them is misplaced
    lately: int = 8  # newest views that a scan is matched on …
    nearby: int = 14  # … and so many of the nearest
    return_distance: float = 1.0  # [m] from a view of a known submap at which it may be entered again
    inside: float = 1.0  # [m] from its rim that the robot must be in it then, so that it does not leave at once
    return_reach: float = 0.4  # [m] around the expected place that is searched then
    return_angle: float = math.radians(6)  # [rad]
    return_score: float = 0.6  # of the match then, at least
    return_way: float = 30.0  # [m]: a submap at the end of a longer way must have been recognised first
    pieces: float = 40.0  # small pieces of work per second of the robot's time
    most_pieces: int = 400  # with one frame
    tie_sd: float = 0.02  # [m] that a filter's pose in its submap is off, at least
    tie_heading_sd: float = math.radians(0.3)  # [rad]
