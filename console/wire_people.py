"""Who is looked at, as it goes over the sockets."""

from __future__ import annotations

from typing import Literal

import msgspec

Struct = msgspec.Struct


class BodyPart(Struct):
    """One part of somebody's rectangle in the picture."""

    name: Literal["head", "torso", "feet"]
    likelihood: float | None  # K_i of eq. 34; null: not in the picture
    box_px: tuple[float, float, float, float]  # left, top, right, bottom; it may reach out of the picture


class SensedBearing(Struct):
    """From where somebody is seen or heard in which direction."""

    x_m: float  # world
    y_m: float
    azimuth_world_rad: float
    sd_rad: float


class PersonState(Struct):
    """Who the running command looks at: by every sense alone, and by all together."""

    state: Literal["seen", "hidden"]
    age_s: float  # since something of them was measured
    x_m: float  # world, by all senses
    y_m: float
    cov_m2: list[list[float]]
    used: list[Literal["laser", "camera", "sound"]]  # in the newest measurement
    laser: tuple[float, float] | None  # [m] world: by the legs alone
    camera: SensedBearing | None
    sound: SensedBearing | None
    value: float | None  # K of eq. 34 in the newest picture with them; null: no such picture
    parts: list[BodyPart]  # in that picture
    picture_age_s: float | None
    centre_px: tuple[float, float] | None  # the rectangle's centroid
