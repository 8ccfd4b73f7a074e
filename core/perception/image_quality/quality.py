"""Picture quality: exposure, noise, blur, what is done about them, and all that in words (section 5)."""

from __future__ import annotations

import math
from typing import Literal

import cv2

from core.message import message
from core.perception.image_quality.explanation import GLARE, MotionSmear, complaint, faults, label, verdict
from core.perception.image_quality.measures import Blur, ExposureMeasure, blur, exposure, noise_sd
from core.perception.image_quality.remedy import PictureSettings, gradient_noise, prepare_for
from core.perception.landmarks.edges import EdgeSettings
from core.perception.landmarks.preprocessing import NOTHING, Preprocessing
from core.sensors import Image

PictureState = Literal["good", "mended", "poor", "unusable"]
WHITE_OUT = 0.5  # share of white pixels beyond which a picture is unusable
SMEARED = 1.6  # times the blur of level edges: beyond, it is motion
SMEAR = 1.2  # [pixel] sd below which no direction is reported
TURNING = 0.05  # [rad/s] beyond which motion blur is put down to the turn


@message
class PictureQuality:
    """The quality of one picture, and what was done about it."""

    light: ExposureMeasure
    noise: float  # [grey levels] sd
    snr: float  # [dB] of the light against the noise
    blur: Blur
    smeared: bool  # sideways, by motion
    preparation: Preprocessing
    margin: float  # of an ordinary upright edge over what can be found; below 1 it is lost
    state: PictureState
    label: str  # one word: good, dark, bright, blurred, noisy, dull
    words: str  # the verdict and what was done, in sentences
    complaint: str  # why it is unusable and what to do; empty while it can be used


def judge(
    image: Image,
    *,
    turn_rate: float = 0.0,
    settings: PictureSettings | None = None,
    edges: EdgeSettings | None = None,
) -> PictureQuality:
    """Picture, and how fast the robot turns [rad/s] → its quality. The picture itself is not changed."""
    settings, edges = settings or PictureSettings(), edges or EdgeSettings()
    grey = cv2.cvtColor(image.pixels, cv2.COLOR_BGR2GRAY) if image.pixels.ndim == 3 else image.pixels
    light, noise = exposure(grey), noise_sd(grey)
    width = blur(grey, noise)
    across, down = width.across or 0.0, width.down
    smeared = across > SMEAR and down is not None and across > SMEARED * max(down, 0.5)
    wanted = prepare_for(light, noise, width, settings, edges)
    done = wanted if settings.prepare else NOTHING
    margin = _margin(light, noise, across, done, settings, edges)
    state = _state(light, margin, done, edges)
    motion = MotionSmear(sideways=smeared, turning=abs(turn_rate) > TURNING)
    found = faults(light, across, motion, done, settings)
    return PictureQuality(
        light=light,
        noise=noise,
        snr=20 * math.log10(max(light.level, 0.1) / noise),
        blur=width,
        smeared=smeared,
        preparation=done,
        margin=margin,
        state=state,
        label=label(found, state == "good"),
        words=verdict(found, state == "good"),
        complaint=complaint(found) if state == "unusable" else "",
    )


def _margin(
    light: ExposureMeasure,
    noise: float,
    width: float,
    done: Preprocessing,
    settings: PictureSettings,
    edges: EdgeSettings,
) -> float:
    """The slope of an ordinary upright edge over the least that is found: Canny's lower threshold, and the noise."""
    across, along = edges.blur * done.across, edges.blur * done.along
    slope = done.slope(light.level)
    steep = settings.edge * light.level * slope / (math.sqrt(2 * math.pi) * math.hypot(across, width))
    seen = done.contrast * steep / (edges.canny_low / 8)
    above_noise = steep / (settings.clear * noise * slope * gradient_noise(across, along))
    return min(seen, above_noise)


def _state(light: ExposureMeasure, margin: float, done: Preprocessing, edges: EdgeSettings) -> PictureState:
    if margin < 1 or light.bright_share > WHITE_OUT:
        return "unusable"
    if margin < edges.canny_high / edges.canny_low or light.bright_share > GLARE:
        return "poor"
    return "good" if done.idle else "mended"
