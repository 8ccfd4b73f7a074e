"""`beckon run`: the console, by default on the simulated robot."""

import argparse
import gc
import sys
from typing import Any

from console.cli.answer import add_command
from console.declared_options import Options, add_options


def add(subcommands: Any) -> None:
    parser = add_command(subcommands, "run", run, "start the console and open it in the browser", json=False)
    add_options(parser)


def run(chosen: argparse.Namespace) -> int:
    if not chosen.log_json:
        sys.stderr.write(f"Starting {chosen.robot}…\n")  # at once: the imports take seconds
        sys.stderr.flush()
    gc.disable()  # what is imported stays, and looking for garbage in it takes a seventh of the start; on in `serve`
    from console.serve import serve  # takes part of a second to import: only here

    serve(Options.of(chosen))
    return 0
