"""Exposure, noise and blur of a picture, measured on the picture itself."""

import math

import cv2
import numpy as np

from core.message import Array, message

BLACK_GREY, WHITE_GREY = 2, 253  # grey levels at and beyond which a pixel means only "less" or "more"
BRIGHTEST_SHARE = 0.1  # share of the pixels that is left out of the level: lamps and windows
SECOND = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.int16)  # answers to no plane and to no straight edge
SECOND_GAIN = 6.0  # sd of its answer to white noise of sd 1
NORMAL_MEDIAN = 0.6745  # median of |x| for a normal x of sd 1
ROUNDING_SD_GREY = 0.29  # [grey levels] sd of rounding to whole numbers: no picture is less noisy
FINE_SD_PX, COARSE_SD_PX = 1.0, 2.5  # sd of the two smoothings that are compared
AVERAGED_ROWS = 5  # that are averaged, of which every third is looked at
MIN_EDGE_RATIO = 12.0  # times the noise of a slope that an edge must have for its width to be measured
MIN_EDGE_SLOPE = 0.5  # [grey levels per pixel] of that slope in any case
RIM_PX = 8  # at either end of a row that are left out
SHARPEST_QUANTILE = 0.4  # quantile that counts: soft shadows and neighbouring edges make the others look wider
MIN_EDGES = 12  # edges, below which the blur is not measured
MAX_BLUR_SD_PX = 8.0  # the widest sd that can be measured


@message
class ExposureMeasure:
    """Statistics of a picture's grey levels, 0..255."""

    mean: float
    level: float  # mean of all but the brightest tenth: what lamps and windows do not change
    low: float  # 1 % of the pixels are darker
    high: float  # 1 % are brighter
    dark_share: float  # 0..1 of the pixels that are black
    bright_share: float  # 0..1 that are white


@message
class Blur:
    """Width of a sharp step in the picture: sd of the blur [pixel]; None where too few clear edges run that way."""

    across: float | None  # of upright edges
    down: float | None  # of level ones


def exposure(grey: Array) -> ExposureMeasure:
    """Picture (H, W) uint8 → how it is exposed."""
    counts = cv2.calcHist([grey], [0], None, [256], [0, 256]).ravel().astype(float)
    shares = counts / counts.sum()
    levels = np.arange(256.0)
    below = np.cumsum(shares)
    kept = np.clip(1 - BRIGHTEST_SHARE - (below - shares), 0.0, shares)
    return ExposureMeasure(
        mean=float(shares @ levels),
        level=float(kept @ levels / kept.sum()),
        low=_quantile(below, 0.01),
        high=_quantile(below, 0.99),
        dark_share=float(shares[: BLACK_GREY + 1].sum()),
        bright_share=float(shares[WHITE_GREY:].sum()),
    )


def _quantile(below: Array, part: float) -> float:
    """Cumulated shares (256,) → the level with that part below it, between whole levels."""
    index = int(np.searchsorted(below, part))
    start = below[index - 1] if index else 0.0
    return index - 0.5 + float((part - start) / max(below[index] - start, 1e-12))


def noise_sd(grey: Array) -> float:
    """Picture (H, W) uint8 → sd of its noise [grey levels], for any content.

    Immerkær's mask ("Fast noise variance estimation", CVIU 64, 1996) with the median in place of the mean, so that
    texture on less than half of the picture hardly counts. Pixels at either end of the scale are left out: noise is
    cut off there.
    """
    rough = np.abs(cv2.filter2D(grey, cv2.CV_16S, SECOND)[1:-1:2, 1:-1])
    shown = grey[1:-1:2, 1:-1]
    rough = rough[(shown > BLACK_GREY) & (shown < WHITE_GREY)]
    if rough.size < 200:
        return ROUNDING_SD_GREY
    counts = np.bincount(rough)
    middle = _quantile(np.cumsum(counts) / rough.size, 0.5)  # whole numbers: between them by their shares
    return max(ROUNDING_SD_GREY, middle / (NORMAL_MEDIAN * SECOND_GAIN))


def blur(grey: Array, noise: float) -> Blur:
    """Picture (H, W) uint8 and its noise [grey levels] → its blur, upright and level edges apart.

    A step that was blurred by b has the slope c/√(b² + s²) after a smoothing by s; two smoothings give b whatever its
    contrast c (Zhuo and Sim, "Defocus map estimation from a single image", Pattern Recognition 44, 2011). Motion
    blurs one direction more than the other.
    """
    return Blur(across=_width(grey, noise), down=_width(np.ascontiguousarray(grey.T), noise))


def _width(grey: Array, noise: float) -> float | None:
    """Picture (H, W) → sd [pixel] of the blur of its edges that run down, or None."""
    along = cv2.boxFilter(grey, cv2.CV_32F, (1, AVERAGED_ROWS), borderType=cv2.BORDER_REPLICATE)[
        AVERAGED_ROWS // 2 :: 3
    ]
    fine, steep = _slope(along, FINE_SD_PX), np.abs(_slope(along, COARSE_SD_PX))
    # sd of the coarse slope of noise alone
    quiet = noise / math.sqrt(AVERAGED_ROWS * 4 * math.sqrt(math.pi) * COARSE_SD_PX**3)
    peak = steep > max(MIN_EDGE_RATIO * quiet, MIN_EDGE_SLOPE)
    peak[:, 1:-1] &= (steep[:, 1:-1] >= steep[:, :-2]) & (steep[:, 1:-1] > steep[:, 2:])
    peak[:, :RIM_PX] = peak[:, -RIM_PX:] = False
    if np.count_nonzero(peak) < MIN_EDGES:
        return None
    ratio = np.clip(np.abs(fine[peak]) / steep[peak], 1.0 + 1e-6, COARSE_SD_PX / FINE_SD_PX)
    squares = (COARSE_SD_PX**2 - ratio**2 * FINE_SD_PX**2) / (ratio**2 - 1)
    return min(MAX_BLUR_SD_PX, math.sqrt(max(0.0, float(np.quantile(squares, SHARPEST_QUANTILE)))))


def _slope(grey: Array, sd: float) -> Array:
    """Rows (H, W) → their slope [grey levels per pixel] after a smoothing by `sd` [pixel]."""
    reach = math.ceil(3.5 * sd)
    x = np.arange(-reach, reach + 1, dtype=float)
    kernel = x * np.exp(-0.5 * (x / sd) ** 2)
    kernel /= (x * kernel).sum()
    return cv2.filter2D(grey, cv2.CV_32F, kernel[None, :].astype(np.float32), borderType=cv2.BORDER_REPLICATE)
