"""A person whom a model found in a picture: head, torso and feet as boxes, and K of those that are in it (eq. 34)."""

from core.message import message
from core.perception.people.parts import PARTS

Box = tuple[float, float, float, float]  # left, top, right, bottom [pixel]; it may reach out of the picture
MIN_SHOWN_SHARE = 0.3  # share of a part in the picture below which it says nothing


@message
class SeenBody:
    """Someone, as a model found them; nothing is known yet of what the picture's rim cuts off."""

    parts: tuple[Box, Box, Box]  # head, torso, feet
    likelihoods: tuple[float, float, float]  # K1, K2, K3 of eq. 34
    box: Box  # around all of the body
    head_column: float  # [pixel] of the head's middle
    foretold_head: float  # [pixel] row in which the head's middle is by the torso alone
    hips_row: float  # [pixel]
    torso_length: float  # [pixel] from the hips to the shoulders; about 0.29 of the stature
    legs_length: float  # [pixel] from the hips down to the ankles, negative where these are higher
    confidence: float  # 0..1 that someone is there


@message
class WeighedBody:
    """The same in a picture of a certain size."""

    body: SeenBody
    likelihoods: tuple[float | None, float | None, float | None]  # None: not in the picture
    value: float  # K of eq. 34, of the parts that are in the picture
    shown: float  # 0..1: weight of the parts that are in the picture


def weigh(body: SeenBody, width: int, height: int) -> WeighedBody:
    """Weigh the parts as in eq. 34, each by its share in the picture [pixel]; K is 0 where none is in it."""
    shares = [share_inside(box, width, height) for box in body.parts]
    if not 0 <= body.foretold_head < height:
        shares[0] = 0.0  # a model puts a head into the picture all the same
    shares = [share if share >= MIN_SHOWN_SHARE else 0.0 for share in shares]
    weights = [part.weight * share for part, share in zip(PARTS, shares, strict=True)]
    shown = sum(weights)
    value = sum(weight * k for weight, k in zip(weights, body.likelihoods, strict=True)) / max(shown, 1e-9)
    known = [k if share else None for k, share in zip(body.likelihoods, shares, strict=True)]
    return WeighedBody(body=body, likelihoods=(known[0], known[1], known[2]), value=float(value), shown=shown)


def share_inside(box: Box, width: int, height: int) -> float:
    """The share of a box that is in a picture of this size [pixel], 0..1."""
    x0, y0, x1, y1 = box
    across, down = min(x1, width) - max(x0, 0.0), min(y1, height) - max(y0, 0.0)
    return max(across, 0.0) * max(down, 0.0) / max((x1 - x0) * (y1 - y0), 1e-9)


def overlap(one: Box, other: Box) -> float:
    """Intersection over union of two boxes, 0..1."""
    across = min(one[2], other[2]) - max(one[0], other[0])
    down = min(one[3], other[3]) - max(one[1], other[1])
    common = max(across, 0.0) * max(down, 0.0)
    whole = sum((box[2] - box[0]) * (box[3] - box[1]) for box in (one, other)) - common
    return common / max(whole, 1e-9)
