"""Messages of the camera besides its pictures: how good they are, and whether its mount has moved."""

import msgspec

from console.messages import filled
from core.calibration.laser.drift import Drift
from core.perception.image_quality import quality as image_quality
from core.perception.image_quality.quality import PictureState

Struct = msgspec.Struct


class PictureQualityState(Struct):
    """How good the newest picture is, and how it was corrected; grey levels are 0..255."""

    state: PictureState
    label: str
    words: str
    mean: float
    low: float  # 1 % of the picture is darker
    high: float
    dark_share: float  # 0..1: black
    bright_share: float
    noise_sd: float
    snr_db: float
    blur_px: float | None  # sd, of upright edges
    blur_down_px: float | None
    margin: float  # of an ordinary edge over what can be found
    gain: float
    gamma: float
    contrast: float
    smoothing: float  # along upright edges, times the usual


class CalibrationDriftState(Struct):
    """How the camera's mount seems to differ from the calibration in use."""

    turn_rad: float  # counter-clockwise
    turn_sd_rad: float
    apparent_rad: float  # the turn that looks like turn and shift together at the usual distance: known best
    apparent_sd_rad: float
    shift_m: float  # to the left
    shift_sd_m: float
    pairs: int
    corners: int
    alarm: bool
    words: str


def quality(judged: image_quality.PictureQuality | None) -> PictureQualityState | None:
    if judged is None:
        return None
    light, blur, done = judged.light, judged.blur, judged.preparation
    return PictureQualityState(
        state=judged.state,
        label=judged.label,
        words=judged.words,
        mean=round(light.mean, 1),
        low=round(light.low, 1),
        high=round(light.high, 1),
        dark_share=round(light.dark_share, 4),
        bright_share=round(light.bright_share, 4),
        noise_sd=round(judged.noise, 2),
        snr_db=round(judged.snr, 1),
        blur_px=None if blur.across is None else round(blur.across, 2),
        blur_down_px=None if blur.down is None else round(blur.down, 2),
        margin=round(judged.margin, 2),
        gain=round(done.gain, 2),
        gamma=round(done.gamma, 2),
        contrast=round(done.contrast, 2),
        smoothing=round(done.along, 1),
    )


def drift(seen: Drift | None) -> CalibrationDriftState | None:
    return None if seen is None else filled(CalibrationDriftState, seen, 5)
