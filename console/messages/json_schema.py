"""The messages of the sockets as JSON Schema, made from the structs that encode and read them."""

import inspect
from typing import Any, get_args

import msgspec

from console.messages import audio, inbound, state

DIALECT = "https://json-schema.org/draft/2020-12/schema"
UNIONS = {
    "Up": (inbound.Up, "From the browser on /ws"),
    "Down": (state.Down, "To the browser on /ws; the camera comes as binary beside it"),
    "AudioUp": (audio.AudioUp, "From the browser on /ws/audio; the sound goes as binary beside it"),
    "AudioDown": (audio.AudioDown, "To the browser on /ws/audio"),
}


def socket_schema() -> dict[str, Any]:
    """One schema document: every message and part under `$defs`, and a union for each direction of each socket."""
    kinds = [kind for union, _ in UNIONS.values() for kind in get_args(union)]
    shapes, parts = msgspec.json.schema_components(kinds, ref_template="#/$defs/{name}")
    for part in parts.values():
        if "description" in part:
            part["description"] = inspect.cleandoc(part["description"])  # as msgspec itself does from 0.23 on
    by_kind = dict(zip(kinds, shapes, strict=True))
    unions = {
        name: {"description": about, "oneOf": [by_kind[kind] for kind in get_args(union)]}
        for name, (union, about) in UNIONS.items()
    }
    return {
        "$schema": DIALECT,
        "title": "Messages of Beckon's sockets",
        "anyOf": [{"$ref": f"#/$defs/{name}"} for name in unions],
        "$defs": parts | unions,
    }
