"""A piece of picture → how its edges run, cell by cell: what is compared with the model."""

import cv2
import numpy as np

from core.message import Array
from core.perception.people.parts import CELL_PX

DIRECTION_COUNT = 9  # of an edge, over half a turn
MIN_GRADIENT = 6.0  # grey levels per pixel: weaker gradients are mostly noise
MAX_HISTOGRAM = 0.4


def edge_cells(pixels: Array) -> Array:
    """Picture (H, W, 3) uint8, both sides multiples of CELL → (H / CELL, W / CELL, DIRECTIONS) float32, 0 to 1.

    Histograms of oriented gradients (Dalal and Triggs 2005): per pixel the channel that changes most, its direction
    shared by the two nearest bins, the cells levelled by their neighbourhood.
    """
    rows, columns = pixels.shape[0] // CELL_PX, pixels.shape[1] // CELL_PX
    dx = cv2.Sobel(pixels, cv2.CV_32F, 1, 0, ksize=1)
    dy = cv2.Sobel(pixels, cv2.CV_32F, 0, 1, ksize=1)
    strongest = (dx * dx + dy * dy).argmax(axis=2)[:, :, None]
    gx, gy = (np.take_along_axis(d, strongest, axis=2)[:, :, 0] for d in (dx, dy))
    size, angle = cv2.cartToPolar(gx, gy)
    place = angle * np.float32(DIRECTION_COUNT / np.pi) - np.float32(0.5)
    low = np.floor(place)
    share = place - low
    first = low.astype(np.int32) % DIRECTION_COUNT
    second = (first + 1) % DIRECTION_COUNT
    row, column = np.arange(pixels.shape[0]) // CELL_PX, np.arange(pixels.shape[1]) // CELL_PX
    cell = (row[:, None] * columns + column[None, :]) * DIRECTION_COUNT
    total = rows * columns * DIRECTION_COUNT
    sums = np.bincount((cell + first).ravel(), (size * (1 - share)).ravel(), total)
    sums += np.bincount((cell + second).ravel(), (size * share).ravel(), total)
    histograms = sums.reshape(rows, columns, DIRECTION_COUNT).astype(np.float32)
    energy = cv2.blur(np.square(histograms).sum(axis=2), (3, 3), borderType=cv2.BORDER_REPLICATE)
    level = np.sqrt(energy + np.float32((MIN_GRADIENT * CELL_PX) ** 2))
    return np.minimum(histograms / level[:, :, None], MAX_HISTOGRAM)
