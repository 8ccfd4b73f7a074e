"""How long motion goes on after the machine slept: `python -m tests.benchmarks.sleeping [--trials 5]`.

Nothing is really suspended: every process of a console is stopped for some seconds, and a shim takes this time away
from CLOCK_MONOTONIC, as the kernel does in sleep, while CLOCK_BOOTTIME runs on. A C compiler is needed.
"""

import contextlib
import mmap
import os
import signal
import struct
import subprocess
import tempfile
import time
from collections.abc import Generator
from pathlib import Path

import psutil

from core.gate import read_trace
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.running_console import console
from tests.campaign.struck import TraceOnlooker

SLEEP_S = 6.0
WATCHED_S = 4.0
SHIM = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <time.h>
static volatile long long *slept;
static int (*true_clock)(clockid_t, struct timespec *);
__attribute__((constructor)) static void begin(void) {
    true_clock = dlsym(RTLD_NEXT, "clock_gettime");
    int file = open(getenv("SLEEP_FILE"), O_RDONLY | O_CLOEXEC);
    void *page = file < 0 ? MAP_FAILED : mmap(0, 8, PROT_READ, MAP_SHARED, file, 0);
    slept = page == MAP_FAILED ? 0 : page;
}
int clock_gettime(clockid_t which, struct timespec *now) {
    if (!true_clock) true_clock = dlsym(RTLD_NEXT, "clock_gettime");
    int done = true_clock(which, now);
    if (which == CLOCK_MONOTONIC && slept) {
        long long left = now->tv_sec * 1000000000LL + now->tv_nsec - *slept;
        now->tv_sec = left / 1000000000LL;
        now->tv_nsec = left % 1000000000LL;
    }
    return done;
}
"""


@contextlib.contextmanager
def shim() -> Generator[mmap.mmap]:
    """Processes started within have this clock; the page holds the time asleep [ns]."""
    with tempfile.TemporaryDirectory() as folder:
        source, library, told = (Path(folder) / name for name in ("shim.c", "shim.so", "slept"))
        source.write_text(SHIM)
        subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
        told.write_bytes(bytes(8))
        os.environ |= {"LD_PRELOAD": str(library), "SLEEP_FILE": str(told)}
        try:
            with told.open("r+b") as file, mmap.mmap(file.fileno(), 8) as page:
                yield page
        finally:
            del os.environ["LD_PRELOAD"], os.environ["SLEEP_FILE"]


def moves(trace: Path) -> bool:
    """Whether the newest row moves."""
    rows = read_trace(trace)
    return bool(rows) and (abs(rows[-1].v) > 0.05 or abs(rows[-1].w) > 0.05)


def trial(slept: mmap.mmap) -> float:
    """One order, one sleep → for how long rows move after waking [s].

    Each console starts with no time asleep: the kernel's own waits do not know of the shim's clock.
    """
    slept[:8] = bytes(8)
    with console() as running:
        while not moves(running.trace):
            running.post("/api/commands", {"text": "follow wall"})
            until = time.monotonic() + 3.0
            while time.monotonic() < until and not moves(running.trace):
                time.sleep(0.05)
        parent = psutil.Process(running.process.pid)
        family = [parent, *parent.children(recursive=True)]
        for process in family:
            process.send_signal(signal.SIGSTOP)
        stopped = time.monotonic_ns()
        time.sleep(SLEEP_S)
        with TraceOnlooker(running.trace) as onlooker:
            slept[:8] = struct.pack("q", time.monotonic_ns() - stopped)
            woken = time.monotonic_ns()
            for process in family:
                process.send_signal(signal.SIGCONT)
            time.sleep(WATCHED_S)
        return max(0.0, onlooker.last_motion - woken) * 1e-9  # by this clock, which nobody slept through


def main(*, trials: int = 5) -> None:
    with shim() as slept:
        moved = [round(1000 * trial(slept), 1) for _ in range(trials)]
    print_row({"moves_after_waking_ms": moved, "max_ms": max(moved)})


if __name__ == "__main__":
    run_command(main)
