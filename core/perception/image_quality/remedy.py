"""Choose the preprocessing of a picture before edge detection by its quality."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from core.perception.image_quality.measures import Blur, ExposureMeasure
from core.perception.landmarks.edges import EdgeSettings
from core.perception.landmarks.preprocessing import NOTHING, Preprocessing


@dataclass(frozen=True)
class PictureSettings:
    """Targets for a picture, and limits of the preprocessing that reaches them."""

    prepare: bool = True  # False: pictures are judged, and edges looked for in them as they come
    level: float = 112.0  # grey level to which a dark picture is brightened
    idle: float = 1.25  # a factor nearer to 1 than this is not worth a change
    gain: float = 16.0  # at most
    gamma: float = 0.5  # at least: lifts the darks where lamps or windows forbid more gain
    highest: float = 245.0  # grey level that the brightest hundredth may reach
    sharp: float = 0.9  # [pixel] sd of the blur of a picture that is as sharp as it ought to be
    contrast: float = 4.0  # by which weakened gradients are raised, at most
    clear: float = 2.1  # sd of a gradient's noise under Canny's lower threshold: 5 under the upper one
    along: float = 6.0  # times Canny's smoothing, along upright edges at most
    across: float = 2.0  # and across them
    edge: float = 0.14  # contrast of an ordinary upright edge, as a share of the light
    unusable_after: float = 1.0  # [s] of unusable pictures until the operator is notified


def prepare_for(
    light: ExposureMeasure, noise: float, blur: Blur, settings: PictureSettings, edges: EdgeSettings
) -> Preprocessing:
    """Choose the preprocessing for this light, this noise [grey levels] and this blur.

    First the light; then the contrast that the blur took; then smoothing until the noise of a gradient lies `clear`
    times under Canny's lower threshold: along upright edges first, which costs them nothing, across them where that
    is not enough. Where both are used up, contrast is given back rather than noise taken for edges.
    """
    lit = _lit(light, settings)
    grown = noise * lit.slope(light.level)
    width = blur.across or 0.0
    wanted = max(1.0, math.hypot(edges.blur, width) / math.hypot(edges.blur, settings.sharp))
    wanted = 1.0 if wanted < settings.idle else min(wanted, settings.contrast)
    allowed = edges.canny_low / 8 / (settings.clear * max(grown, 1e-6) * gradient_noise(edges.blur, edges.blur))
    need = wanted / allowed  # by this factor the noise must shrink
    if need < settings.idle:
        return replace(lit, contrast=wanted)
    along = min(max(1.0, need**2), settings.along)
    need /= math.sqrt(along)
    across = min(max(1.0, need ** (2 / 3)), settings.across)
    need /= across**1.5
    return replace(lit, contrast=wanted / max(1.0, need), along=along, across=across)


def gradient_noise(across: float, along: float) -> float:
    """Sd of the slope of white noise of sd 1 after a Gaussian smoothing by these sd [pixel]."""
    return 1 / math.sqrt(8 * math.pi * across**3 * along)


def _lit(light: ExposureMeasure, settings: PictureSettings) -> Preprocessing:
    """Gain, and gamma where the brightest parts forbid more gain."""
    wanted = settings.level / max(light.level, 1e-3)
    if wanted < settings.idle:
        return NOTHING
    gain = max(1.0, min(wanted, settings.gain, settings.highest / max(light.high, 1.0)))
    reached = min(max(gain * light.level, 1.0), 250.0)
    gamma = math.log(settings.level / 255) / math.log(reached / 255)
    gamma = min(1.0, max(settings.gamma, gamma))
    return Preprocessing(gain=gain, gamma=gamma if gamma < 1 / settings.idle else 1.0)
