"""What goes over the socket of the camera beside its pictures: how good they are, and whether its mount has moved."""

from __future__ import annotations

import msgspec

from core.perception.picture_quality import PictureState

Struct = msgspec.Struct


class PictureQuality(Struct):
    """How good the newest picture is, and what was done about it; grey levels are 0..255."""

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


class CalibrationDrift(Struct):
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
