"""A program that ends with the console: `python -m console.workers.leashed MODULE ARGUMENTS…`.

It leads a session of its own and watches its standard input: when the console closes that, or is gone, it ends with
every process that it started. It stands back behind the robot's own processes.
"""

import os
import resource
import runpy
import signal
import sys
import threading

from core.gate.scheduling import stand_back

NICE_LEVEL = 10


def main() -> None:
    """Run the module as a program of its own."""
    os.nice(NICE_LEVEL)
    stand_back()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    threading.Thread(target=watch, daemon=True).start()
    module, *arguments = sys.argv[1:]
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


def watch() -> None:
    """End everything when the console hangs up."""
    while os.read(0, 64):
        pass
    os.killpg(0, signal.SIGKILL)


if __name__ == "__main__":
    main()
