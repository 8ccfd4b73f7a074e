"""The worker that looks at an array's sound: is it wired as its profile says, and where did a clap come from?"""

from console.workers.job import Job
from core.perception.sound.array_diagnostics import ArrayFault, check
from core.perception.sound.array_orientation import Clap, heard_from
from core.sensors.microphones import MicrophoneArray, Sound


class CheckArray(Job[tuple[ArrayFault, ...]], frozen=True):
    """A recording with some speech in it → everything that looks wrong. Raises BadInput."""

    sound: Sound
    array: MicrophoneArray


class FindClap(Job[Clap], frozen=True):
    """A recording with a clap or a word in it, which was `asked` for [rad, robot frame]. Raises BadInput."""

    sound: Sound
    array: MicrophoneArray
    asked: float


class ArrayWorker:
    """Remembers nothing from one recording to the next."""

    def check(self, job: CheckArray) -> tuple[ArrayFault, ...]:
        """Look for channels that are identical, dead, faint, swapped or clipped."""
        return check(job.sound, job.array)

    def find_clap(self, job: FindClap) -> Clap:
        found = heard_from(job.sound, job.array)
        return Clap(asked=job.asked, heard=found.azimuth, sd=found.azimuth_sd)
