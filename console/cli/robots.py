"""`beckon robots`: the kinds of robots and devices that can be connected."""

import argparse
from typing import Any, NamedTuple

from console.cli.answer import add_command, answer
from console.cli.doctor import missing_packages
from core.install import install_extra
from core.robots.connect import OWN, SCHEMES, brought

HEAD = ("example", "what", "has", "needs")
MORE = (
    "URL+URL joins devices; the first with a base drives. A file robot.toml describes a robot and names its URL.",
    "Try one with: beckon robot check URL. Write a driver of your own with: beckon robot new NAME.",
)


class SchemeRow(NamedTuple):
    scheme: str
    example: str
    what: str
    has: str
    extra: str = ""  # of Beckon that it needs
    missing: tuple[str, ...] = ()  # packages of the extra that are not installed
    package: str = ""  # that brings it; "": Beckon

    @property
    def needs(self) -> str:
        if not self.extra:
            return self.package
        return install_extra(self.extra) if self.missing else f"{self.extra} (installed)"

    @property
    def fields(self) -> dict[str, object]:
        return {
            **self._asdict(),
            "extra": self.extra or None,
            "package": self.package or None,
            "installed": not self.missing,
        }


def add(subcommands: Any) -> None:
    add_command(subcommands, "robots", run, "the kinds of robots and what each can")


def run(chosen: argparse.Namespace) -> int:
    rows = scheme_rows()
    lines = [HEAD, *((row.example, row.what, row.has, row.needs) for row in rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(HEAD))]
    aligned = ["  ".join(map(str.ljust, line, widths)).rstrip() for line in lines]
    return answer(chosen, {"schemes": [row.fields for row in rows]}, *aligned, "", *MORE)


def scheme_rows() -> list[SchemeRow]:
    """Beckon's own schemes, a driver in a file, and what installed packages bring."""
    rows = [
        SchemeRow(
            name, one.example, one.what, one.has, one.extra, tuple(missing_packages(one.extra)) if one.extra else ()
        )
        for name, one in SCHEMES.items()
    ]
    rows.append(SchemeRow(OWN, f"{OWN}:FILE.py:ARGUMENTS", "driver of one's own", "what the file declares"))
    for name, point in brought().items():
        package = f"{point.dist.name} {point.dist.version}" if point.dist else point.value
        rows.append(SchemeRow(name, f"{name}:…", "driver of a package", "see its documentation", package=package))
    return rows
