"""The occupancy map."""

from __future__ import annotations

from core.message import Array, message


@message
class Grid:
    """The occupancy map for people, planner and export. Row 0 lies at the lowest y."""

    revision: int  # rises with every change
    resolution: float  # [m]
    origin: Array  # (2,) [m], world: the outer corner of cell [0, 0]
    log_odds: Array  # (rows, columns) float32; 0 = unknown, > 0 occupied, < 0 free
