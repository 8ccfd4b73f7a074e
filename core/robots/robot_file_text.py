"""A robot file as it is written: the operator's choices joined to what was there, and the text in TOML."""

import datetime
import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, Literal, cast

import msgspec

from core.errors import BadInput
from core.robots.robot_file import RobotFile

ChosenRole = Literal[
    "odometry",
    "scan",
    "image",
    "camera_info",
    "sound",
    "cmd_vel",
    "cmd_vel_type",
    "battery",
    "map",
    "pose",
    "description",
]
NOTHING = "none"  # a driver's word for "do not use any"
BARE = re.compile(r"[A-Za-z0-9_-]+")
MAX_TABLE_DEPTH = 8  # tables in tables


class TopicChoice(msgspec.Struct, frozen=True, kw_only=True):
    """The topics that an operator chose for a role; () switches it off."""

    part: int = 0  # of the URL, counted from 0
    role: ChosenRole
    topics: tuple[str, ...]


def with_topics(file: RobotFile, choices: Sequence[TopicChoice], parts: Sequence[str]) -> RobotFile:
    """A robot file whose driver takes the chosen topics; `parts`: of its URL. Raises BadInput.

    What is chosen leaves the URL's query, which would count more than the file. The first part's choices go into
    [robot], which is its alone, those of others into their query.
    """
    joined, own = list(parts), dict(file.robot)
    for choice in choices:
        if not 0 <= choice.part < len(joined):
            raise BadInput("The robot has no such part; look at it again.")
        part = _without(joined[choice.part], choice.role)
        topics = list(choice.topics) or [NOTHING]
        if choice.part == 0:
            own[choice.role] = topics if choice.role == "scan" and len(topics) > 1 else topics[0]
        else:
            part += f"{'&' if '?' in part else '?'}{choice.role}={','.join(topics)}"
        joined[choice.part] = part
    return msgspec.structs.replace(file, url="+".join(joined), robot=own)


def without_lock(file: RobotFile, parts: Sequence[str]) -> RobotFile:
    """The same robot without its lock of twist_mux: who only looks closes nothing. `parts`: of its URL."""
    own = {key: value for key, value in file.robot.items() if key != "lock"}
    return msgspec.structs.replace(file, url="+".join(_without(part, "lock") for part in parts), robot=own)


def _without(part: str, key: str) -> str:
    """A part of a URL without one key of its query."""
    address, _, query = part.partition("?")
    kept = [pair for pair in query.split("&") if pair and pair.partition("=")[0] != key]
    return "?".join(filter(None, (address, "&".join(kept))))


def toml_text(file: RobotFile, comment: str = "") -> str:
    """The text of a robot file, without what has its default; `comment` is its first lines."""
    lines = [f"# {line}" for line in comment.splitlines()]
    single, tables = _entries(file)
    lines += [f"{key} = {_value(value)}" for key, value in single.items()]
    for name in ("lasers", "cameras", "microphones"):
        for sensor, table in tables.pop(name, {}).items():
            lines += ["", f"[{name}.{_key(sensor)}]"]
            lines += [f"{_key(key)} = {_value(value)}" for key, value in _entries(table)[0].items()]
    own: dict[str, Any] = tables.get("robot", {})
    if own:
        lines += ["", "[robot]", *(f"{_key(key)} = {_value(value)}" for key, value in own.items())]
    return "\n".join(lines) + "\n"


def _entries(table: msgspec.Struct) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    """The entries of a table that differ from their defaults: plain ones, and tables."""
    plain: dict[str, Any] = {}
    tables: dict[str, dict[str, Any]] = {}
    for field in msgspec.structs.fields(table):
        value = getattr(table, field.name)
        if isinstance(value, dict):
            tables[field.name] = cast(dict[str, Any], value)
        elif value != field.default:
            plain[field.name] = value
    return plain, tables


def _key(name: str) -> str:
    return name if BARE.fullmatch(name) else _text(name)


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any, depth: int = 0) -> str:
    """A value in TOML. Raises BadInput for what has no form there."""
    if depth > MAX_TABLE_DEPTH:
        raise BadInput("The robot file's tables lie too deep in each other.")
    match value:
        case bool():
            return "true" if value else "false"
        case str():
            return _text(value)
        case float() if not math.isfinite(value):
            return str(value)
        case int() | float():
            return repr(value)
        case datetime.date() | datetime.time():
            return value.isoformat()
        case list() | tuple():
            return f"[{', '.join(_value(one, depth + 1) for one in cast(Sequence[Any], value))}]"
        case dict():
            pairs = (f"{_key(key)} = {_value(one, depth + 1)}" for key, one in cast(Mapping[str, Any], value).items())
            return f"{{{', '.join(pairs)}}}"
        case _:
            raise BadInput(f"A robot file cannot hold a value of the kind {type(value).__name__}.")
