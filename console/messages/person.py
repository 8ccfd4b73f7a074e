"""Messages of the tracked person."""

from typing import Literal, cast

import msgspec
import numpy as np

from core.geometry import Ray
from core.message import Array
from core.perception.people.tracked_person import TrackedPerson

Struct = msgspec.Struct


class BodyPart(Struct):
    """One part of a person's rectangle in the picture."""

    name: Literal["head", "torso", "feet"]
    likelihood: float | None  # K_i of eq. 34; null: not in the picture
    box_px: tuple[float, float, float, float]  # left, top, right, bottom; it may reach out of the picture


class SensedBearing(Struct):
    """A bearing of a person, with the point from which they are seen or heard."""

    x_m: float  # world
    y_m: float
    azimuth_world_rad: float
    sd_rad: float


class PersonState(Struct):
    """The person whom the running command follows: by every sense alone, and by all together."""

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
    landmarks_px: list[tuple[float, float] | None]  # 33 of MediaPipe's pose; null: not seen; []: none are known
    picture_age_s: float | None
    centre_px: tuple[float, float] | None  # the rectangle's centroid
    name: str  # of the taught person to whom alone the robot comes; "": it comes to anybody


DECIMAL_DIGITS = 4
PART = Literal["head", "torso", "feet"]


def person(tracked: TrackedPerson | None, stamp: float, name: str) -> PersonState | None:
    """The person at `stamp` [s], of that name if it is known; None while nobody is looked at."""
    if tracked is None:
        return None
    x, y = np.round(tracked.position, DECIMAL_DIGITS).tolist()
    seen = tracked.rectangle
    return PersonState(
        state=tracked.state,
        age_s=round(stamp - tracked.stamp, 3),
        x_m=x,
        y_m=y,
        cov_m2=[[float(f"{value:.4g}") for value in row] for row in tracked.covariance.tolist()],
        used=list(tracked.used),
        laser=None if tracked.laser is None else _pair(*np.round(tracked.laser, DECIMAL_DIGITS).tolist()),
        camera=_bearing(tracked.camera),
        sound=_bearing(tracked.sound),
        value=None if seen is None else round(seen.value, 3),
        parts=[]
        if seen is None
        else [
            BodyPart(
                cast(PART, part.name),
                None if part.likelihood is None else round(part.likelihood, 3),
                cast(tuple[float, float, float, float], tuple(round(edge, 1) for edge in part.box)),
            )
            for part in seen.parts
        ],
        landmarks_px=[] if seen is None or seen.landmarks is None else _marks(seen.landmarks),
        picture_age_s=None if seen is None else round(stamp - tracked.rectangle_stamp, 3),
        centre_px=None if seen is None else _pair(*(round(place, 1) for place in seen.centre)),
        name=name,
    )


def _marks(landmarks: Array) -> list[tuple[float, float] | None]:
    """Landmarks (33, 2) with NaN → pixels to a tenth."""
    rows = np.round(landmarks.astype(float), 1)
    return [None if np.isnan(row).any() else _pair(*row.tolist()) for row in rows]


def _pair(first: float, second: float) -> tuple[float, float]:
    return first, second


def _bearing(ray: Ray | None) -> SensedBearing | None:
    if ray is None:
        return None
    numbers = (round(float(value), DECIMAL_DIGITS) for value in (ray.x, ray.y, ray.azimuth, ray.sd))
    return SensedBearing(*numbers)
