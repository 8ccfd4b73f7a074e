"""`beckon backup` and `beckon restore`: the data folder as one file, and back."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import add_command, answer, tell

if TYPE_CHECKING:
    from console.backup import BackupReport

BYTES_PER_MB = 1e6


def add(subcommands: Any) -> None:
    keeping = add_command(
        subcommands, "backup", backup, "history, maps, calibrations, people, keys and settings as one file"
    )
    keeping.add_argument("--recordings", action="store_true", help="recordings, too")
    returning = add_command(subcommands, "restore", restore, "put a backup into a data folder")
    returning.add_argument(
        "--replace", action="store_true", help="also where something is; that moves into its folder before-restore"
    )
    for parser in (keeping, returning):
        parser.add_argument("file", type=Path, metavar="FILE", help="such as beckon.tar.gz")
        parser.add_argument("--data", type=Path, metavar="DIR", help="the console's data folder")


def backup(chosen: argparse.Namespace) -> int:
    """Write the file. Raises BadInput, Unwritable."""
    from console.backup import write_backup
    from console.data_folder import home_folder

    report = write_backup(home_folder(chosen.data), chosen.file, recordings=chosen.recordings)
    show(
        chosen,
        report,
        f"{report.files} files are kept in {report.file} ({report.bytes / BYTES_PER_MB:.1f} MB before packing).",
    )
    if report.left_out and not chosen.json:
        tell("Recordings are not in it; with --recordings they are.")
    return 0


def restore(chosen: argparse.Namespace) -> int:
    """Put it back. Raises BadInput, Unavailable, Unwritable."""
    from console.backup import restore_backup
    from console.data_folder import home_folder

    home = home_folder(chosen.data)
    report = restore_backup(chosen.file, home, replace=chosen.replace)
    return show(chosen, report, f"{report.files} files of {report.file} are in {home}.")


def show(chosen: argparse.Namespace, report: BackupReport, sentence: str) -> int:
    row = {"file": str(report.file), "files": report.files, "bytes": report.bytes}
    return answer(chosen, {**row, "left_out": list(report.left_out)}, sentence)
