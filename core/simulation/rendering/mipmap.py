"""Textures under work: what paints, lights and halves them."""

import math
import zlib

import cv2
import numpy as np

from core.message import Array

Colour = tuple[float, float, float]  # blue, green, red, 0..255

LIGHT_RAD = math.radians(185.0)  # where faces look that are brightest; nearly along x, so that all corners show


def shade(normal: float | Array) -> float | Array:
    """Direction(s) a face looks to [rad] → its brightness: neighbouring walls differ."""
    return 0.86 + 0.20 * np.cos(np.asarray(normal) - LIGHT_RAD)


BOOKS: tuple[Colour, ...] = (
    (70, 60, 170),
    (60, 120, 60),
    (150, 90, 40),
    (60, 140, 210),
    (120, 70, 110),
    (200, 190, 170),
    (50, 50, 60),
    (90, 150, 190),
)


def darker(colour: Colour, factor: float) -> Colour:
    """The same colour with less light."""
    return colour[0] * factor, colour[1] * factor, colour[2] * factor


class TextureCanvas:
    """A texture under work. u runs from the left [m], z from the bottom [m]."""

    def __init__(self, width: float, height: float, scale: float, name: str) -> None:
        self.width, self.height, self.scale = width, height, scale
        self.pixels = np.empty((max(2, round(height * scale)), max(2, round(width * scale)), 3), np.float32)
        self.rng = np.random.default_rng(zlib.crc32(name.encode()))

    @property
    def u(self) -> Array:
        """Of every column (W,) [m]."""
        return (np.arange(self.pixels.shape[1], dtype=np.float32) + 0.5) / self.scale

    @property
    def z(self) -> Array:
        """Of every row (H,) [m]."""
        return self.height - (np.arange(self.pixels.shape[0], dtype=np.float32) + 0.5) / self.scale

    def fill(self, u0: float, z0: float, u1: float, z1: float, colour: Colour) -> None:
        """Paint a rectangle."""
        rows = slice(max(0, round((self.height - z1) * self.scale)), max(0, round((self.height - z0) * self.scale)))
        self.pixels[rows, max(0, round(u0 * self.scale)) : max(0, round(u1 * self.scale))] = colour

    def times(self, factor: Array) -> None:
        """Make brighter or darker: (H, 1), (1, W) or (H, W)."""
        self.pixels *= factor[:, :, None]

    def grain(self, amount: float) -> None:
        """Small irregularities of the paint."""
        rows, columns = self.pixels.shape[:2]
        coarse = self.rng.normal(1.0, amount, (rows // 3 + 1, columns // 3 + 1)).astype(np.float32)
        self.times(cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_LINEAR))

    def footing(self) -> None:
        """The floor keeps light away from what stands on it."""
        self.times((1 - 0.30 * np.exp(-self.z / 0.10))[:, None])

    def finished(self) -> Array:
        """(H, W, 3) uint8."""
        return np.clip(self.pixels, 0, 255).astype(np.uint8)


def pyramid(image: Array, levels: int) -> list[Array]:
    """A texture and its halves, for what is seen from far away."""
    images = [image]
    for _ in range(levels - 1):
        rows, columns = images[-1].shape[:2]
        half = (max(2, columns // 2), max(2, rows // 2))
        images.append(cv2.resize(images[-1], half, interpolation=cv2.INTER_AREA))
    return images
