"""The socket's types as JSDoc, for editors and `tsc --checkJs`: `python -m console.messages.generate_js`."""

from __future__ import annotations

import re
import types
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import msgspec

from console import messages
from console.messages import state

HEADER = (
    "// Written by `python -m console.messages.generate_js` from console/messages/{source}.py; a test keeps the two"
    " equal. Do not edit.\n"
)

CAMERA = """/**
 * The camera arrives as binary: u8 kind = 1, 3 bytes of padding, u32 sequence number, f64 stamp [s], all little
 * endian, then the JPEG.
 */
export const CAMERA_HEADER_BYTES = 16;
"""

PLAIN = {float: "number", int: "number", str: "string", bool: "boolean", type(None): "null", Any: "any"}

Shape = type[msgspec.Struct]


def generate_js() -> dict[str, str]:
    """Names in static/js/net → their texts: a file for each of Python's; messages.js knows the names of all."""
    texts: dict[str, str] = {}
    for module in dict.fromkeys([*(shape.__module__ for shape in shapes()), state.__name__]):
        own = [shape for shape in shapes() if shape.__module__ == module]
        whole = module == state.__name__
        foreign = [shape for shape in (shapes() if whole else parts_of(own)) if shape.__module__ != module]
        rest = [CAMERA, union("Up"), union("Down")] if whole else ["export {};\n"]
        parts = [HEADER.format(source=module.rpartition(".")[2])]
        parts += ["\n".join(borrowed(shape) for shape in foreign) + "\n"] if foreign else []
        texts[file_of(module)] = "\n".join([*parts, *(typedef(shape) for shape in own), *rest])
    return texts


def shapes() -> Iterator[Shape]:
    """Every message and its parts, in the order of console/messages/state.py."""
    for shape in vars(messages).values():
        ours = (
            isinstance(shape, type)
            and issubclass(shape, msgspec.Struct)
            and shape.__module__.startswith(messages.__name__)
        )
        if ours and shape is not messages.InboundMessage:
            yield shape


def parts_of(own: Iterable[Shape]) -> list[Shape]:
    """The shapes that some others name in their fields."""
    named = " ".join(typedef(shape) for shape in own)
    return [shape for shape in shapes() if re.search(rf"\b{shape.__name__}\b", named)]


def file_of(module: str) -> str:
    """The module of Python → the file of the browser."""
    name = module.rpartition(".")[2].replace("_", "-")
    return "messages.js" if module == state.__name__ else f"messages-{name}.js"


def borrowed(shape: Shape) -> str:
    """A shape that another file has."""
    return f'/** @typedef {{import("./{file_of(shape.__module__)}").{shape.__name__}}} {shape.__name__} */'


def typedef(shape: Shape) -> str:
    """One struct as an object type."""
    hints = get_type_hints(shape, include_extras=True)
    lines = ["/**", f" * {(shape.__doc__ or '').strip()}", f" * @typedef {{object}} {shape.__name__}"]
    if isinstance(shape.__struct_config__.tag, str):
        lines.append(f" * @property {{'{shape.__struct_config__.tag}'}} {shape.__struct_config__.tag_field}")
    for field in msgspec.structs.fields(shape):
        absent = not field.required
        name = f"[{field.name}]" if absent else field.name
        lines.append(f" * @property {{{js_type(hints[field.name])}}} {name}")
    return "\n".join([*lines, " */", ""])


def union(name: str) -> str:
    """One of the unions of all messages in a direction."""
    direction = "goes up to the console" if name == "Up" else "comes down to the browser"
    members = " | ".join(shape.__name__ for shape in get_args(getattr(messages, name)))
    return f"/**\n * All that {direction}.\n * @typedef {{{members}}} {name}\n */\n"


def js_type(hint: Any) -> str:
    """A Python type → its JSDoc name."""
    origin, inner = get_origin(hint), get_args(hint)
    if hint in PLAIN:
        return PLAIN[hint]
    if origin is Annotated:
        return js_type(inner[0])
    if origin is Literal:
        return " | ".join(f"'{word}'" for word in inner)
    if origin in (Union, types.UnionType):
        return " | ".join(js_type(part) for part in inner if part is not msgspec.UnsetType)
    if origin is list:
        part = js_type(inner[0])
        return f"({part})[]" if "|" in part else f"{part}[]"
    if origin is tuple:
        return "[" + ", ".join(js_type(part) for part in inner) + "]"
    if origin is dict:
        return f"Object<string, {js_type(inner[1])}>"
    return str(hint.__name__)


if __name__ == "__main__":
    for name, text in generate_js().items():
        Path(__file__).parents[2].joinpath("static/js/net", name).write_text(text)
