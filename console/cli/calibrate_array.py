"""`beckon calibrate array`: how the microphones are turned on the robot, from claps of known direction."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import add_json, add_out, progress, tell, write, write_json

if TYPE_CHECKING:
    from core.pipelines.calibrate_microphones import OrientationFigures

SIDES_DEG = (0.0, 90.0, 180.0, -90.0)  # [deg]


def add(kinds: Any) -> None:
    """Add the kind to `beckon calibrate`."""
    parser: argparse.ArgumentParser = kinds.add_parser(
        "array", help="how the microphones are turned on the robot, from claps or words of known direction"
    )
    parser.add_argument(
        "sounds", nargs="+", type=Path, metavar="SOUND", help="one recording a direction, WAV, FLAC or Ogg"
    )
    parser.add_argument("--array", required=True, metavar="ARRAY.toml", help="a profile or the name of a known board")
    parser.add_argument(
        "--azimuths",
        type=degrees,
        default=",".join(f"{side:g}" for side in SIDES_DEG),
        metavar="DEG,DEG,…",
        help="where each was recorded from, 0 ahead and 90 left (default 0,90,180,-90)",
    )
    add_out(parser, "where the turned profile goes")
    add_json(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace) -> int:
    """Recordings → the orientation."""
    from core.pipelines.calibrate_microphones import calibrate_array  # scipy takes a moment
    from core.sensors.microphones import load_array

    azimuths = [math.radians(angle) for angle in chosen.azimuths]
    with progress() as shown:
        report = calibrate_array(chosen.sounds, azimuths, load_array(chosen.array), chosen.out, progress=shown)
    if chosen.json:
        for warning in report["warnings"]:
            tell(warning)
        write_json(report)
    else:
        write("\n".join(lines(report)))
    return 0


def lines(report: OrientationFigures) -> list[str]:
    """For people."""
    yaw, doubt = math.degrees(report["yaw_rad"]), math.degrees(2 * report["sd_yaw_rad"])
    down = ", and hangs upside down" if report["mirrored"] else ""
    found = [f"The array is turned by {yaw:.1f}° ± {doubt:.1f}° (95 %){down}."]
    for one in report["claps"]:
        asked, heard, gap = map(math.degrees, (one["asked_rad"], one["heard_rad"], one["gap_rad"]))
        found.append(
            f"  {one['sound']}: from {asked:.0f}°, heard at {heard:.1f}° of the array, misses by {gap:+.1f}°"
        )
    found += [f"  {one['sound']} is left out: {one['reason']}" for one in report["claps_refused"]]
    return found + [f"note: {warning}" for warning in report["warnings"]] + list(report["files"].values())


def degrees(text: str) -> list[float]:
    """'0,90' → angles [deg]."""
    try:
        angles = [float(part) for part in text.split(",")]
    except ValueError:
        angles = [math.nan]
    if not all(-360 <= angle <= 360 for angle in angles):
        raise argparse.ArgumentTypeError("Give angles in degrees with commas between them, as in 0,90,180,-90.")
    return angles
