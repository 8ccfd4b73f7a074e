"""The worker that looks at an array's sound: is it wired as its profile says, and where did a clap come from?"""

from __future__ import annotations

from console.workers.array_jobs import CheckArray, FindClap, HeardAzimuth
from console.workers.job import Handler
from core.perception.sound.array_diagnostics import ArrayFault, check
from core.perception.sound.array_orientation import heard_from


class ArrayWorker:
    """Remembers nothing from one recording to the next."""

    @property
    def handlers(self) -> tuple[Handler, ...]:
        """Every job it knows."""
        return CheckArray.handled_by(self.check), FindClap.handled_by(self.find_clap)

    def check(self, job: CheckArray) -> tuple[ArrayFault, ...]:
        """Look for channels that are identical, dead, faint, swapped or clipped."""
        return check(job.sound.sound, job.array.array)

    def find_clap(self, job: FindClap) -> HeardAzimuth:
        """Find the direction of a clap."""
        found = heard_from(job.sound.sound, job.array.array)
        return HeardAzimuth(found.azimuth, found.azimuth_sd, found.strength)
