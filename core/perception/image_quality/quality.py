"""Picture quality: exposure, noise, blur, what is done about them, and all that in words (section 5)."""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import cv2

from core.message import message
from core.perception.image_quality.measures import Blur, ExposureMeasure, blur, exposure, noise_sd
from core.perception.landmarks.edges import NOTHING, EdgeSettings, Preprocessing
from core.sensors import Image
from core.setting import Meta, Section


@dataclass(frozen=True)
class PictureSettings(Section):
    """Targets for a picture, and limits of the preprocessing that reaches them.

    Watch:
        prepare: edges and persons found in poor light
        unusable_after: warnings of a covered or dark camera
    """

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
    wanted = settings.level / max(light.level, 1e-3)
    if wanted < settings.idle:
        return NOTHING
    gain = max(1.0, min(wanted, settings.gain, settings.highest / max(light.high, 1.0)))
    reached = min(max(gain * light.level, 1.0), 250.0)
    gamma = math.log(settings.level / 255) / math.log(reached / 255)
    gamma = min(1.0, max(settings.gamma, gamma))
    return Preprocessing(gain=gain, gamma=gamma if gamma < 1 / settings.idle else 1.0)


MAX_WHITE_SHARE = 0.1  # share of white pixels beyond which it is said
BLACKOUT_GREY = 5.0  # grey level: where not even the brightest parts reach it there is nothing to see
BLUNT_RATIO = 2.0  # times the blur of a sharp picture beyond which it is said, whatever is done


@message
class PictureFault:
    """One thing that is wrong with a picture."""

    label: str  # "dark"
    what: str  # "too dark"
    done: str = ""  # "brightened"
    advice: str  # "turn on a light"


@message
class MotionSmear:
    """Motion that may have smeared the picture."""

    sideways: bool  # upright edges are wider than level ones
    turning: bool  # the robot turned meanwhile


def faults(
    light: ExposureMeasure, width: float, motion: MotionSmear, done: Preprocessing, settings: PictureSettings
) -> tuple[PictureFault, ...]:
    """Light, blur [pixel] and what was done → what is wrong, the light first."""
    found: list[PictureFault] = []
    if light.bright_share > MAX_WHITE_SHARE:
        found.append(
            PictureFault(
                label="bright", what="too bright", advice="turn the camera away from the light or close a blind"
            )
        )
    elif light.high < BLACKOUT_GREY:
        covered = "see whether something covers the lens, or switch on a light"
        return (PictureFault(label="dark", what="black", advice=covered),)
    elif light.level < settings.level / settings.idle:
        lit = done.gain > 1 or done.gamma < 1
        found.append(
            PictureFault(
                label="dark", what="too dark", done="brightened" if lit else "", advice="give the robot more light"
            )
        )
    if done.contrast > 1 or width > BLUNT_RATIO * settings.sharp:
        raised = "contrast raised" if done.contrast > 1 else ""
        what, advice = "blurred", "clean the lens and focus it"
        if motion.sideways and motion.turning:
            what = "blurred by turning too fast for the exposure"
            advice = "turn more slowly or give the robot more light"
        elif motion.sideways:
            what = "blurred sideways by moving too fast for the exposure"
            advice = "drive more slowly or give the robot more light"
        found.append(PictureFault(label="blurred", what=what, done=raised, advice=advice))
    if done.along > 1:
        found.append(PictureFault(label="noisy", what="noisy", done="smoothed", advice="give the robot more light"))
    return tuple(found)


def label(found: tuple[PictureFault, ...], good: bool) -> str:
    """One word for it."""
    return found[0].label if found else "good" if good else "dull"


def verdict(found: tuple[PictureFault, ...], good: bool) -> str:
    """The faults and what was done about them, as sentences."""
    if not found:
        return "Good." if good else "Little contrast."
    said = [f"{fault.what}: {fault.done}." if fault.done else f"{fault.what}." for fault in found]
    return " ".join(one[0].upper() + one[1:] for one in said)


def complaint(found: tuple[PictureFault, ...]) -> str:
    """One sentence: why the pictures cannot be used and what to do."""
    why = " and ".join(fault.what for fault in found) or "too little contrast"
    advice = found[0].advice if found else "see whether something covers the lens"
    return f"The camera's pictures cannot be used: {why}. Please {advice}."


PictureState = Literal["good", "mended", "poor", "unusable"]
WHITE_OUT = 0.5  # share of white pixels beyond which a picture is unusable
SMEARED_RATIO = 1.6  # times the blur of level edges: beyond, it is motion
MIN_SMEAR_SD_PX = 1.2  # sd below which no direction is reported
TURNING_RAD_S = 0.05  # beyond which motion blur is put down to the turn


@message
class PictureQuality:
    """The quality of one picture, and what was done about it."""

    light: ExposureMeasure
    noise: float  # [grey levels] sd
    snr: float  # [dB] of the light against the noise
    blur: Blur
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
    smeared = across > MIN_SMEAR_SD_PX and down is not None and across > SMEARED_RATIO * max(down, 0.5)
    wanted = prepare_for(light, noise, width, settings, edges)
    done = wanted if settings.prepare else NOTHING
    margin = _margin(light, noise, across, done, settings, edges)
    state = _state(light, margin, done, edges)
    motion = MotionSmear(sideways=smeared, turning=abs(turn_rate) > TURNING_RAD_S)
    found = faults(light, across, motion, done, settings)
    return PictureQuality(
        light=light,
        noise=noise,
        snr=20 * math.log10(max(light.level, 0.1) / noise),
        blur=width,
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
    if margin < edges.canny_high / edges.canny_low or light.bright_share > MAX_WHITE_SHARE:
        return "poor"
    return "good" if done.idle else "mended"
