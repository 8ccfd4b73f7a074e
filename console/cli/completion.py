"""`beckon completion`: a script that lets the shell complete Beckon's subcommands, options and files."""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

from console.cli.answer import add_command, write

SHELLS = ("bash", "zsh", "tcsh")
FILES = ("LOG", "ARRAY.toml")  # arguments that are files, or something else


def add(subcommands: Any) -> None:
    parser = add_command(subcommands, "completion", run, "print a shell's completion script", json=False)
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=", ".join(SHELLS))


def run(chosen: argparse.Namespace) -> int:
    write(script(chosen.shell))
    return 0


def script(shell: str) -> str:
    """Write the completion of the whole command line for one of `SHELLS`."""
    import shtab  # only where it is needed

    from console.cli import build_parser  # which holds this subcommand too

    parser = build_parser()
    for argument in arguments(parser):
        name = argument.metavar if isinstance(argument.metavar, str) else ""
        if argument.type is Path or name in FILES:
            setattr(argument, "complete", shtab.DIRECTORY if name == "DIR" else shtab.FILE)  # noqa: B010
    return shtab.complete(parser, shell)


def arguments(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:
        yield action
        if isinstance(action.choices, dict):
            for nested in cast(dict[str, argparse.ArgumentParser], action.choices).values():
                yield from arguments(nested)
