"""The common settings: what holds now, what holds from the next start, and changing them in the settings file."""

import asyncio
import dataclasses
import json
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec

from console.http.problems import Problem
from console.part import Part
from console.workers.tasks import to_the_end
from core.errors import BadInput
from core.files import saving, write_atomic
from core.pilot.pilot import Pilot
from core.setting import DeclaredSetting, declared_settings
from core.settings import FORMER, Settings, read, section_kinds

# One value in a settings file, changed in its own line: comments, order and everything else stay.

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


KINDS = {bool: "switch", int: "whole", float: "number", str: "text"}
NOW = "{name} is {value} now."
LATER = "Saved. {name} is {value} from the next start of the console on."
UNKNOWN = "There is no common setting of this name; GET /api/settings lists them, and the settings file takes all."


class SettingState(msgspec.Struct, frozen=True, kw_only=True):
    """One common setting, as it is declared and as it holds."""

    section: str
    name: str
    kind: str  # "switch", "whole", "number" or "text"
    unit: str
    low: float | None  # of a number
    high: float | None
    choices: list[str]  # [] where anything within the bounds is accepted
    meaning: str
    watch: str  # what to look at after a change
    default: Value
    value: Value  # that holds now
    saved: Value  # that holds from the next start on
    live: bool  # a change holds at once


class SettingsState(msgspec.Struct, frozen=True):
    """All common settings."""

    file: str  # where they are saved
    restart: bool  # True while something that is saved waits for the next start
    settings: list[SettingState]


class ChangedSetting(msgspec.Struct, frozen=True):
    """A setting after a change, and a sentence for the operator."""

    setting: SettingState
    sentence: str


class SettingsInUse(Part):
    """Lives on the event loop."""

    def __init__(self, settings: Settings, file: Path, adopt: Callable[[Settings], None]) -> None:
        """`adopt` is given the settings whenever one of them changes while the console runs."""
        self._now = self._saved = settings
        self._file, self._adopt = file, adopt
        self._turn = asyncio.Lock()

    def equip(self, pilot: Pilot) -> None:
        pilot.drive_with(self._now)

    @property
    def now(self) -> Settings:
        return self._now

    @property
    def state(self) -> SettingsState:
        rows = [self._state(section, one) for section in section_kinds() for one in common(section)]
        return SettingsState(str(self._file), any(row.value != row.saved for row in rows), rows)

    async def change(self, section: str, name: str, value: Value | None) -> ChangedSetting:
        """Save it in the settings file, and let it hold at once where it is declared live; None: the default.

        Raises Problem 404 for a setting that is not common, BadInput with the declaration's sentence, Unwritable.
        """
        declared = next((one for one in common(section) if one.name == name), None)
        if declared is None:
            raise Problem(404, UNKNOWN)
        fitted = None if value is None else declared.fit(_as_declared(declared, value))
        async with self._turn:
            saved = await to_the_end(lambda: self._save(section, name, fitted))
            self._saved = saved
            if declared.meta.live:
                chosen = getattr(getattr(saved, section), name)
                changed = dataclasses.replace(getattr(self._now, section), **{name: chosen})
                self._now = dataclasses.replace(self._now, **{section: changed})
                self._adopt(self._now)
        state = self._state(section, declared)
        sentence = (NOW if declared.meta.live else LATER).format(
            name=f"[{section}] {name}", value=f"{shown(state.saved)} {declared.meta.unit}".strip()
        )
        return ChangedSetting(state, sentence)

    def _save(self, section: str, name: str, value: Value | None) -> Settings:
        with saving("The settings could not be saved"):
            try:
                text = self._file.read_text(encoding="utf-8")
            except FileNotFoundError:
                text = ""
        changed = with_value(text, section, name, value)
        with saving("The settings could not be saved"):
            write_atomic(self._file, changed)
        return read(changed, self._file.name)

    def _state(self, section: str, one: DeclaredSetting) -> SettingState:
        number = one.kind in (int, float)
        return SettingState(
            section=section,
            name=one.name,
            kind=KINDS[one.kind],
            unit=one.meta.unit,
            low=one.meta.low if number else None,
            high=one.meta.high if number else None,
            choices=list(one.choices),
            meaning=one.meta.meaning,
            watch=one.watch,
            default=one.default,
            value=getattr(getattr(self._now, section), one.name),
            saved=getattr(getattr(self._saved, section), one.name),
            live=one.meta.live,
        )


def common(section: str) -> list[DeclaredSetting]:
    """The common settings of a section; none of one that does not exist."""
    kind = section_kinds().get(section)
    return [] if kind is None else [one for one in declared_settings(kind) if one.meta.common]


def _as_declared(declared: DeclaredSetting, value: Value) -> Value:
    """A whole number that a browser wrote with a point, or a number without one."""
    if declared.kind is int and isinstance(value, float) and value.is_integer():
        return int(value)
    return value


def shown(value: Value) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else str(value)
