"""`beckon settings`: every setting that a file can change, and the schema of that file for editors."""

import argparse
import inspect
from typing import Any, NamedTuple

from console.cli.answer import add_command, write, write_json
from core.errors import BadInput
from core.setting import DeclaredSetting, Section, declared_settings

TYPES = {bool: "boolean", int: "integer", float: "number", str: "string"}  # as JSON Schema calls them


def add(subcommands: Any) -> None:
    parser = add_command(subcommands, "settings", run, "all settings with units, bounds and defaults")
    parser.add_argument("section", nargs="?", default="", metavar="SECTION", help="one section only")
    parser.add_argument("--schema", action="store_true", help="the JSON Schema of a settings file, for editors")


def run(chosen: argparse.Namespace) -> int:
    """Print one section or all, or the schema. Raises BadInput for a section that does not exist."""
    from core.settings import section_kinds  # all algorithms take a moment: only where they are needed

    kinds = section_kinds()
    if chosen.section and chosen.section not in kinds:
        raise BadInput(f"There is no section {chosen.section[:40]!r}; there are {', '.join(kinds)}.")
    if chosen.section:
        kinds = {chosen.section: kinds[chosen.section]}
    if chosen.schema:
        write_json(schema(kinds))
    elif chosen.json:
        write_json({name: [row._asdict() for row in rows(kind)] for name, kind in kinds.items()})
    else:
        for name, kind in kinds.items():
            write(f"[{name}]")
            for row in rows(kind):
                write(line(row))
            write("")
    return 0


class Row(NamedTuple):
    name: str
    default: str  # as TOML writes it; "" where there is none
    unit: str
    low: float | None  # None: not a number
    high: float | None
    choices: tuple[str, ...]  # () of a setting that is none of few words
    meaning: str
    watch: str  # what to look at when it is changed

    @property
    def values(self) -> str:
        """Accepted values, for people: "0.05 to 1" or "encoder, paper"."""
        return ", ".join(self.choices) if self.low is None else f"{self.low:g} to {self.high:g}"


def rows(section: type[Section]) -> list[Row]:
    return [row_of(setting) for setting in declared_settings(section)]


def row_of(setting: DeclaredSetting) -> Row:
    meta, number = setting.meta, setting.kind in (int, float)
    bounds = (meta.low, meta.high) if number else (None, None)
    return Row(setting.name, shown(setting.default), meta.unit, *bounds, setting.choices, meta.meaning, setting.watch)


def line(row: Row) -> str:
    """A setting as a line of a settings file; one without a default is commented out."""
    unit = f" {row.unit}" if row.unit else ""
    remark = "; ".join(part for part in (f"{row.values}{unit}".strip(), row.meaning) if part)
    assignment = f"{row.name} = {row.default}" if row.default else f"# {row.name} ="
    return f"{assignment:<32}  # {remark}"


def shown(value: Any) -> str:
    """A default as TOML writes it; "" for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else f'"{value}"' if isinstance(value, str) else str(value)


def schema(sections: dict[str, type[Section]]) -> dict[str, Any]:
    """JSON Schema (draft 4, which editors of TOML read) of a settings file with these sections."""
    from core.settings import FORMER  # see run

    former = {old: {"$ref": f"#/definitions/{new}"} for old, new in FORMER.items() if new in sections}
    return {
        "$schema": "http://json-schema.org/draft-04/schema#",
        "title": "Beckon settings",
        "type": "object",
        "additionalProperties": False,
        "properties": {**{name: {"$ref": f"#/definitions/{name}"} for name in sections}, **former},
        "definitions": {name: section_schema(kind) for name, kind in sections.items()},
    }


def section_schema(section: type[Section]) -> dict[str, Any]:
    return {
        "type": "object",
        "description": (inspect.getdoc(section) or "").splitlines()[0],
        "additionalProperties": False,
        "properties": {setting.name: setting_schema(setting) for setting in declared_settings(section)},
    }


def setting_schema(setting: DeclaredSetting) -> dict[str, Any]:
    row = row_of(setting)
    unit = f"[{row.unit}] " if row.unit else ""
    found: dict[str, Any] = {"type": TYPES[setting.kind], "description": f"{unit}{row.meaning}\nWatch: {row.watch}"}
    if setting.default is not None:
        found["default"] = setting.default
    if row.choices:
        found["enum"] = list(row.choices)
    if row.low is not None:
        found |= {"minimum": row.low, "maximum": row.high}
    return found
