"""One value in a settings file, changed in its own line: comments, order and everything else stay."""

from __future__ import annotations

import json
import re
import tomllib
from typing import Any

from core.errors import BadInput
from core.settings import FORMER, read

HEADER = re.compile(r"^\s*\[([^\[\]]+)\]\s*(#.*)?$")
BY_HAND = "The settings file is written in a way that cannot be changed here; change {name} in it by hand."

Value = bool | int | float | str


def with_value(text: str, section: str, name: str, value: Value | None) -> str:
    """Return the file with this setting; None: without it, so that the default holds.

    Raises BadInput with the declaration's sentence for a value that is not accepted, and where the file cannot be
    changed line by line.
    """
    read(text, "settings.toml")
    lines = text.splitlines()
    first, end = _section(lines, section)
    if first < 0 and section in _document(text):
        raise BadInput(BY_HAND.format(name=f"[{section}] {name}"))
    at = next((row for row in range(first, end) if re.match(rf"^\s*{re.escape(name)}\s*=", lines[row])), None)
    if value is None:
        if at is not None:
            del lines[at]
    elif at is not None:
        _, _, remark = lines[at].partition("#") if '"' not in lines[at] else ("", "", "")
        lines[at] = f"{name} = {as_toml(value)}" + (f"  #{remark}" if remark else "")
    elif first < 0:
        lines += [*([""] if lines and lines[-1].strip() else []), f"[{section}]", f"{name} = {as_toml(value)}"]
    else:
        lines.insert(first, f"{name} = {as_toml(value)}")
    changed = "\n".join(lines) + "\n"
    _check(text, changed, section, name, value)
    return changed


def as_toml(value: Value) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _section(lines: list[str], section: str) -> tuple[int, int]:
    """The rows of a section, under its present or its former name; (-1, -1) without it."""
    former = next((old for old, new in FORMER.items() if new == section), section)
    first = -1
    for row, line in enumerate(lines):
        header = HEADER.match(line)
        if header is None:
            continue
        if first >= 0:
            return first, row
        if header[1].strip() in (section, former):
            first = row + 1
    return first, len(lines) if first >= 0 else -1


def _check(before: str, after: str, section: str, name: str, value: Value | None) -> None:
    """The changed file is accepted, and differs from the former in this value alone. Raises BadInput."""
    read(after, "settings.toml")
    expected, found = _document(before), _document(after)
    here = expected.setdefault(section, {})
    here.pop(name, None)
    if value is not None:
        here[name] = value
    if _filled(expected) != _filled(found):
        raise BadInput(BY_HAND.format(name=f"[{section}] {name}"))


def _document(text: str) -> dict[str, dict[str, Any]]:
    return {FORMER.get(section, section): dict(values) for section, values in tomllib.loads(text).items()}


def _filled(document: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    return {section: values for section, values in document.items() if values}
