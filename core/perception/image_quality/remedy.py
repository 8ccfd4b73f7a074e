"""Choose the preprocessing of a picture before edge detection by its quality."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

from core.errors import BadInput
from core.perception.image_quality.measures import Blur, ExposureMeasure
from core.perception.landmarks.edges import EdgeSettings
from core.perception.landmarks.preprocessing import NOTHING, Preprocessing
from core.setting import Meta, Section


@dataclass(frozen=True)
class PictureSettings(Section):
    """Targets for a picture, and limits of the preprocessing that reaches them."""

    prepare: Annotated[bool, Meta(meaning="false: pictures are judged and used as they come", common=True)] = True
    level: Annotated[float, Meta("", 20, 235, "grey level to which a dark picture is brightened")] = 112.0
    idle: Annotated[float, Meta("", 1, 4, "a correction by a smaller factor is not worth a change")] = 1.25
    gain: Annotated[float, Meta("", 1, 100, "factor by which a picture is brightened, at most")] = 16.0
    gamma: Annotated[float, Meta("", 0.1, 1, "least exponent, where lamps or windows forbid more gain")] = 0.5
    highest: Annotated[float, Meta("", 100, 254, "grey level that the brightest hundredth may reach")] = 245.0
    sharp: Annotated[float, Meta("pixel", 0.1, 10, "sd of a sharp picture's blur")] = 0.9
    contrast: Annotated[float, Meta("", 1, 20, "factor by which weakened gradients are raised, at most")] = 4.0
    clear: Annotated[
        float, Meta("sd", 0.1, 20, "noise of a gradient below Canny's lower threshold; 5 below the upper one")
    ] = 2.1
    along: Annotated[float, Meta("", 1, 20, "factor on Canny's smoothing along upright edges, at most")] = 6.0
    across: Annotated[float, Meta("", 1, 10, "factor on Canny's smoothing across upright edges, at most")] = 2.0
    edge: Annotated[float, Meta("", 0.01, 1, "contrast of an ordinary upright edge, as a share of the light")] = 0.14
    unusable_after: Annotated[float, Meta("s", 0, 60, "unusable pictures until a warning")] = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.level >= self.highest:
            raise BadInput(f"level must lie below highest: {self.level:g} and {self.highest:g}.")


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
