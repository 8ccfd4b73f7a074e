"""Find how an array is turned on the robot, from recordings of claps or words from known directions."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TypedDict

from core.errors import BadInput, Refused
from core.files import save
from core.geometry import rotation
from core.message import Array
from core.perception.sound.array_diagnostics import check
from core.perception.sound.array_orientation import Orientation, OrientationWizard, heard_from, oriented
from core.progress import UNSEEN, WorkProgress
from core.recording.sound_file import read_sound
from core.sensors.microphones import MicrophoneArray

DECIMAL_DIGITS = 6
TURNED_PROFILE = "array.toml"  # in --out


class ClapFigures(TypedDict):
    """A recording that was used, as JSON."""

    sound: str  # the file's name
    asked_rad: float
    heard_rad: float
    sd_rad: float
    gap_rad: float


class RefusedClap(TypedDict):
    """A recording that was not used, as JSON."""

    sound: str  # the file's name
    reason: str


class OrientationFigures(TypedDict):
    """An array's orientation on the robot, as JSON."""

    yaw_rad: float
    sd_yaw_rad: float
    mirrored: bool
    residual_rad: float
    claps: list[ClapFigures]
    claps_refused: list[RefusedClap]
    warnings: list[str]
    files: dict[str, str]


def calibrate_array(
    paths: Sequence[Path],
    azimuths: Sequence[float],
    array: MicrophoneArray,
    out: Path | None = None,
    progress: WorkProgress = UNSEEN,
) -> OrientationFigures:
    """One recording for each azimuth [rad] of the robot, 0 ahead and counter-clockwise → the array's orientation.

    `out` receives the profile with its positions turned into the robot's frame. Raises BadInput, and Refused where
    the claps are too few, come from one side, or do not agree.
    """
    if len(paths) != len(azimuths):
        raise BadInput(f"There are {len(paths)} recordings but {len(azimuths)} azimuths; each needs the other.")
    wizard = OrientationWizard()
    refused: list[RefusedClap] = []
    warnings: list[str] = []
    used: list[str] = []
    for path, azimuth in progress.each(list(zip(paths, azimuths, strict=True)), "claps"):
        sound = read_sound(path)
        warnings += [f"{path.name}: {one.sentence}" for one in check(sound, array) if one.serious]
        try:
            reason = wizard.add(azimuth, heard_from(sound, array))
        except BadInput as unclear:
            reason = str(unclear)
        if reason:
            refused.append({"sound": path.name, "reason": reason})
        else:
            used.append(path.name)
    found = wizard.solve()
    if isinstance(found, str):
        reasons = " ".join(f"{one['sound']}: {one['reason']}" for one in refused)
        raise Refused(f"{found} {reasons}".strip())
    claps: list[ClapFigures] = [
        {"sound": name, "asked_rad": one.asked, "heard_rad": one.heard, "sd_rad": one.sd, "gap_rad": one.gap(found)}
        for name, one in zip(used, wizard.claps, strict=True)
    ]
    return {
        "yaw_rad": found.yaw,
        "sd_yaw_rad": found.yaw_sd,
        "mirrored": found.mirrored,
        "residual_rad": found.residual,
        "claps": claps,
        "claps_refused": refused,
        "warnings": warnings,
        "files": {} if out is None else {"profile": write_profile(out, array, found)},
    }


def write_profile(out: Path, array: MicrophoneArray, found: Orientation) -> str:
    """The array in the robot's frame as a profile that `load_array` reads → where it lies."""
    mounted = oriented(array, found)
    turned: Array = mounted.positions.copy()
    turned[:, :2] = turned[:, :2] @ rotation(found.yaw).T
    rows = ",\n".join(f"  {[round(float(value), DECIMAL_DIGITS) for value in row]}" for row in turned)
    name = "".join(letter for letter in array.name if letter.isprintable() and letter not in '"\\')
    lines = [
        f"# Turned by {math.degrees(found.yaw):.1f} deg, known to {math.degrees(2 * found.yaw_sd):.1f} deg (95 %).",
        f'name = "{name}, in the robot\'s frame"',
        f"positions_m = [\n{rows},\n]",
        f"channels = {list(array.channels)}",
        f"speed_of_sound_m_s = {array.speed}",
        f"position_sd_m = {array.position_sd}",
        *([] if array.rate is None else [f"sample_rate_hz = {array.rate}"]),
    ]
    return save(out / TURNED_PROFILE, "\n".join(lines) + "\n")
