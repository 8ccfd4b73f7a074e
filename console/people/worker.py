"""The worker that looks at pictures of people: strangers' pictures are decoded here and nowhere else."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from core.calibration.files.pictures import decode
from core.errors import BadInput
from core.message import Array
from core.perception.people.colours import PersonProfile
from core.perception.people.enrollment import PersonImage, check_light, contour_of, learn, person_image, too_like
from core.sensors import Image

LONGEST = 640  # [pixel] side of the pictures that are looked at
QUALITY = 85  # of the JPEG that is shown

Fields = dict[str, Any]


class PeopleWorker:
    """Remembers nothing between pictures: learnt values go back to the console, no picture stays."""

    def background(self, picture: Fields) -> Fields:
        """A picture without anybody → how it is shown, and as it is `kept` for the others. Raises BadInput."""
        pixels = picture_in(picture)
        check_light(pixels)
        return shown(pixels) | {"kept": pixel_fields(pixels)}

    def judge(self, picture: Fields, background: Fields, taken: list[Fields]) -> Fields:
        """A picture of a person, with the background and what was learnt of them already → how it is shown, what
        is wrong with it or "", and what it teaches if nothing is. Raises BadInput where it cannot be looked at.
        """
        pixels, empty = picture_in(picture), picture_in(background)
        answer = shown(pixels)
        try:
            found = person_image(pixels, empty)
        except BadInput as wrong:
            return answer | {"wrong": str(wrong), "outline": outline_of(pixels, empty), "person_image": None}
        image_fields = person_image_fields(found)
        answer |= {"wrong": "", "outline": image_fields["outline"], "person_image": image_fields}
        if any(too_like(found, person_image_in(each)) for each in taken):
            answer |= {"wrong": "This is too like a picture that I have; take another gesture.", "person_image": None}
        return answer

    def learn(self, name: str, taken: list[Fields]) -> Fields:
        """Learn a person from all of their pictures. Raises BadInput."""
        return person_fields(learn(name, [person_image_in(each) for each in taken]))


def picture_fields(image: Image) -> Fields:
    """A picture of the robot's own camera, as the worker takes it."""
    return pixel_fields(image.pixels)


def pixel_fields(pixels: Array) -> Fields:
    """Pixels (H, W) or (H, W, 3) uint8 in plain values."""
    return {"pixels": pixels.tobytes(), "width": pixels.shape[1], "height": pixels.shape[0]}


def picture_in(fields: Fields) -> Array:
    """The robot's own picture, or a JPEG or PNG from a stranger as `content` → (H, W, 3) uint8. Raises BadInput."""
    if "content" in fields:
        pixels = read(fields["content"])
    else:
        pixels = np.frombuffer(fields["pixels"], np.uint8).reshape(fields["height"], fields["width"], -1)
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


def shown(pixels: Array) -> Fields:
    """A picture as the page shows it during the enrollment."""
    picture = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()
    return {"size": [pixels.shape[1], pixels.shape[0]], "picture": picture}


def outline_of(pixels: Array, background: Array) -> list[list[float]]:
    """The contour of a figure that was not good enough, so that one sees why; none where there is none."""
    try:
        mask = contour_of(pixels, background).astype(np.uint8)
    except BadInput:
        return []
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    return cv2.approxPolyDP(max(outlines, key=len), 1.0, closed=True)[:, 0].tolist()


def person_image_fields(found: PersonImage) -> Fields:
    """The learnt part of a picture in plain values."""
    return {
        "colours": found.colours.tolist(),
        "shape": found.shape,
        "figure": np.packbits(found.figure).tobytes(),
        "figure_size": list(found.figure.shape),
        "outline": found.outline.tolist(),
        "boxes": [list(box) for box in found.boxes],
    }


def person_image_in(fields: Fields) -> PersonImage:
    """Plain values → the learnt part of a picture."""
    height, width = fields["figure_size"]
    bits = np.unpackbits(np.frombuffer(fields["figure"], np.uint8), count=height * width)
    return PersonImage(
        colours=np.array(fields["colours"]),
        shape=fields["shape"],
        figure=bits.reshape(height, width) > 0,
        outline=np.array(fields["outline"]),
        boxes=tuple((left, top, right, bottom) for left, top, right, bottom in fields["boxes"]),
    )


def person_fields(who: PersonProfile) -> Fields:
    """A person in plain values."""
    return {"colours": who.colours.tolist(), "pictures": who.pictures, "shape": who.shape}
