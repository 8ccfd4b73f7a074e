"""PGM to the letter of its head: any depth, in bytes or in words, whatever program wrote it."""

import re

import numpy as np

from core.message import Array

GAP = rb"(?:\s|#[^\n]*\n)+"
HEAD = re.compile(rb"(P[25])%b(\d{1,9})%b(\d{1,9})%b(\d{1,9})(?:\r\n|\s)" % (GAP, GAP, GAP))
COMMENT = re.compile(rb"#[^\n]*\n")  # behind the head, where some programs write them
PADDING = b"\0\t\r\n "  # that some write behind the pixels
BRIGHTEST_LEVELS = (255, 1023, 4095, 16383, 65535)  # brightest values of cameras of 8 to 16 bits


class HeadMismatch(ValueError):
    """The pixels are more, or brighter, than the head says."""


def pgm_size(content: bytes) -> tuple[int, int, int] | None:
    """Width, height and the brightest value, as the head says; None where this is no PGM."""
    head = HEAD.match(content)
    return None if head is None else (int(head[2]), int(head[3]), int(head[4]))


def read_pgm(content: bytes) -> Array:
    """A PGM → (H, W) uint8, its brightest value 255. Raises HeadMismatch, and ValueError where it is cut or none."""
    head = HEAD.match(content)
    if head is None:
        raise ValueError("no PGM")
    width, height, most = (int(number) for number in head.groups()[1:])
    if not 0 < most < 65536:
        raise ValueError("no PGM")
    rest = content[head.end() :]
    if head[1] == b"P5":
        kind = np.dtype(">u2" if most > 255 else np.uint8)
        length = width * height * kind.itemsize
        while (comment := COMMENT.match(rest)) is not None and len(rest) - comment.end() >= length:
            rest = rest[comment.end() :]
        if rest[length:].strip(PADDING):
            raise HeadMismatch
        levels = np.frombuffer(rest[:length], kind, len(rest[:length]) // kind.itemsize)
    else:
        levels = np.array(re.sub(COMMENT, b"\n", rest).split(), np.int64)
    if len(levels) < width * height:
        raise ValueError("cut off")
    levels = levels[: width * height].reshape(height, width)
    if levels.min(initial=0) < 0 or levels.max(initial=0) > most:
        raise HeadMismatch
    return np.rint(levels * (255.0 / most)).astype(np.uint8)


def in_8_bits(pixels: Array, depths: tuple[int, ...] = BRIGHTEST_LEVELS) -> Array:
    """Pixels of 8 or 16 bits → uint8; the brightest one says which of the `depths` a file of 16 bits holds."""
    if pixels.dtype != np.uint16:
        return pixels
    most = next(depth for depth in depths if pixels.max(initial=0) <= depth)
    return np.rint(pixels * (255.0 / most)).astype(np.uint8)
