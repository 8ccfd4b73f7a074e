"""Jobs of the worker that looks at pictures of people, and its answers."""

from __future__ import annotations

import msgspec
import numpy as np

from console.workers.job import Job
from console.workers.pictures import PixelPicture, UploadedPicture
from core.perception.people.enrollment import PersonImage

PersonPicture = PixelPicture | UploadedPicture


class PersonImageMessage(msgspec.Struct, frozen=True):
    """The learnt part of a picture."""

    colours: list[list[float]]  # head, torso, feet; every row sums to 1
    shape: float  # height of the contour over the width at the shoulders
    figure: bytes  # the contour, a bit for each pixel
    figure_size: tuple[int, int]  # height, width
    outline: list[list[float]]  # [pixel] of the picture
    boxes: list[tuple[float, float, float, float]]  # [pixel] left, top, right, bottom of head, torso, feet

    @classmethod
    def of(cls, found: PersonImage) -> PersonImageMessage:
        """The learnt part of a picture as it crosses."""
        return cls(
            colours=found.colours.tolist(),
            shape=found.shape,
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
            colours=np.array(self.colours),
            shape=self.shape,
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

    colours: list[list[float]]
    pictures: int  # from how many
    shape: float


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


class LearnPerson(Job[LearntPerson], frozen=True):
    """Learn a person from all of their pictures. Raises BadInput."""

    name: str
    taken: list[PersonImageMessage]
