"""The box that a floor plan is to the ear: where around the robot the walls are."""

import math

import numpy as np

from core.message import Array, message
from core.simulation.acoustics.shoebox import ShoeboxRoom
from core.simulation.world import Surfaces, World, cast

RAY_COUNT = 180
RIM_PERCENT = 8.0  # percent of the rays that may go on into niches and through doors, on either side
WALL_MARGIN_M = 0.2  # between a wall and a person or robot that speaks or listens
MAX_SIDE_M = 14.0  # of a side
NO_POSTS = np.zeros((0, 3))


@message
class Enclosure:
    """A box-shaped room in the world: its lowest corner and what is between the walls."""

    corner: Array  # (3,) [m] in the world
    room: ShoeboxRoom

    def inside(self, points: Array) -> Array:
        """Points (N, 3) [m] of the world → the same in the room's own frame."""
        return points - self.corner

    def holds(self, points: Array) -> bool:
        """Return whether points (N, 3) [m] of the world lie within the walls."""
        return self.room.holds(self.inside(points))


def enclosure(world: World, points: Array, rt60: float) -> Enclosure:
    """The box around points (N, 3) [m]: the walls as the first of them sees them, wide enough for all."""
    angles = np.arange(RAY_COUNT) * (2 * math.pi / RAY_COUNT)
    directions = np.column_stack((np.cos(angles), np.sin(angles)))
    walls = Surfaces(faces=world.walls, posts=NO_POSTS)
    reach = np.minimum(cast(points[0, :2], directions, walls).distance, MAX_SIDE_M)
    ends = points[0, :2] + reach[:, None] * directions
    low, high = np.percentile(ends, (RIM_PERCENT, 100 - RIM_PERCENT), axis=0)
    low = np.minimum(low, points[:, :2].min(0) - WALL_MARGIN_M)
    high = np.maximum(high, points[:, :2].max(0) + WALL_MARGIN_M)
    top = max(world.height, float(points[:, 2].max()) + WALL_MARGIN_M)
    return Enclosure(
        corner=np.append(low, 0.0), room=ShoeboxRoom((float(high[0] - low[0]), float(high[1] - low[1]), top), rt60)
    )


def in_sight(world: World, one: Array, other: Array) -> bool:
    """Return whether no wall stands between two points (3,) [m]; furniture does not count."""
    walls = Surfaces(faces=world.walls, posts=NO_POSTS)
    way = other[:2] - one[:2]
    return not bool((cast(one[:2], way[None], walls).distance < 1.0).any())
