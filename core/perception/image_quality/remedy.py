"""Choose the preprocessing of a picture before edge detection by its quality."""

import math
from dataclasses import dataclass, replace
from typing import Annotated

from core.perception.image_quality.measures import Blur, ExposureMeasure
from core.perception.landmarks.edges import EdgeSettings
from core.perception.landmarks.preprocessing import NOTHING, Preprocessing
from core.setting import Meta, Section, ThresholdSet


@dataclass(frozen=True)
class PictureThresholds(ThresholdSet):
    """Targets of the preprocessing, and how far it goes."""

    level: float = 112.0  # grey level to which a dark picture is brightened
    idle: float = 1.25  # a correction by a smaller factor is not worth a change
    gain: float = 16.0  # factor by which a picture is brightened, at most
    gamma: float = 0.5  # least exponent, where lamps or windows forbid more gain
    highest: float = 245.0  # grey level that the brightest hundredth may reach
    sharp: float = 0.9  # [pixel] sd of a sharp picture's blur
    contrast: float = 4.0  # factor by which weakened gradients are raised, at most
    clear: float = 2.1  # [sd] noise of a gradient below Canny's lower threshold; 5 below the upper one
    along: float = 6.0  # factor on Canny's smoothing along upright edges, at most
    across: float = 2.0  # factor on Canny's smoothing across upright edges, at most
    edge: float = 0.14  # contrast of an ordinary upright edge, as a share of the light


@dataclass(frozen=True)
class PictureSettings(PictureThresholds, Section):
    """Targets for a picture, and limits of the preprocessing that reaches them.

    Watch:
        prepare: edges and persons found in poor light
        unusable_after: warnings of a covered or dark camera
    """

    prepare: Annotated[bool, Meta(meaning="false: pictures are judged and used as they come", common=True)] = True
    unusable_after: Annotated[float, Meta("s", 0, 60, "unusable pictures until a warning")] = 1.0


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
