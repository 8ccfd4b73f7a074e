"""Execution of runs: in this process, in several processes, or by the workers of a dask cluster.

Each of them is a `concurrent.futures.Executor`, so that a campaign knows none of them. Libraries for algebra and
pictures have one thread in every worker, and all workers have the same versions: the answers of a run are the same
everywhere on one kind of processor.
"""

import contextlib
import ctypes
import hashlib
import logging
import multiprocessing
import os
import platform
import threading
import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from functools import cache
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Self, TypeVar

import core
from core.errors import Unavailable
from core.install import DISTRIBUTION, install_extra
from core.library_threads import ONE_THREAD

T = TypeVar("T")

RUNS_PER_PROCESS = 8  # that are worth a process of its own: it takes a second to start
CONNECT_S = 10.0  # in which the scheduler of a cluster must answer
PINNED = "OPENBLAS_NUM_THREADS"
TRIMMED = "MALLOC_TRIM_THRESHOLD_"  # by which dask has its workers give freed memory back at once
KEPT_BYTES, MALLOC_OPTIONS = 2**25, (-1, -3)  # M_TRIM_THRESHOLD, M_MMAP_THRESHOLD of glibc


class Workers:
    """The workers of one campaign; a context manager, which starts them when they are first needed."""

    def __init__(self, count: int | None, cluster: str = "", runs: int = 1) -> None:
        """`count`: processes, or the most workers of a cluster; None: as many as there are, if `runs` are worth it.

        Raises Unavailable where the cluster does not answer, has no workers, or has workers of other versions.
        """
        self._cluster = None if not cluster else _Cluster(cluster, count)
        here = count or min(os.cpu_count() or 1, -(-runs // RUNS_PER_PROCESS))
        self.count = min(here, runs) if self._cluster is None else self._cluster.count
        self._executor: Executor | None = None

    @property
    def executor(self) -> Executor:
        """The executor; a new one where the last was broken."""
        if self._executor is None:
            self._executor = self._started()
        return self._executor

    def discard(self) -> None:
        """The system has killed a process of the executor: begin with a new one."""
        if self._executor is not None:
            if self._cluster is None:
                self._executor.shutdown(wait=False, cancel_futures=True)
            else:
                self._executor.shutdown(wait=False)  # of dask: cancels what it has
            self._executor = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.discard()
        if self._cluster is not None:
            self._cluster.close()

    def _started(self) -> Executor:
        if self._cluster is not None:
            return self._cluster.executor()
        if self.count <= 1:
            return InPlaceExecutor()
        os.environ.update({**ONE_THREAD})
        return ProcessPoolExecutor(
            self.count, mp_context=multiprocessing.get_context("spawn"), initializer=end_with_parent
        )


class InPlaceExecutor(Executor):
    """Carries out what is submitted at once, in this process."""

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Return a future that is done; what `fn` raises is raised."""
        future: Future[T] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


class _Cluster:
    """A connection to a scheduler of dask, whose workers were checked."""

    def __init__(self, address: str, at_most: int | None) -> None:
        try:
            distributed = import_module("distributed")
        except ImportError:
            raise Unavailable(f"Clusters need the extra cluster: {install_extra('cluster')}") from None
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # a killed worker gets a sentence
        try:
            self._client: Any = distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError, ImportError, AttributeError):
            raise Unavailable(
                f"No scheduler of dask answers at {address}; start one there with `dask scheduler`."
            ) from None
        try:
            threads: dict[str, int] = self._client.nthreads()
            self._chosen = sorted(threads)[:at_most]
            self.count = len(self._chosen)
            self._check(address, threads)
        except BaseException:
            self.close()
            raise

    def executor(self) -> Executor:
        """Return what hands runs to the workers."""
        return self._client.get_executor(pure=False, workers=self._chosen, allow_other_workers=True)

    def close(self) -> None:
        """Leave the cluster as it is."""
        self._client.close(timeout=CONNECT_S)

    def _check(self, address: str, threads: dict[str, int]) -> None:
        if not self._chosen:
            raise Unavailable(
                f"The cluster at {address} has no workers; start some with `dask worker {address} --nthreads 1`."
            )
        for worker in self._chosen:
            if threads[worker] != 1:
                raise Unavailable(
                    f"The worker {worker} does {threads[worker]} runs at once in one process; start it with "
                    f"`dask worker {address} --nworkers {threads[worker]} --nthreads 1`."
                )
        found: dict[str, Any] = self._client.run(worker_facts, workers=self._chosen, on_error="return")
        for worker in self._chosen:
            if (differs := difference(versions(), found[worker])) is not None:
                raise Unavailable(f"The worker {worker} {differs}")


def versions() -> dict[str, str]:
    """Versions on which the figures of a run depend, in this process."""
    import cv2
    import numpy

    return {
        "Beckon": _source(),
        "Python": ".".join(platform.python_version_tuple()[:2]),
        "NumPy": numpy.__version__,
        "OpenCV": cv2.__version__,
    }


def worker_facts() -> tuple[dict[str, str], bool]:
    """The versions of a worker, and whether its libraries keep to one thread."""
    return versions(), os.environ.get(PINNED) == "1"


def difference(ours: dict[str, str], theirs: object) -> str | None:
    """How a worker differs, as the end of a sentence; None: not at all. `theirs` may be what it raised."""
    if not isinstance(theirs, tuple):
        return f"cannot run Beckon ({theirs}); install the same Beckon in its environment."
    found, pinned = theirs
    if not pinned:
        return f"does not keep its libraries to one thread; start it with its nanny, or with {PINNED}=1."
    for name, value in ours.items():
        if value != found[name]:
            return f"has {name} {found[name]}, and here it is {value}; install the same version on both."
    return None


def timed(work: Callable[[int], T], number: int, source: str) -> tuple[T, float]:
    """Carry out a run → its answer, and the processor time [s] that it took. Raises Unavailable for other sources."""
    if _source() != source:
        raise Unavailable(f"A worker on {platform.node()} has Beckon {_source()}, and the campaign has {source}.")
    keep_freed_memory()
    began = time.process_time()
    answer = work(number)
    return answer, time.process_time() - began


@cache
def keep_freed_memory() -> None:
    """Let a worker of dask keep the memory of arrays: fetching it again took two thirds of its processor time."""
    if TRIMMED in os.environ:
        with contextlib.suppress(AttributeError, OSError, TypeError):  # another C library
            mallopt = ctypes.CDLL(None).mallopt
            for option in MALLOC_OPTIONS:
                mallopt(option, KEPT_BYTES)


def killed(error: BaseException) -> bool:
    """Return whether that says that the system killed the worker of a run."""
    return isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker"  # of distributed


def end_with_parent() -> None:
    """In a process of a pool: end when the process that started it is gone."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@cache
def _source() -> str:
    folder = Path(core.__file__).parent
    checksum = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        checksum.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
    try:
        installed = version(DISTRIBUTION)
    except PackageNotFoundError:
        installed = "0"
    return f"{installed}+{checksum.hexdigest()[:12]}"
