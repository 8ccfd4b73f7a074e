"""The body in three parts, head, torso and feet, and how each is weighed (Fig. 7, eq. 34).

The paper leaves the legs out, since they move. Here they belong to the feet: a camera 16 cm above the floor sees
nothing else of a person nearer than two metres.
"""

from __future__ import annotations

from dataclasses import dataclass

from core.errors import BadInput

SCALE = 64.0  # [pixel/m] at which bodies are compared; a person of 1.75 m is 112 pixels tall
CELL = 4  # [pixel] side of a cell; 6.25 cm
CELLS_PER_METRE = SCALE / CELL
TALL = 1.75  # [m] of the model
COLUMNS = 12  # [cell] of the body's rectangle; 0.75 m
CEILING = 2.0  # [m] height at which the rows of a compared view begin
ROWS = 34  # [cell] of a compared view: from CEILING to a little under the floor


@dataclass(frozen=True)
class Part:
    """A part of the body in cells of the rectangle: which rows and columns of the model's 1.75 m."""

    name: str
    weight: float  # in eq. 34
    top: int  # [cell] below CEILING
    rows: int
    columns: int  # around the axis
    core: float  # [m] width of what is surely body, for its colours
    rise: float  # share of a difference in height by which the part moves up


HEAD = Part("head", 0.3, 3, 7, 8, 0.16, 1.0)  # 1.81 m to 1.38 m
TORSO = Part("torso", 0.6, 9, 11, 12, 0.30, 0.75)  # 1.44 m to 0.75 m
FEET = Part("feet", 0.1, 19, 14, 10, 0.30, 0.0)  # and the legs above them: 0.81 m to the floor and a little under it
PARTS = (HEAD, TORSO, FEET)
LOWEST_SHIFT, HIGHEST_SHIFT = -4, 3  # [cell] of the crown: persons from 1.50 m to 1.94 m


@dataclass(frozen=True)
class PeopleSettings:
    """Criteria of a rectangle that is a person."""

    threshold: float = 0.65  # of K (eq. 34)
    threshold_of_feet: float = 0.8  # of K where nothing but the feet is in the picture
    feet_with_legs: float = 0.4  # of K the same, where the laser separates two legs there
    enough: float = 0.35  # of the parts' weight in the picture, from which the first threshold holds
    alike: float = 0.5  # of the colours of torso and legs, below which it is not the one who was taught
    nearest: float = 0.5  # [m] distances that are looked at
    farthest: float = 6.0  # [m]
    ratio: float = 1.08  # between neighbouring distances
    wedge: float = 2.0  # standard deviations of the sound's direction that are looked through
    head_half: float = 0.12  # [m] half the width of the part in which the sound must fall
    overlap: float = 0.45  # [m] nearer rectangles are one person
    near_laser: float = 0.15  # share of a distance by which the laser's and the picture's may differ, and …
    near_floor: float = 0.15  # [m] … this

    def __post_init__(self) -> None:
        for name, (low, high) in BOUNDS.items():
            if not low <= getattr(self, name) <= high:
                raise BadInput(f"{name} must lie between {low:g} and {high:g}.")


BOUNDS = {
    "threshold": (0.05, 0.99),
    "threshold_of_feet": (0.05, 0.99),
    "feet_with_legs": (0.05, 0.99),
    "enough": (0.0, 1.0),
    "alike": (0.0, 1.0),
    "nearest": (0.3, 3.0),
    "farthest": (1.0, 12.0),
    "ratio": (1.02, 1.5),
    "wedge": (0.5, 4.0),
    "head_half": (0.05, 0.5),
    "overlap": (0.1, 2.0),
    "near_laser": (0.02, 1.0),
    "near_floor": (0.02, 1.0),
}
