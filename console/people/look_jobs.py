"""Jobs of the worker that looks for people in the robot's pictures, and its answers."""

from __future__ import annotations

from dataclasses import fields

import msgspec
import numpy as np

from console.workers.job import Job
from console.workers.pictures import PixelPicture
from core.geometry import Transform
from core.message import Array
from core.optics import CameraModel
from core.perception.people.appearance import Appearance
from core.perception.people.body import Box
from core.perception.people.detector import Rectangle, SeenPart
from core.perception.people.looking import LookQuestion
from core.perception.people.parts import PeopleSettings
from core.sensors import Camera


class ViewingCamera(msgspec.Struct, frozen=True):
    """The camera that took a picture."""

    intrinsics: dict[str, float]
    rotation: list[list[float]]  # (3, 3) robot_from_camera
    translation_m: list[float]

    @classmethod
    def of(cls, camera: Camera) -> ViewingCamera:
        """A camera as it crosses."""
        numbers = {field.name: float(getattr(camera.model, field.name)) for field in fields(CameraModel)}
        return cls(numbers, camera.mounting.rotation.tolist(), camera.mounting.translation.tolist())

    @property
    def camera(self) -> Camera:
        """The camera."""
        numbers = dict(self.intrinsics)
        width, height = round(numbers.pop("width")), round(numbers.pop("height"))
        mounting = Transform(rotation=np.array(self.rotation), translation=np.array(self.translation_m))
        return Camera(model=CameraModel(width=width, height=height, **numbers), mounting=mounting)


class SeenLooks(msgspec.Struct, frozen=True):
    """How a person looks, as it crosses and as it is stored; null: not known."""

    colours: list[list[float | None]]  # head, torso, feet: log blue, green, red, and the spread of log brightness
    proportions: list[float | None]  # log lengths of legs, arms and neck in lengths of the torso
    height_m: float | None = None

    @classmethod
    def of(cls, looks: Appearance) -> SeenLooks:
        """Looks as they cross."""
        rows = [_or_null(row) for row in np.round(looks.colours, 4)]
        return cls(rows, _or_null(np.round(looks.proportions, 4)), _or_null(np.array([round(looks.height, 3)]))[0])

    @property
    def appearance(self) -> Appearance:
        """The looks."""
        height = np.nan if self.height_m is None else self.height_m
        return Appearance(
            colours=np.array(self.colours, float), proportions=np.array(self.proportions, float), height=height
        )


class BodyPartSeen(msgspec.Struct, frozen=True):
    """One part of someone."""

    name: str
    likelihood: float | None
    box: Box


class PersonSeen(msgspec.Struct, frozen=True):
    """A person in the picture."""

    value: float
    shown: float
    distance_m: float
    bearing_rad: float
    bearing_sd_rad: float | None
    height_m: float
    parts: list[BodyPartSeen]
    box: Box
    looks: SeenLooks | None
    landmarks: list[list[float | None]] | None  # u, v [pixel]; null: not seen

    @classmethod
    def of(cls, found: Rectangle) -> PersonSeen:
        """A rectangle as it crosses."""
        return cls(
            value=found.value,
            shown=found.shown,
            distance_m=found.distance,
            bearing_rad=found.bearing,
            bearing_sd_rad=found.bearing_sd,
            height_m=found.height,
            parts=[BodyPartSeen(part.name, part.likelihood, part.box) for part in found.parts],
            box=found.box,
            looks=None if found.looks is None else SeenLooks.of(found.looks),
            landmarks=_with_gaps(found.landmarks),
        )

    @property
    def rectangle(self) -> Rectangle:
        """The rectangle."""
        left, top, right, bottom = self.box
        return Rectangle(
            value=self.value,
            shown=self.shown,
            distance=self.distance_m,
            bearing=self.bearing_rad,
            bearing_sd=self.bearing_sd_rad,
            height=self.height_m,
            parts=tuple(SeenPart(name=one.name, likelihood=one.likelihood, box=one.box) for one in self.parts),
            centre=((left + right) / 2, (top + bottom) / 2),
            box=self.box,
            looks=None if self.looks is None else self.looks.appearance,
            landmarks=None if self.landmarks is None else np.array(self.landmarks, float),
            rank=self.value,
        )


def _or_null(row: Array) -> list[float | None]:
    return [None if np.isnan(one) else one for one in row.tolist()]


def _with_gaps(rows: Array | None) -> list[list[float | None]] | None:
    """Rows with NaN → rows with null."""
    return None if rows is None else [_or_null(row) for row in rows]


class PeopleSeen(msgspec.Struct, frozen=True):
    """Everybody who was found, best first."""

    people: list[PersonSeen]
    processing_s: float


class OpenDetector(Job[str], frozen=True):
    """Open the detector that these settings name → what it is, in a sentence. Raises Unavailable, BadInput."""

    settings: PeopleSettings


class LookForPeople(Job[PeopleSeen], frozen=True):
    """Look through one picture of the robot's camera. Raises Unavailable before a detector was opened."""

    picture: PixelPicture
    camera: ViewingCamera
    bearing_rad: float | None
    sd_rad: float
    distances_m: list[float]
    on_floor: bool

    @classmethod
    def of(cls, question: LookQuestion) -> LookForPeople:
        """A question as it crosses."""
        return cls(
            picture=PixelPicture.of(question.pixels),
            camera=ViewingCamera.of(question.camera),
            bearing_rad=question.bearing,
            sd_rad=question.sd,
            distances_m=list(question.distances),
            on_floor=question.on_floor,
        )

    @property
    def question(self) -> LookQuestion:
        """The question."""
        return LookQuestion(
            pixels=self.picture.colour,
            camera=self.camera.camera,
            bearing=self.bearing_rad,
            sd=self.sd_rad,
            distances=tuple(self.distances_m),
            on_floor=self.on_floor,
        )
