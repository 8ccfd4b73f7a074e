"""A sound as a picture: time to the right, pitch upwards, loudness as colour."""

from __future__ import annotations

import cv2
import numpy as np
from scipy.signal import ShortTimeFFT

from core.message import Array

FRAME, STEP = 0.032, 0.008  # [s]
HIGHEST = 8_000.0  # [Hz]
RANGE_DB = 70.0  # below the loudest is black
SIZE = (900, 260)  # [pixels] of the picture


def spectrogram_png(samples: Array, rate: int, loudest: float | None = None) -> bytes:
    """Samples (N,) at `rate` [Hz] → a PNG of 900 x 260 pixels.

    `loudest` [dB], as of `loudest_db`, gives two pictures the same colours.
    """
    levels = _levels(samples, rate)
    top = float(levels.max()) if loudest is None else loudest
    grey = np.clip(255 * (1 + (levels - top) / RANGE_DB), 0, 255).astype(np.uint8)
    wide = cv2.resize(grey[::-1], SIZE, interpolation=cv2.INTER_AREA)
    _, png = cv2.imencode(".png", cv2.applyColorMap(wide, cv2.COLORMAP_MAGMA))
    return png.tobytes()


def loudest_db(samples: Array, rate: int) -> float:
    """The loudest place of the picture [dB]."""
    return float(_levels(samples, rate).max())


def _levels(samples: Array, rate: int) -> Array:
    """(bins, frames) [dB], lowest pitch first."""
    window = np.hanning(max(16, round(FRAME * rate)))
    padded = np.pad(np.asarray(samples, float), (0, max(0, len(window) - len(samples))))
    transform = ShortTimeFFT(window, max(1, round(STEP * rate)), rate, fft_mode="onesided")
    power = np.abs(transform.stft(padded)) ** 2
    return 10 * np.log10(power[transform.f <= HIGHEST] + 1e-12)
