"""The worker that looks at pictures of people, its jobs and its answers: strangers' pictures are decoded here and
nowhere else.
"""

from dataclasses import replace

import cv2
import msgspec
import numpy as np

from console.workers.job import Job
from console.workers.pictures import decode_upload, in_colour, jpeg
from core.errors import BadInput
from core.message import Array
from core.models import checked_folder, find
from core.perception.people.appearance import Appearance, PersonProfile
from core.perception.people.engines import MODEL
from core.perception.people.enrollment import (
    Box,
    HeightGauge,
    PersonImage,
    check_light,
    contour_of,
    learn,
    person_image,
    too_like,
)
from core.perception.people.legs import stander_at
from core.perception.people.pose.detector import PoseDetector, open_pose
from core.sensors import Camera


class PixelPicture(msgspec.Struct, frozen=True, tag=True):
    pixels: Array  # (H, W) or (H, W, 3) uint8


class UploadedPicture(msgspec.Struct, frozen=True, tag=True):
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


MAX_SIDE_PX = 640  # side of the pictures that are looked at
TOO_LIKE = "This is too like a picture that I have; take another gesture."


class PeopleWorker:
    """Remembers nothing between pictures: learnt values go back to the console, no picture stays."""

    def __init__(self) -> None:
        self._networks: PoseDetector | None = None

    def background(self, job: ReadBackground) -> SeenBackground:
        pixels = pixels_of(job.picture)
        check_light(pixels)
        return SeenBackground(size_of(pixels), jpeg(pixels), pixels)

    def judge(self, job: JudgePicture) -> SeenPerson:
        pixels, empty = pixels_of(job.picture), job.background
        size, picture = size_of(pixels), jpeg(pixels)
        try:
            found = person_image(pixels, empty, self._landmarks, gauge_of(job, pixels))
        except BadInput as wrong:
            return SeenPerson(size, picture, str(wrong), outline_of(pixels, empty), None)
        outline = found.outline.tolist()
        if any(too_like(found, each) for each in job.taken):
            return SeenPerson(size, picture, TOO_LIKE, outline, None)
        return SeenPerson(size, picture, "", outline, found)

    def _landmarks(self, pixels: Array, box: Box) -> Appearance | None:
        """The looks by the pose networks; None where these are not here, or see nobody."""
        found = find(MODEL)
        if self._networks is None and found is not None:
            self._networks = open_pose(checked_folder(found, MODEL))
        return None if self._networks is None else self._networks.looks_in(pixels, box)

    def learn(self, job: LearnPerson) -> PersonProfile:
        return learn(job.name, job.taken)


def pixels_of(picture: PersonPicture) -> Array:
    """The robot's own picture, or a stranger's JPEG or PNG → (H, W, 3) uint8, not too large. Raises BadInput."""
    if isinstance(picture, UploadedPicture):
        pixels = decode_upload(picture.content, cv2.IMREAD_COLOR)[0]
    else:
        pixels = in_colour(picture.pixels)
    factor = MAX_SIDE_PX / max(pixels.shape[:2])
    return pixels if factor >= 1 else cv2.resize(pixels, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)


def gauge_of(job: JudgePicture, pixels: Array) -> HeightGauge | None:
    """Return the gauge for the height in a robot's picture (H, W, 3); None: another camera took it."""
    if job.camera is None:
        return None
    model = job.camera.model
    camera = replace(job.camera, model=model.scaled(pixels.shape[1] / model.width))
    return HeightGauge(camera=camera, standers=tuple(stander_at(np.array(place)) for place in job.legs_m))


def size_of(pixels: Array) -> list[int]:
    """Width and height [pixel]."""
    return [pixels.shape[1], pixels.shape[0]]


def outline_of(pixels: Array, background: Array) -> list[list[float]]:
    """The contour of a figure that was not good enough, so that one sees why; none where there is none."""
    try:
        mask = contour_of(pixels, background).astype(np.uint8)
    except BadInput:
        return []
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    return cv2.approxPolyDP(max(outlines, key=len), 1.0, closed=True)[:, 0].tolist()
