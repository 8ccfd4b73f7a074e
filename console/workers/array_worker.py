"""The worker that looks at an array's sound: is it wired as its profile says, and where did a clap come from?"""

from console.workers.job import job
from core.perception.sound.array_diagnostics import ArrayFault, check
from core.perception.sound.array_orientation import Clap, heard_from
from core.sensors.microphones import MicrophoneArray, Sound


class ArrayWorker:
    """Remembers nothing from one recording to the next."""

    @job
    def check(self, sound: Sound, array: MicrophoneArray) -> tuple[ArrayFault, ...]:
        """A recording with some speech in it → channels that are identical, dead, faint, swapped or clipped.

        Raises BadInput.
        """
        return check(sound, array)

    @job
    def find_clap(self, sound: Sound, array: MicrophoneArray, asked: float) -> Clap:
        """A recording with a clap or a word, `asked` for at [rad, robot frame] → where it was. Raises BadInput."""
        found = heard_from(sound, array)
        return Clap(asked=asked, heard=found.azimuth, sd=found.azimuth_sd)
