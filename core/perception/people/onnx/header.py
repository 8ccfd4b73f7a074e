"""The size of the picture that an ONNX file takes, read without running it (protobuf, field by field)."""

from __future__ import annotations

from collections.abc import Iterator

from core.errors import BadInput

GRAPH_FIELD, INPUT_FIELD, INITIALIZER_FIELD = 7, 11, 5  # fields of ModelProto and GraphProto
VALUE_NAME, VALUE_TYPE, TENSOR_NAME = 1, 2, 8  # of ValueInfoProto and TensorProto
TENSOR_TYPE, SHAPE_FIELD, DIMENSION_FIELD, DIMENSION_VALUE = 1, 2, 1, 1
VARINT_KIND, LONG_KIND, BYTES_KIND, WORD_KIND = 0, 1, 2, 5  # wire types
BROKEN = "this is no ONNX file, or it is damaged"
USUAL_SHAPE = (1, 3, 640, 640)  # where the file leaves its size open
MOST_SIDE = 1920  # [pixel]


def input_shape(content: bytes) -> tuple[int, int, int, int]:
    """An ONNX file → the four dimensions of the picture that goes in. Raises BadInput."""
    graph = next(
        (value for field, value in fields(content) if field == GRAPH_FIELD and isinstance(value, bytes)), None
    )
    if graph is None:
        raise BadInput(BROKEN)
    weights: set[bytes] = set()
    inputs: list[bytes] = []
    for field, value in fields(graph):
        if field == INITIALIZER_FIELD and isinstance(value, bytes):
            weights |= {name for number, name in fields(value) if number == TENSOR_NAME and isinstance(name, bytes)}
        elif field == INPUT_FIELD and isinstance(value, bytes):
            inputs.append(value)
    for one in inputs:
        names = [value for number, value in fields(one) if number == VALUE_NAME]
        shape = _shape(one)
        if names and names[0] not in weights and len(shape) == 4:
            return _whole(shape)
    raise BadInput("the model takes no picture: none of its inputs has four dimensions")


def fields(content: bytes) -> Iterator[tuple[int, int | bytes]]:
    """The fields of a protobuf message: number, and a whole number or bytes. Raises BadInput."""
    at = 0
    while at < len(content):
        key, at = _varint(content, at)
        kind = key & 7
        if kind == VARINT_KIND:
            value, at = _varint(content, at)
        elif kind == BYTES_KIND:
            length, at = _varint(content, at)
            value, at = content[at : at + length], at + length
        elif kind in (LONG_KIND, WORD_KIND):
            width = 8 if kind == LONG_KIND else 4
            value, at = content[at : at + width], at + width
        else:
            raise BadInput(BROKEN)
        if at > len(content):
            raise BadInput(BROKEN)
        yield key >> 3, value


def _varint(content: bytes, at: int) -> tuple[int, int]:
    value = shift = 0
    while at < len(content) and shift < 70:
        byte = content[at]
        value |= (byte & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if byte < 0x80:
            return value, at
    raise BadInput(BROKEN)


def _inner(content: bytes, wanted: int) -> bytes:
    found = [value for number, value in fields(content) if number == wanted and isinstance(value, bytes)]
    return found[0] if found else b""


def _shape(value_info: bytes) -> list[int]:
    """The dimensions of an input; 0 where one is left open."""
    shape = _inner(_inner(_inner(value_info, VALUE_TYPE), TENSOR_TYPE), SHAPE_FIELD)
    sizes: list[int] = []
    for number, dimension in fields(shape):
        if number == DIMENSION_FIELD and isinstance(dimension, bytes):
            values = [value for field, value in fields(dimension) if field == DIMENSION_VALUE]
            sizes.append(values[0] if values and isinstance(values[0], int) else 0)
    return sizes


def _whole(shape: list[int]) -> tuple[int, int, int, int]:
    """The shape with what it leaves open; channels may come last. Raises BadInput."""
    last = shape[3] == 3 and shape[1] != 3
    usual = (USUAL_SHAPE[0], USUAL_SHAPE[2], USUAL_SHAPE[3], USUAL_SHAPE[1]) if last else USUAL_SHAPE
    batch, *rest = (size or plain for size, plain in zip(shape, usual, strict=True))
    sides = rest[:2] if last else rest[1:]
    if batch != 1 or 3 not in (rest[0], rest[2]) or not all(32 <= side <= MOST_SIDE for side in sides):
        raise BadInput(f"the model takes {'x'.join(map(str, shape))} numbers; a colour picture is 1x3xHxW")
    return batch, rest[0], rest[1], rest[2]
