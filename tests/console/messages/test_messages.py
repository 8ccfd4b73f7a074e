"""The socket's types, here and in the browser."""

import math

import msgspec
import pytest

from console.messages import inbound
from console.messages import state as messages


@pytest.mark.parametrize(
    "told",
    [
        {"kind": "drive", "v": True, "w": 0, "press": 1, "seq": 1, "nonce": 1, "epoch": 1},
        {"kind": "drive", "v": "0.1", "w": 0, "press": 1, "seq": 1, "nonce": 1, "epoch": 1},
        {"kind": "drive", "v": 0.1, "w": 0, "press": 1.5, "seq": 1, "nonce": 1, "epoch": 1},
        {"kind": "drive", "v": 0.1, "w": 0, "press": -1, "seq": 1, "nonce": 1, "epoch": 1},
        {"kind": "drive", "v": 0.1, "w": 0, "press": 1, "seq": 1, "nonce": 1, "epoch": 2**60},
        {"kind": "drive", "v": 0.1, "w": 0, "press": 1, "seq": 1, "nonce": 1},
        {"kind": "drive", "v": 0.1, "w": 0, "press": 1, "seq": 1, "nonce": 1, "epoch": 1, "more": 1},
        {"kind": "drive", "v": None, "w": 0, "press": 1, "seq": 1, "nonce": 1, "epoch": 1},
        {"kind": "lease", "do": "steal", "ref": 1},
        {"kind": "command", "text": "x" * 2001, "source": "typed", "ref": 1},
        {"kind": "command", "text": "turn left", "source": "rest", "ref": 1},
        {"kind": "want", "camera": 1},
        {"kind": "unknown"},
        {"kind": ["stop"]},
        {},
        [],
        "stop",
        None,
        7,
    ],
    ids=str,
)
def test_what_has_not_the_form_is_refused(told: object) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(told, inbound.Up)


def test_what_is_not_finite_leaves_as_null() -> None:
    sent = messages.encode(messages.Velocity(math.nan, math.inf))
    assert sent == b'{"v_m_s":null,"w_rad_s":null}'


def test_the_camera_header_is_sixteen_bytes_little_endian() -> None:
    header = messages.CAMERA_HEADER.pack(1, 7, 2.5)
    assert len(header) == 16 and header[0] == 1
    assert int.from_bytes(header[4:8], "little") == 7
