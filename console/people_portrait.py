"""Who is looked at → what every viewer gets."""

from __future__ import annotations

from typing import Literal, cast

import numpy as np

from console import wire_people as wire
from core.perception.people.fusion import Ray
from core.perception.people.person import PersonSeen

DIGITS = 4
PART = Literal["head", "torso", "feet"]


def person(told: PersonSeen | None, stamp: float) -> wire.PersonState | None:
    """The person at `stamp` [s]; None while nobody is looked at."""
    if told is None:
        return None
    x, y = np.round(told.position, DIGITS).tolist()
    seen = told.rectangle
    return wire.PersonState(
        state=told.state,
        age_s=round(stamp - told.stamp, 3),
        x_m=x,
        y_m=y,
        cov_m2=[[float(f"{value:.4g}") for value in row] for row in told.covariance.tolist()],
        used=list(told.used),
        laser=None if told.laser is None else _pair(*np.round(told.laser, DIGITS).tolist()),
        camera=_bearing(told.camera),
        sound=_bearing(told.sound),
        value=None if seen is None else round(seen.value, 3),
        parts=[]
        if seen is None
        else [
            wire.BodyPart(
                cast(PART, part.name),
                None if part.likelihood is None else round(part.likelihood, 3),
                cast(tuple[float, float, float, float], tuple(round(edge, 1) for edge in part.box)),
            )
            for part in seen.parts
        ],
        picture_age_s=None if seen is None else round(stamp - told.rectangle_stamp, 3),
        centre_px=None if seen is None else _pair(*(round(place, 1) for place in seen.centre)),
    )


def _pair(first: float, second: float) -> tuple[float, float]:
    return first, second


def _bearing(ray: Ray | None) -> wire.SensedBearing | None:
    if ray is None:
        return None
    numbers = (round(float(value), DIGITS) for value in (ray.x, ray.y, ray.azimuth, ray.sd))
    return wire.SensedBearing(*numbers)
