"""What a caller's voice could add at most: `python -m tests.benchmarks.caller_known --seed 20 --runs 2`.

The drives of `beckon experiment audio-visual` in the places where the laser is weak. The place of the person who
calls is known to a centimetre from the first frame, which no robot has: whatever makes a landmark of the voice, and
however early, comes after it. Every drive prints the laser's mean error, that with this knowledge, and NEES.
"""

import numpy as np

from core.experiments.audio_visual import PLACES, Place, RowErrors, drive
from core.pilot import Pilot
from core.settings import Settings
from core.slam.bearings.bearing_landmarks import BearingLandmark, Track
from tests.benchmarks.command import print_row, run_command

KNOWN = 0.01  # [m] sd of the place
LASER, VOICE = "laser", "laser + voice"


def know(pilot: Pilot, place: Place) -> None:
    """Give a pilot at the origin the place of the person who will call, as a landmark that is followed."""
    voices = pilot._mapper.submaps.active.voices
    state = voices._state
    point = state.attach(np.array(place.speaker), np.zeros((2, state.covariance.size)), KNOWN**2 * np.eye(2))
    landmark = BearingLandmark(point, look=0.0, seen=0.0)
    voices.landmarks.append(landmark)
    angle = float(np.arctan2(place.speaker[1], place.speaker[0]))
    voices._tracks.append(Track(angle, look=0.0, seen=0.0, landmark=landmark))


def row(place: Place, seed: int) -> str:
    found = drive(place, Settings(), seed, (LASER, VOICE), lambda pilots: know(pilots[VOICE], place))
    laser, voice = found[LASER], found[VOICE]
    assert isinstance(laser, RowErrors)
    assert isinstance(voice, RowErrors)
    less = 100 * (voice.mean / laser.mean - 1)
    return (
        f"{place.name:20} seed {seed}: laser {laser.mean:.3f} m, caller known {voice.mean:.3f} m ({less:+.0f} %), "
        f"NEES {laser.nees:.1f} and {voice.nees:.1f}"
    )


def main(*, seed: int = 20, runs: int = 2) -> None:
    for place in PLACES:
        for number in range(seed, seed + runs):
            if place.weak:
                print_row(f"{row(place, number)}")


if __name__ == "__main__":
    run_command(main)
