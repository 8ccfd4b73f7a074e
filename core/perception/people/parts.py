"""The body in three parts, head, torso and feet, and how each is weighed (Fig. 7, eq. 34).

The paper leaves the legs out, since they move. Here they belong to the feet: a camera 16 cm above the floor sees
nothing else of a person nearer than two metres.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from core.errors import BadInput
from core.setting import Meta, Section

PIXELS_PER_METRE = 64.0  # [pixel/m] at which bodies are compared; a person of 1.75 m is 112 pixels tall
CELL_PX = 4  # side of a cell; 6.25 cm
CELLS_PER_METRE = PIXELS_PER_METRE / CELL_PX
MODEL_HEIGHT_M = 1.75  # of the model
BODY_COLUMNS = 12  # [cell] of the body's rectangle; 0.75 m
CEILING_M = 2.0  # height at which the rows of a compared view begin
VIEW_ROWS = 34  # [cell] of a compared view: from CEILING_M to a little under the floor


@dataclass(frozen=True)
class BodySegment:
    """A part of the body in cells of the rectangle: which rows and columns of the model's 1.75 m."""

    name: str
    weight: float  # in eq. 34
    top: int  # [cell] below CEILING_M
    rows: int
    columns: int  # around the axis
    core: float  # [m] width of what is surely body, for its colours
    rise: float  # share of a difference in height by which the part moves up


HEAD = BodySegment("head", 0.3, 3, 7, 8, 0.16, 1.0)  # 1.81 m to 1.38 m
TORSO = BodySegment("torso", 0.6, 9, 11, 12, 0.30, 0.75)  # 1.44 m to 0.75 m
# and the legs above them: 0.81 m to the floor and a little under it
FEET = BodySegment("feet", 0.1, 19, 14, 10, 0.30, 0.0)
PARTS = (HEAD, TORSO, FEET)
LOWEST_SHIFT, HIGHEST_SHIFT = -4, 3  # [cell] of the crown: persons from 1.50 m to 1.94 m


@dataclass(frozen=True)
class PeopleSettings(Section):
    """Criteria of a rectangle that is a person.

    Watch:
        engine: persons found in Look, and the time per picture
        model: persons found in Look, and the time per picture
        threshold: persons in Look; raise it for false ones, lower it for missed ones
        alike: strangers taken for the enrolled person (then raise it)
        nearest: persons close by that are not found
        farthest: persons far away that are not found, and the time per picture
    """

    threshold_of_feet: float = 0.8  # the same where only the feet are in the picture
    feet_with_legs: float = 0.4  # the same where the laser separates two legs there
    enough: float = 0.35  # share of the parts' weight in the picture from which `threshold` holds
    ratio: float = 1.08  # ratio of neighbouring distances
    wedge: float = 2.0  # [sd] half-width of the sector around the sound's direction that is searched
    head_half: float = 0.12  # [m] half-width of the part in which the sound must fall
    overlap: float = 0.45  # [m] rectangles nearer together are one person
    near_laser: float = 0.15  # difference of the laser's and the picture's distance, at most, as a share of it
    near_floor: float = 0.15  # [m] difference of the laser's and the picture's distance that is always allowed
    engine: Annotated[
        Literal["auto", "pose", "drawn"],
        Meta(
            meaning="detector; auto: pose networks, or the model named below, where they are here, else drawn",
            common=True,
        ),
    ] = "auto"
    model: Annotated[
        str, Meta(meaning="ONNX file of your own: YOLOv8, YOLO11, YOLOX, RTMO or MediaPipe; empty: the pose networks")
    ] = ""
    threshold: Annotated[
        float, Meta("", 0.05, 0.99, "K from which a rectangle is a person (eq. 34)", common=True)
    ] = 0.65
    alike: Annotated[
        float, Meta("", 0, 1, "probability by looks alone below which it is not the enrolled person")
    ] = 0.6
    nearest: Annotated[float, Meta("m", 0.3, 3, "nearest distance that is searched")] = 0.5
    farthest: Annotated[float, Meta("m", 1, 12, "farthest distance that is searched")] = 6.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.nearest >= self.farthest:
            raise BadInput(f"nearest must lie below farthest: {self.nearest:g} and {self.farthest:g} m.")
