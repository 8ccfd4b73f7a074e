"""Set-up and surroundings of drives for experiments, whatever their source."""

from dataclasses import dataclass, field
from typing import NotRequired, TypedDict

import numpy as np

from core.message import Array

PLAIN = "dead_reckoning"
FIGURED = "ekf_slam"


class DriveSetup(TypedDict):
    """The set-up of drives, as JSON."""

    through: str  # "drawn" | "sensors"
    mode: str  # the filter's form
    still_start: bool
    ids: str
    speed_m_s: float
    wheelbase_m: float
    speed_sd_m_s: float
    steer_sd_deg: float
    data: NotRequired[str | None]  # of drawn ones: the file of the draws …
    field: NotRequired[str]  # … what is seen of the room …
    range_sd_m: NotRequired[float]
    bearing_sd_deg: NotRequired[float]
    place: NotRequired[str]  # through the sensors: the simulated place …
    laser_noise: NotRequired[str]  # … and its laser


@dataclass(frozen=True)
class DriveSurroundings:
    """Surroundings to draw in the picture."""

    corners: Array = field(default_factory=lambda: np.zeros((0, 2)))  # (N, 2) [m]
    walls: Array = field(default_factory=lambda: np.zeros((0, 2, 2)))  # (W, 2, 2) [m]: ends
