"""The same work on many numbers in several processes; what comes out does not depend on how many."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

from core.library_threads import ONE_THREAD

T = TypeVar("T")

NUMBERS_PER_PROCESS = 8  # numbers that a process of its own is worth: it takes a second to start
PROGRESS_REPORTS = 10  # of the progress


def side_by_side(
    work: Callable[[int], T],
    count: int,
    workers: int | None = None,
    tell: Callable[[str], None] | None = None,
    kept: Callable[[T], None] | None = None,
) -> list[T]:
    """`work` on 0 … count - 1 → the answers in that order. It must come from a module, and know its own chance.

    `workers`: processes; None: as many as the machine has, where they are worth it. `kept`: given every answer as
    soon as it and all before it are there.
    """
    workers = min(workers or min(os.cpu_count() or 1, math.ceil(count / NUMBERS_PER_PROCESS)), count)
    done: list[T] = []
    every = max(1, count // PROGRESS_REPORTS)
    if workers == 1:
        for number in range(count):
            done.append(work(number))
            if kept is not None:
                kept(done[-1])
            _progress(len(done), count, every, tell)
        return done
    os.environ.update(ONE_THREAD | os.environ)  # the processes would stand in each other's way
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        try:
            together = 1 if kept is not None else max(1, min(20, count // (4 * workers)))
            for answer in pool.map(work, range(count), chunksize=together):
                done.append(answer)
                if kept is not None:
                    kept(answer)
                _progress(len(done), count, every, tell)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return done


def _progress(done: int, count: int, every: int, tell: Callable[[str], None] | None) -> None:
    if tell is not None and (done % every == 0 or done == count):
        tell(f"{done} of {count} runs…")
