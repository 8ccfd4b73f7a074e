"""The worker that looks at pictures of people: strangers' pictures are decoded here and nowhere else."""

from dataclasses import replace

import cv2
import msgspec
import numpy as np

from console.workers.job import job
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


MAX_SIDE_PX = 640  # side of the pictures that are looked at
TOO_LIKE = "This is too like a picture that I have; take another gesture."


class PeopleWorker:
    """Remembers nothing between pictures: learnt values go back to the console, no picture stays."""

    def __init__(self) -> None:
        self._networks: PoseDetector | None = None

    @job
    def background(self, picture: PersonPicture) -> SeenBackground:
        """Look at a picture without anybody. Raises BadInput."""
        pixels = pixels_of(picture)
        check_light(pixels)
        return SeenBackground(size_of(pixels), jpeg(pixels), pixels)

    @job
    def judge(
        self,
        picture: PersonPicture,
        background: Array,
        taken: list[PersonImage],
        camera: Camera | None,
        legs_m: list[tuple[float, float]],
    ) -> SeenPerson:
        """Look at a picture of a person, with the background (H, W, 3) uint8 and what was learnt of them already.

        `camera`: of a robot, which measures the height as well; `legs_m`: x, y in the robot's frame, where its laser
        sees what may be legs. Raises BadInput where it cannot be looked at.
        """
        pixels = pixels_of(picture)
        size, shown = size_of(pixels), jpeg(pixels)
        try:
            found = person_image(pixels, background, self._landmarks, gauge_of(camera, legs_m, pixels))
        except BadInput as wrong:
            return SeenPerson(size, shown, str(wrong), outline_of(pixels, background), None)
        outline = found.outline.tolist()
        if any(too_like(found, each) for each in taken):
            return SeenPerson(size, shown, TOO_LIKE, outline, None)
        return SeenPerson(size, shown, "", outline, found)

    def _landmarks(self, pixels: Array, box: Box) -> Appearance | None:
        """The looks by the pose networks; None where these are not here, or see nobody."""
        found = find(MODEL)
        if self._networks is None and found is not None:
            self._networks = open_pose(checked_folder(found, MODEL))
        return None if self._networks is None else self._networks.looks_in(pixels, box)

    @job
    def learn(self, name: str, taken: list[PersonImage]) -> PersonProfile:
        """Learn a person from all of their pictures. Raises BadInput."""
        return learn(name, taken)


def pixels_of(picture: PersonPicture) -> Array:
    """The robot's own picture, or a stranger's JPEG or PNG → (H, W, 3) uint8, not too large. Raises BadInput."""
    if isinstance(picture, UploadedPicture):
        pixels = decode_upload(picture.content, cv2.IMREAD_COLOR)[0]
    else:
        pixels = in_colour(picture.pixels)
    factor = MAX_SIDE_PX / max(pixels.shape[:2])
    return pixels if factor >= 1 else cv2.resize(pixels, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)


def gauge_of(camera: Camera | None, legs_m: list[tuple[float, float]], pixels: Array) -> HeightGauge | None:
    """Return the gauge for the height in a robot's picture (H, W, 3); None: another camera took it."""
    if camera is None:
        return None
    scaled = replace(camera, model=camera.model.scaled(pixels.shape[1] / camera.model.width))
    return HeightGauge(camera=scaled, standers=tuple(stander_at(np.array(place)) for place in legs_m))


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
