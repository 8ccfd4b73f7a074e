"""Explain in words the faults of a picture, the preprocessing and what the operator can do."""

from __future__ import annotations

from core.message import message
from core.perception.image_quality.measures import ExposureMeasure
from core.perception.image_quality.remedy import PictureSettings
from core.perception.landmarks.preprocessing import Preprocessing

GLARE = 0.1  # share of white pixels beyond which it is said
BLACKOUT = 5.0  # grey level: where not even the brightest parts reach it there is nothing to see
BLUNT = 2.0  # times the blur of a sharp picture beyond which it is said, whatever is done


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
    if light.bright_share > GLARE:
        found.append(
            PictureFault(
                label="bright", what="too bright", advice="turn the camera away from the light or close a blind"
            )
        )
    elif light.high < BLACKOUT:
        covered = "see whether something covers the lens, or switch on a light"
        return (PictureFault(label="dark", what="black", advice=covered),)
    elif light.level < settings.level / settings.idle:
        lit = done.gain > 1 or done.gamma < 1
        found.append(
            PictureFault(
                label="dark", what="too dark", done="brightened" if lit else "", advice="give the robot more light"
            )
        )
    if done.contrast > 1 or width > BLUNT * settings.sharp:
        raised = "contrast raised" if done.contrast > 1 else ""
        if motion.sideways and motion.turning:
            slower = "turn more slowly or give the robot more light"
            found.append(
                PictureFault(
                    label="blurred", what="blurred by turning too fast for the exposure", done=raised, advice=slower
                )
            )
        elif motion.sideways:
            slower = "drive more slowly or give the robot more light"
            found.append(
                PictureFault(
                    label="blurred",
                    what="blurred sideways by moving too fast for the exposure",
                    done=raised,
                    advice=slower,
                )
            )
        else:
            found.append(
                PictureFault(label="blurred", what="blurred", done=raised, advice="clean the lens and focus it")
            )
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
