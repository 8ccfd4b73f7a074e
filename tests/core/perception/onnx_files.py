"""Small ONNX files that answer with the same numbers whatever they see: one for each layout that is read."""

from collections.abc import Sequence

import numpy as np

from core.message import Array

FLOAT, INTEGER = 1, 7


def varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*out, value])


def number(field: int, value: int) -> bytes:
    return varint(field << 3) + varint(value)


def piece(field: int, content: bytes | str) -> bytes:
    raw = content.encode() if isinstance(content, str) else content
    return varint(field << 3 | 2) + varint(len(raw)) + raw


def tensor(name: str, values: Array) -> bytes:
    kind = INTEGER if values.dtype == np.int64 else FLOAT
    dims = b"".join(number(1, size) for size in values.shape)
    return piece(5, dims + number(2, kind) + piece(8, name) + piece(9, values.tobytes()))


def value(field: int, name: str, shape: Sequence[int]) -> bytes:
    dims = b"".join(piece(1, number(1, size)) for size in shape)
    return piece(field, piece(1, name) + piece(2, piece(1, number(1, FLOAT) + piece(2, dims))))


def node(kind: str, inputs: Sequence[str], output: str) -> bytes:
    return piece(1, b"".join(piece(1, one) for one in inputs) + piece(2, output) + piece(3, output) + piece(4, kind))


def onnx_file(shape: tuple[int, int, int, int], answers: Sequence[Array]) -> bytes:
    """A picture of this shape → these arrays, by GlobalAveragePool, Flatten, Gemm (of zeros) and Reshape."""
    graph = node("GlobalAveragePool", ["picture"], "mean") + node("Flatten", ["mean"], "flat")
    for at, answer in enumerate(answers):
        flat = answer.astype(np.float32).reshape(-1)
        graph += node("Gemm", ["flat", f"zeros{at}", f"values{at}"], f"row{at}")
        graph += node("Reshape", [f"row{at}", f"shape{at}"], f"output{at}")
        graph += tensor(f"zeros{at}", np.zeros((shape[1], flat.size), np.float32)) + tensor(f"values{at}", flat)
        graph += tensor(f"shape{at}", np.array(answer.shape, np.int64))
        graph += value(12, f"output{at}", answer.shape)
    graph += piece(2, "generated") + value(11, "picture", shape)
    return number(1, 8) + piece(8, piece(1, "") + number(2, 13)) + piece(7, graph)


def greedy_file(side: int, channels: int) -> bytes:
    """A small file whose one convolution makes so many channels of a picture."""
    graph = node("Conv", ["picture", "weights"], "wide") + node("GlobalAveragePool", ["wide"], "output")
    graph += tensor("weights", np.zeros((channels, 3, 1, 1), np.float32))
    graph += (
        value(12, "output", (1, channels, 1, 1)) + piece(2, "generated") + value(11, "picture", (1, 3, side, side))
    )
    return number(1, 8) + piece(8, piece(1, "") + number(2, 13)) + piece(7, graph)
