"""The subcommands of `beckon`, one file each: `add` to the parser, `run` when chosen."""

import argparse
import sys
from importlib import import_module
from typing import NoReturn

from console import beckon_version
from core.errors import BadSettings

SUBCOMMANDS = [
    "run",
    "fleet",
    "robots",
    "robot",
    "calibrate",
    "correct",
    "record",
    "slam",
    "hear",
    "listen",
    "look",
    "understand",
    "speech_quality",
    "experiment",
    "models",
    "settings",
    "link",
    "token",
    "backup",
    "openapi",
    "doctor",
    "completion",
]
"""Modules of this folder, in the order of the help."""


class CommandParser(argparse.ArgumentParser):
    """A parser, and those of its subcommands, whose refusals are answered as all others are."""

    def error(self, message: str) -> NoReturn:
        """Refuse arguments. Raises BadSettings."""
        self.print_usage(sys.stderr)
        sentence = message[:1].upper() + message[1:].removesuffix(".")
        raise BadSettings(f"{sentence}. {self.prog} --help shows how it is used.")


def build_parser() -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="beckon", description="A console for a mobile robot that sees, hears and obeys. Without a command: run."
    )
    parser.add_argument("--version", action="version", version=f"beckon {beckon_version()}")
    subcommands = parser.add_subparsers(dest="subcommand", metavar="COMMAND")
    for name in SUBCOMMANDS:
        import_module(f"console.cli.{name}").add(subcommands)
    return parser
