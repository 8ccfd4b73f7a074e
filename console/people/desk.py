"""The worker that looks at pictures of people: strangers' pictures are decoded here and nowhere else."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from core.calibration.pictures import decode
from core.errors import BadInput
from core.message import Array
from core.perception.people.colours import Enrolled
from core.perception.people.enrolment import Portrait, check_light, contour_of, learn, portrait, too_like
from core.sensors import Image

LONGEST = 640  # [pixel] side of the pictures that are looked at
QUALITY = 85  # of the JPEG that is shown

Told = dict[str, Any]


class PeopleDesk:
    """Remembers nothing from one picture to the next: what was learnt goes back to the console, no picture stays."""

    def background(self, picture: Told) -> Told:
        """A picture without anybody → how it is shown, and as it is `kept` beside the others. Raises BadInput."""
        pixels = picture_in(picture)
        check_light(pixels)
        return shown(pixels) | {"kept": told_pixels(pixels)}

    def judge(self, picture: Told, background: Told, taken: list[Told]) -> Told:
        """A picture of somebody, beside the background and what was learnt of them already → how it is shown, what
        is wrong with it or "", and what it teaches if nothing is. Raises BadInput where it cannot be looked at.
        """
        pixels, empty = picture_in(picture), picture_in(background)
        answer = shown(pixels)
        try:
            found = portrait(pixels, empty)
        except BadInput as wrong:
            return answer | {"wrong": str(wrong), "outline": outline_of(pixels, empty), "portrait": None}
        told = told_portrait(found)
        answer |= {"wrong": "", "outline": told["outline"], "portrait": told}
        if any(too_like(found, portrait_in(each)) for each in taken):
            answer |= {"wrong": "This is too like a picture that I have; take another gesture.", "portrait": None}
        return answer

    def learn(self, name: str, taken: list[Told]) -> Told:
        """What was learnt from all of them. Raises BadInput."""
        return told_person(learn(name, [portrait_in(each) for each in taken]))


def told_picture(image: Image) -> Told:
    """A picture of the robot's own camera, as the worker takes it."""
    return told_pixels(image.pixels)


def told_pixels(pixels: Array) -> Told:
    """Pixels (H, W) or (H, W, 3) uint8 in plain values."""
    return {"pixels": pixels.tobytes(), "width": pixels.shape[1], "height": pixels.shape[0]}


def picture_in(told: Told) -> Array:
    """The robot's own picture, or a JPEG or PNG from a stranger as `content` → (H, W, 3) uint8. Raises BadInput."""
    if "content" in told:
        pixels = read(told["content"])
    else:
        pixels = np.frombuffer(told["pixels"], np.uint8).reshape(told["height"], told["width"], -1)
        pixels = np.ascontiguousarray(np.broadcast_to(pixels, (*pixels.shape[:2], 3)))
    factor = LONGEST / max(pixels.shape[:2])
    return pixels if factor >= 1 else cv2.resize(pixels, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)


def read(content: bytes) -> Array:
    """Raises BadInput."""
    if not content.startswith((b"\xff\xd8\xff", b"\x89PNG")):
        raise BadInput("This is no JPEG or PNG picture.")
    try:
        return decode(content, cv2.IMREAD_COLOR)[0]
    except BadInput as wrong:
        words = str(wrong)
        raise BadInput(f"{words[:1].upper()}{words[1:]}.") from None


def shown(pixels: Array) -> Told:
    """A picture as the page shows it while the lesson lasts."""
    picture = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()
    return {"size": [pixels.shape[1], pixels.shape[0]], "picture": picture}


def outline_of(pixels: Array, background: Array) -> list[list[float]]:
    """The contour of what was not good enough, so that one sees why; none where there is none."""
    try:
        mask = contour_of(pixels, background).astype(np.uint8)
    except BadInput:
        return []
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    return cv2.approxPolyDP(max(outlines, key=len), 1.0, closed=True)[:, 0].tolist()


def told_portrait(found: Portrait) -> Told:
    """A portrait in plain values."""
    return {
        "colours": found.colours.tolist(),
        "shape": found.shape,
        "figure": np.packbits(found.figure).tobytes(),
        "figure_size": list(found.figure.shape),
        "outline": found.outline.tolist(),
        "boxes": [list(box) for box in found.boxes],
    }


def portrait_in(told: Told) -> Portrait:
    """The same back."""
    height, width = told["figure_size"]
    bits = np.unpackbits(np.frombuffer(told["figure"], np.uint8), count=height * width)
    return Portrait(
        colours=np.array(told["colours"]),
        shape=told["shape"],
        figure=bits.reshape(height, width) > 0,
        outline=np.array(told["outline"]),
        boxes=tuple((left, top, right, bottom) for left, top, right, bottom in told["boxes"]),
    )


def told_person(who: Enrolled) -> Told:
    """A person in plain values."""
    return {"colours": who.colours.tolist(), "pictures": who.pictures, "shape": who.shape}
