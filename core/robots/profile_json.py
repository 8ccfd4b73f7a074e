"""A robot's profile as JSON, every number to the last bit: how a recording keeps the robot that made it."""

import msgspec
import numpy as np

from core.errors import BadInput
from core.message import listed
from core.robots import Profile


def profile_to_json(profile: Profile) -> bytes:
    """The profile in one piece."""
    return msgspec.json.encode(profile, enc_hook=listed)


def profile_from_json(content: bytes) -> Profile:
    """Read what `profile_to_json` made. Raises BadInput."""
    try:
        return msgspec.json.decode(content, type=Profile, dec_hook=lambda _, value: np.array(value, float))
    except (msgspec.MsgspecError, ValueError) as trouble:
        raise BadInput(f"The robot's description in the recording cannot be used: {trouble}") from None
