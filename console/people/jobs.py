"""Jobs of the worker that looks at pictures of people, and its answers."""

from __future__ import annotations

import msgspec
import numpy as np

from console.people.look_jobs import SeenLooks, ViewingCamera
from console.workers.job import Job
from console.workers.pictures import PixelPicture, UploadedPicture
from core.perception.people.enrollment import PersonImage

PersonPicture = PixelPicture | UploadedPicture


class PersonImageMessage(msgspec.Struct, frozen=True):
    """The learnt part of a picture."""

    looks: SeenLooks
    figure: bytes  # the contour, a bit for each pixel
    figure_size: tuple[int, int]  # height, width
    outline: list[list[float]]  # [pixel] of the picture
    boxes: list[tuple[float, float, float, float]]  # [pixel] left, top, right, bottom of head, torso, feet

    @classmethod
    def of(cls, found: PersonImage) -> PersonImageMessage:
        """The learnt part of a picture as it crosses."""
        return cls(
            looks=SeenLooks.of(found.looks),
            figure=np.packbits(found.figure).tobytes(),
            figure_size=(found.figure.shape[0], found.figure.shape[1]),
            outline=found.outline.tolist(),
            boxes=list(found.boxes),
        )

    @property
    def person_image(self) -> PersonImage:
        """The learnt part of a picture."""
        height, width = self.figure_size
        bits = np.unpackbits(np.frombuffer(self.figure, np.uint8), count=height * width)
        return PersonImage(
            looks=self.looks.appearance,
            figure=bits.reshape(height, width) > 0,
            outline=np.array(self.outline),
            boxes=tuple(self.boxes),
        )


class SeenBackground(msgspec.Struct, frozen=True):
    """A picture without anybody: how it is shown, and as it is kept for the others."""

    size: list[int]  # [pixel] width, height
    picture: bytes  # JPEG
    kept: PixelPicture


class SeenPerson(msgspec.Struct, frozen=True):
    """A picture of a person: how it is shown, what is wrong with it or "", and what it teaches if nothing is."""

    size: list[int]  # [pixel] width, height
    picture: bytes  # JPEG
    wrong: str
    outline: list[list[float]]
    person_image: PersonImageMessage | None


class LearntPerson(msgspec.Struct, frozen=True):
    """How a person looks."""

    looks: SeenLooks
    pictures: int  # from how many


class ReadBackground(Job[SeenBackground], frozen=True):
    """Look at a picture without anybody. Raises BadInput."""

    picture: PersonPicture


class JudgePicture(Job[SeenPerson], frozen=True):
    """Look at a picture of a person, with the background and what was learnt of them already.

    Raises BadInput where it cannot be looked at.
    """

    picture: PersonPicture
    background: PixelPicture
    taken: list[PersonImageMessage]
    camera: ViewingCamera | None = None  # of a robot, which measures the height as well
    legs_m: list[tuple[float, float]] = []  # x, y in the robot's frame: where its laser sees what may be legs


class LearnPerson(Job[LearntPerson], frozen=True):
    """Learn a person from all of their pictures. Raises BadInput."""

    name: str
    taken: list[PersonImageMessage]
