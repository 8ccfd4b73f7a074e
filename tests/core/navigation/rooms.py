"""Maps drawn by hand for the planner."""

import numpy as np

from core.slam.map.occupancy import OccupancyGrid

NO_SCAN = np.zeros((0, 2))


def room(rows: list[str], resolution: float = 0.05, every: float = 0.25) -> OccupancyGrid:
    """A map from text, top row = highest y, one letter = `every` metres: # wall, . free, space unknown."""
    cell = round(every / resolution)
    values = {"#": 4.0, ".": -4.0, " ": 0.0}
    letters = np.array([[values[letter] for letter in row] for row in rows[::-1]], np.float32)
    return OccupancyGrid(
        revision=1, resolution=resolution, origin=np.zeros(2), log_odds=np.kron(letters, np.ones((cell, cell)))
    )
