"""`beckon settings`: every number that a settings file can change."""

from __future__ import annotations

import argparse
import dataclasses
import inspect
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from console.cli.answer import add_json, write, write_json
from core.errors import BadInput
from core.settings import Settings

FIELD = re.compile(r"^    (\w+): .*?# (?:\[(?P<unit>[^\]]*)\] ?)?(?P<meaning>.*)$")


def add(places: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = places.add_parser("settings", help="all settings with their units and defaults")
    parser.add_argument("section", nargs="?", default="", metavar="SECTION", help="one section only")
    add_json(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace) -> int:
    """Print one section or all. Raises BadInput for a section that does not exist."""
    sections = {one.name: getattr(Settings(), one.name) for one in dataclasses.fields(Settings)}
    if chosen.section and chosen.section not in sections:
        raise BadInput(f"There is no section {chosen.section[:40]!r}; there are {', '.join(sections)}.")
    names = [chosen.section] if chosen.section else list(sections)
    if chosen.json:
        write_json({name: [row._asdict() for row in settings_of(sections[name])] for name in names})
        return 0
    for name in names:
        write(f"[{name}]")
        for row in settings_of(sections[name]):
            unit = f"[{row.unit}] " if row.unit else ""
            write(f"{row.name} = {row.default:<12}  # {unit}{row.meaning}".rstrip(" #"))
        write("")
    return 0


class Row(NamedTuple):
    """One setting."""

    name: str
    default: str  # as TOML writes it
    unit: str
    meaning: str


def settings_of(section: Any) -> Iterator[Row]:
    """Each setting of a section, with the unit and the meaning that its class declares."""
    declared: dict[str, tuple[str, str]] = {}
    for kind in reversed(type(section).__mro__[:-1]):
        for line in inspect.getsource(kind).splitlines():
            if found := FIELD.match(line):
                declared[found[1]] = (found["unit"] or "", found["meaning"])
    for one in dataclasses.fields(section):
        yield Row(one.name, shown(getattr(section, one.name)), *declared.get(one.name, ("", "")))


def shown(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else f'"{value}"' if isinstance(value, str) else str(value)
