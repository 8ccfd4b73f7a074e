"""Jobs of the worker that looks at pictures of people, and its answers."""

import msgspec

from console.workers.job import Job
from core.message import Array
from core.perception.people.appearance import PersonProfile
from core.perception.people.enrollment import PersonImage
from core.sensors import Camera


class PixelPicture(msgspec.Struct, frozen=True, tag=True):
    """A picture of the robot's own camera."""

    pixels: Array  # (H, W) or (H, W, 3) uint8


class UploadedPicture(msgspec.Struct, frozen=True, tag=True):
    """A file that someone sent."""

    content: bytes


PersonPicture = PixelPicture | UploadedPicture


class SeenBackground(msgspec.Struct, frozen=True):
    """A picture without anybody: how it is shown, and as it is kept for the others."""

    size: list[int]  # [pixel] width, height
    picture: bytes  # JPEG
    kept: Array  # (H, W, 3) uint8


class SeenPerson(msgspec.Struct, frozen=True):
    """A picture of a person: how it is shown, what is wrong with it or "", and what it teaches if nothing is."""

    size: list[int]  # [pixel] width, height
    picture: bytes  # JPEG
    wrong: str
    outline: list[list[float]]
    person_image: PersonImage | None


class ReadBackground(Job[SeenBackground], frozen=True):
    """Look at a picture without anybody. Raises BadInput."""

    picture: PersonPicture


class JudgePicture(Job[SeenPerson], frozen=True):
    """Look at a picture of a person, with the background and what was learnt of them already.

    Raises BadInput where it cannot be looked at.
    """

    picture: PersonPicture
    background: Array  # (H, W, 3) uint8
    taken: list[PersonImage]
    camera: Camera | None = None  # of a robot, which measures the height as well
    legs_m: list[tuple[float, float]] = []  # x, y in the robot's frame: where its laser sees what may be legs


class LearnPerson(Job[PersonProfile], frozen=True):
    """Learn a person from all of their pictures. Raises BadInput."""

    name: str
    taken: list[PersonImage]
