"""Picture quality and the mount's drift → what every viewer gets."""

from __future__ import annotations

from console import wire_sight as wire
from core.calibration.drift import Drift
from core.perception.picture_quality import PictureQuality


def quality(judged: PictureQuality | None) -> wire.PictureQuality | None:
    """How good the newest picture is."""
    if judged is None:
        return None
    light, blur, done = judged.light, judged.blur, judged.preparation
    return wire.PictureQuality(
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


def drift(seen: Drift | None) -> wire.CalibrationDrift | None:
    """Whether the camera still sits as it was calibrated."""
    if seen is None:
        return None
    return wire.CalibrationDrift(
        turn_rad=round(seen.turn, 5),
        turn_sd_rad=round(seen.turn_sd, 5),
        apparent_rad=round(seen.apparent, 5),
        apparent_sd_rad=round(seen.apparent_sd, 5),
        shift_m=round(seen.shift, 4),
        shift_sd_m=round(seen.shift_sd, 4),
        pairs=seen.pairs,
        corners=seen.corners,
        alarm=seen.alarm,
        words=seen.words,
    )
