"""Python's types as TypeScript's, for editors and `tsc --checkJs`."""

import types
from collections.abc import Iterable, Iterator
from dataclasses import is_dataclass
from typing import Annotated, Any, Literal, NotRequired, Union, get_args, get_origin, get_type_hints, is_typeddict

import msgspec

from console.messages import audio, inbound, state

HEADER = "// Written by `python -m tests.reference`; a test keeps it equal to the code. Do not edit.\n"
PLAIN = {
    bytes: "string",
    float: "number",
    int: "number",
    str: "string",
    bool: "boolean",
    type(None): "null",
    Any: "any",
}

Shape = type[Any]  # with named fields: a struct, a dataclass or a TypedDict


def socket_types() -> str:
    """Declare all that goes over the sockets; from what goes up a field with a default may be absent."""
    up = f"\n/** All that goes up to the console. */\nexport type Up = {js_type(inbound.Up)};\n"
    down = f"\n/** All that comes down to the browser. */\nexport type Down = {js_type(state.Down)};\n"
    sent = declarations((inbound.Up, audio.AudioUp), absent=True)
    return HEADER + sent + up + declarations((state.Down, audio.AudioDown)) + down


def declarations(roots: Iterable[Any], *, absent: bool = False, known: Iterable[str] = ()) -> str:
    """Declare the shapes in some types and in their fields but the known ones; `absent`: defaults may be absent."""
    found: dict[str, Shape] = {}
    for root in roots:
        collect(root, found)
    return "".join(declaration(found[name], absent) for name in sorted(found.keys() - set(known)))


def collect(hint: Any, found: dict[str, Shape]) -> None:
    """Add the shapes in a type and in their fields by their names."""
    if is_shape(hint) and hint.__name__ not in found:
        found[hint.__name__] = hint
        for _, inner, _ in fields_of(hint):
            collect(inner, found)
    for part in get_args(hint):
        collect(part, found)


def is_shape(kind: Any) -> bool:
    """Return whether a type has fields that go by name."""
    is_struct = isinstance(kind, type) and issubclass(kind, msgspec.Struct) and kind is not msgspec.Struct
    return is_struct or is_typeddict(kind) or (isinstance(kind, type) and is_dataclass(kind))


def fields_of(kind: Shape) -> Iterator[tuple[str, Any, bool]]:
    """Name and type of every field, and whether it has a default."""
    hints = get_type_hints(kind, include_extras=True)
    if not issubclass(kind, msgspec.Struct):
        for name, hint in hints.items():
            yield name, hint, get_origin(hint) is NotRequired
        return
    for field in msgspec.structs.fields(kind):
        yield field.encode_name, hints[field.name], not field.required


def declaration(kind: Shape, absent: bool) -> str:
    """One shape. Fields with defaults are absent only where the struct leaves them out, or `absent` says so."""
    about = " ".join((kind.__doc__ or "").split())
    lines = ["", f"/** {about} */", f"export interface {kind.__name__} {{"]
    struct = getattr(kind, "__struct_config__", None)
    if struct is not None and isinstance(struct.tag, str):
        lines.append(f'  {struct.tag_field}: "{struct.tag}";')
    leaves_out = struct is None or absent or struct.omit_defaults
    for name, hint, has_default in fields_of(kind):
        mark = "?" if has_default and (leaves_out or msgspec.UnsetType in get_args(hint)) else ""
        lines.append(f"  {name}{mark}: {js_type(hint)};")
    return "\n".join([*lines, "}", ""])


def js_type(hint: Any) -> str:
    """A Python type → TypeScript's."""
    origin, inner = get_origin(hint), get_args(hint)
    if hint in PLAIN:
        return PLAIN[hint]
    if origin in (Annotated, NotRequired):
        return js_type(inner[0])
    if origin is Literal:
        return " | ".join(f'"{word}"' for word in inner)
    if origin in (Union, types.UnionType):
        return " | ".join(js_type(part) for part in inner if part is not msgspec.UnsetType)
    if origin is list or (origin is tuple and inner[-1] is Ellipsis):
        part = js_type(inner[0])
        return f"({part})[]" if "|" in part else f"{part}[]"
    if origin is tuple:
        return "[" + ", ".join(js_type(part) for part in inner) + "]"
    if origin is dict:
        return f"Record<string, {js_type(inner[1])}>"
    return str(hint.__name__)
