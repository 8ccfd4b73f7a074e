"""A killable worker process: one job at a time, bounded memory and processor time.

`python -m console.workers.process --pipe=N --worker=NAME`, started by `console.workers.worker`. Pictures, files and
sounds of strangers are decoded here and nowhere else. A worker needs neither files nor network; the console decodes
its answers with their types, so that it never has to trust them.
"""

from __future__ import annotations

import contextlib
import os
import resource
import select
import signal
import socket
import sys
from importlib import import_module
from inspect import getmembers_static
from pathlib import Path
from traceback import format_exception
from typing import Any, Union

import msgspec
from msgspec import structs

from console.workers.job import LENGTH, Job, JobFailure, JobRequest, JobResult, decoder, error_name, job, packed
from core.errors import BeckonError
from core.gate.scheduling import stand_back
from core.heap import Rests, give_back
from core.sentences import code_of

MOST_BYTES = 2**30  # of address space
MORE_BYTES = {"probe": 2**33, "maps": 2**32}  # whose libraries reserve much for their threads; of large maps
MOST_PIXELS = 2**25  # that OpenCV's own readers may announce
NICE_LEVEL = 5
MOST_EXPENDABLE = 800  # of 1000, when memory runs out
REST_S = 20.0  # without a job, until a worker gives back what it can read again
FAULT = "Something went wrong inside Beckon; nothing was lost. The log says more."

WORKERS = {
    "camera": "console.calibration.camera_worker:CameraWorker",
    "laser": "console.calibration.laser_worker:LaserWorker",
    "solver": "console.calibration.solver_worker:SolverWorker",
    "words": "console.speech.transcription_worker:TranscriptionWorker",
    "array": "console.workers.array_worker:ArrayWorker",
    "quality": "console.speech.quality_worker:QualityWorker",
    "people": "console.people.worker:PeopleWorker",
    "look": "console.people.look_worker:LookWorker",
    "experiments": "console.experiments.runs:ExperimentsWorker",
    "recorder": "console.recording.work:RecorderWorker",
    "probe": "console.connection.probe_worker:ProbeWorker",
    "maps": "console.maps.join_worker:JoinWorker",
}


def main() -> None:
    """Work until the console hangs up."""
    given = dict(word.lstrip("-").split("=", 1) for word in sys.argv[1:])
    restrain()
    module, _, name = WORKERS[given["worker"]].partition(":")
    jobs = JobTable(getattr(import_module(module), name)())
    with contextlib.suppress(ValueError, OSError):
        most = MORE_BYTES.get(given["worker"], MOST_BYTES)
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
    with contextlib.suppress(ConnectionError), socket.socket(fileno=int(given["pipe"])) as pipe:
        work(jobs, pipe)


def work(jobs: JobTable, pipe: socket.socket) -> None:
    """Say that this is ready, and do what comes; what nothing is asked of for a while, rests."""
    pipe.sendall(packed(JobResult(None)))
    while True:
        if not select.select([pipe], [], [], REST_S)[0]:
            jobs.rest()
        if (raw := receive(pipe)) is None:
            return
        pipe.sendall(jobs.done(raw))


def restrain() -> None:
    """Modest towards everybody else; before OpenCV is imported, for it reads its limit once."""
    os.environ["OPENCV_IO_MAX_IMAGE_PIXELS"] = str(MOST_PIXELS)
    stand_back()
    os.nice(NICE_LEVEL)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(str(MOST_EXPENDABLE))


class JobTable:
    def __init__(self, worker: object) -> None:
        self._worker = worker
        kinds = (each.kind for _, each in getmembers_static(type(worker)) if isinstance(each, job))
        every: Any = Union[tuple(kinds)]  # noqa: UP007
        self._decoder: msgspec.msgpack.Decoder[JobRequest[Job[Any]]] = decoder(JobRequest[every])

    def rest(self) -> None:
        """Take as little memory as the worker can do with until the next job."""
        if isinstance(self._worker, Rests):
            self._worker.rest()
        give_back()

    def done(self, raw: bytes) -> bytes:
        """One job → its answer, or the sentence that says why not."""
        try:
            request = self._decoder.decode(raw)
            signal.setitimer(signal.ITIMER_PROF, request.budget)  # of processor time; the signal's default is the end
            return packed(JobResult(request.job.work(self._worker, **structs.asdict(request.job))))
        except BeckonError as error:
            return packed(JobFailure(error_name(error), str(error), said=code_of(str(error))))
        except MemoryError:
            return packed(JobFailure("BadInput", "This needs more memory than is allowed; send something smaller."))
        except Exception as fault:
            return packed(JobFailure("Unavailable", FAULT, "".join(format_exception(fault))))
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)


def receive(pipe: socket.socket) -> bytes | None:
    """The next message; None: the console has hung up."""
    head = exactly(pipe, LENGTH.size)
    return None if head is None else exactly(pipe, LENGTH.unpack(head)[0])


def exactly(pipe: socket.socket, count: int) -> bytes | None:
    """So many bytes, or None at the end."""
    parts = bytearray()
    while len(parts) < count:
        part = pipe.recv(min(count - len(parts), 1 << 20))
        if not part:
            return None
        parts += part
    return bytes(parts)


if __name__ == "__main__":
    main()
