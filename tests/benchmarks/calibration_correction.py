"""Table 1 measured: `python -m tests.benchmarks.calibration_correction`.

The inverse model a1..a8 and the exact way over every pixel of the picture of Table 3's camera, eq. 10 as printed
beside, and the time of each.
"""

import time
from typing import Any

import cv2
import numpy as np
from scipy.optimize import least_squares

from core.calibration.camera.undistortion import (
    all_pixels,
    errors,
    exact_map,
    inverse_parameters,
    straighten,
    table_1_map,
    tie_points,
)
from core.message import Array
from core.optics import TABLE_3
from tests.benchmarks.command import run_command


def as_printed(a: Array, distorted: Array) -> Array:
    """Eq. 10 with the printed denominator (a3 r² + a6 u + a7 v + a8) r² + 1."""
    u, v = distorted.T
    r2 = u * u + v * v
    below = (a[2] * r2 + a[5] * u + a[6] * v + a[7]) * r2 + 1
    bend = 1 + a[0] * r2 + a[1] * r2 * r2
    x = u * bend + 2 * a[2] * u * v + a[3] * (r2 + 2 * u * u)
    y = v * bend + a[2] * (r2 + 2 * v * v) + 2 * a[3] * u * v
    return np.column_stack((x, y)) / below[:, None]


def printed_error() -> dict[str, float]:
    """The best that the printed formula can do."""
    grid, focal = tie_points(TABLE_3), np.array([TABLE_3.fx, TABLE_3.fy])

    def residuals(a: Array) -> Array:
        return ((as_printed(a, grid.distorted) - grid.ideal) * focal).ravel()

    best = least_squares(residuals, np.zeros(8), method="lm").x
    pixels = all_pixels(TABLE_3)
    off = np.linalg.norm((as_printed(best, pixels) - TABLE_3.undistort(pixels)) * focal, axis=1)
    return {"rms_px": float(np.sqrt(np.mean(off**2))), "max_px": float(off.max())}


def took(work: Any) -> float:
    begun = time.process_time()
    work()
    return 1e3 * (time.process_time() - begun)


def main() -> object:
    """Measure and report."""
    cv2.setNumThreads(1)
    table_1, exact = errors(TABLE_3)
    lookup, frame = exact_map(TABLE_3), np.zeros((TABLE_3.height, TABLE_3.width, 3), np.uint8)
    return {
        "table_1": table_1,
        "as_printed": printed_error(),
        "exact": exact,
        "maps_differ_px": float(np.abs(table_1_map(TABLE_3) - lookup)[8:-8, 8:-8].max()),
        "fit_ms": min(took(lambda: inverse_parameters(TABLE_3)) for _ in range(5)),
        "exact_map_ms": min(took(lambda: exact_map(TABLE_3)) for _ in range(5)),
        "table_1_map_ms": min(took(lambda: table_1_map(TABLE_3)) for _ in range(3)),
        "straighten_ms": min(took(lambda: straighten(frame, lookup)) for _ in range(20)),
    }


if __name__ == "__main__":
    run_command(main)
