"""A killable worker process: one job at a time, bounded memory and processor time.

`python -m console.workers.process --pipe=N --worker=NAME`, started by `console.workers.worker`. What strangers send
is decoded here and nowhere else. A worker needs neither files nor network; its answers are plain values, so that the
console never has to trust them.
"""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import socket
import struct
import sys
from importlib import import_module
from pathlib import Path
from traceback import format_exception
from typing import Any

import msgspec

from core.gate.scheduling import stand_back

LENGTH = struct.Struct("<I")
MOST_BYTES = 2**30  # of address space
MOST_PIXELS = 2**25  # that OpenCV's own readers may announce
NICE = 5
MOST_EXPENDABLE = 800  # of 1000, when memory runs out
TOO_LARGE = "This needs more memory than is allowed; send something smaller."
FAULT = "Something went wrong inside Beckon; nothing was lost. The log says more."

WORKERS = {
    "camera": "console.calibration.camera_worker:CameraWorker",
    "laser": "console.calibration.laser_worker:LaserWorker",
    "solver": "console.calibration.solver_worker:SolverWorker",
    "words": "console.speech.transcription_worker:TranscriptionWorker",
    "array": "console.workers.array_worker:ArrayWorker",
    "quality": "console.speech.quality_worker:QualityWorker",
    "people": "console.people.worker:PeopleWorker",
}


def main() -> None:
    """Work until the console hangs up."""
    given = dict(word.lstrip("-").split("=", 1) for word in sys.argv[1:])
    restrain()
    module, _, name = WORKERS[given["worker"]].partition(":")
    worker = getattr(import_module(module), name)()
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
    with contextlib.suppress(ConnectionError), socket.socket(fileno=int(given["pipe"])) as pipe:
        pipe.sendall(packed({"result": "ready"}))
        while (job := receive(pipe)) is not None:
            pipe.sendall(done(worker, job))


def restrain() -> None:
    """Modest towards everybody else; before OpenCV is imported, for it reads its limit once."""
    os.environ["OPENCV_IO_MAX_IMAGE_PIXELS"] = str(MOST_PIXELS)
    stand_back()
    os.nice(NICE)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(str(MOST_EXPENDABLE))
    import cv2

    cv2.setNumThreads(1)


def done(worker: Any, job: dict[str, Any]) -> bytes:
    """One job → its answer, or the sentence that says why not."""
    from core.errors import BeckonError

    signal.setitimer(signal.ITIMER_PROF, job["budget"])  # of processor time; the signal's default is the end
    try:
        return packed({"result": getattr(worker, job["do"])(**job["given"])})
    except BeckonError as error:
        return packed({"kind": type(error).__name__, "sentence": str(error)})
    except MemoryError:
        return packed({"kind": "BadInput", "sentence": TOO_LARGE})
    except Exception as fault:
        return packed({"kind": "Unavailable", "sentence": FAULT, "details": "".join(format_exception(fault))})
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def packed(message: dict[str, Any]) -> bytes:
    """A message as it goes through the pipe."""
    raw = msgspec.msgpack.encode(message)
    return LENGTH.pack(len(raw)) + raw


def receive(pipe: socket.socket) -> dict[str, Any] | None:
    """The next message; None: the console has hung up."""
    head = exactly(pipe, LENGTH.size)
    raw = None if head is None else exactly(pipe, LENGTH.unpack(head)[0])
    return None if raw is None else msgspec.msgpack.decode(raw)


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
