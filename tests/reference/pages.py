"""The reference pages, written from the code."""

import argparse
import inspect
import json
from collections.abc import Iterator
from typing import cast, get_args, get_type_hints

import msgspec
from fastapi.routing import APIRoute

from console.access.roles import declared
from console.api.typed_route import TypedRoute
from console.app import described_app
from console.cli import build_parser
from console.cli.settings import rows, section_kinds
from console.fleet_server.api import FleetState
from console.messages import inbound
from console.messages import state as messages
from console.messages.json_schema import socket_schema
from core.commands import VOCABULARY
from core.robots.injected_faults import INJECTABLE_FAULTS
from core.robots.robot_file import CameraTable, LaserTable, MicrophonesTable, RobotFile
from core.sensors.checks import CHECKS
from tests.reference.script_types import HEADER, Shape, collect, declarations, js_type, socket_types

NOTE = "<!-- Written by `python -m tests.reference`; a test keeps it equal to the code. Do not edit. -->"


def reference_pages() -> dict[str, str]:
    """Name of a page in static/docs/reference → its text."""
    return {
        "cli.md": cli_page(),
        "settings.md": settings_page(),
        "robot-file.md": robot_file_page(),
        "rest.md": rest_page(),
        "roles.md": roles_page(),
        "../../js/net/messages.d.ts": socket_types(),
        "../../js/net/rest.d.ts": rest_types(),
        "socket.md": socket_page(),
        "socket.schema.json": json.dumps(socket_schema(), indent=1, ensure_ascii=False) + "\n",
        "commands.md": commands_page(),
        "checks.md": checks_page(),
        "what-happens-when.md": faults_page(),
    }


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A table in Markdown; bars within cells are escaped."""
    lines = [head, tuple("---" for _ in head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def page(title: str, intro: str, *parts: str) -> str:
    """A page."""
    return "\n\n".join((f"# {title}", NOTE, intro, *(part for part in parts if part))) + "\n"


# the command line


def cli_page() -> str:
    """Every subcommand with its options."""
    intro = (
        "`beckon` alone is `beckon run`. Every command that computes something takes `--json`. Exit codes: 0 done, "
        "1 could not be done (a sentence on standard error says why), 2 wrong usage. With `--json` a refusal is one "
        'object, too: `{"error": sentence, "code": code}`.'
    )
    return page("Command line", intro, *(section(*one) for one in leaves("beckon", build_parser(), "")))


def leaves(
    name: str, parser: argparse.ArgumentParser, summary: str
) -> Iterator[tuple[str, str, list[argparse.Action]]]:
    """The subcommands that take arguments: name, summary, arguments."""
    nested = [action for action in parser._actions if isinstance(action.choices, dict)]
    if not nested:
        actions = [action for action in parser._actions if action.dest != "help" and action.help != argparse.SUPPRESS]
        yield name, summary, actions
    for action in nested:
        helps = {choice.dest: choice.help or "" for choice in getattr(action, "_choices_actions", ())}
        for word, child in cast(dict[str, argparse.ArgumentParser], action.choices).items():
            yield from leaves(f"{name} {word}", child, helps.get(word, ""))


def section(name: str, summary: str, actions: list[argparse.Action]) -> str:
    """One subcommand."""
    rows = [(f"`{call_of(action)}`", plain(action.help)) for action in actions]
    body = f"## {name}\n\n{summary[:1].upper() + summary[1:]}."
    return f"{body}\n\n{table(('argument', 'meaning'), rows)}" if rows else body


def call_of(action: argparse.Action) -> str:
    """How an argument is written."""
    value = action.metavar if isinstance(action.metavar, str) else ""
    if not value and action.choices is not None:
        value = "{" + ",".join(str(choice) for choice in action.choices) + "}"
    value = value or (action.dest.upper() if action.nargs != 0 else "")
    if not action.option_strings:
        return f"{value} …" if action.nargs in ("+", "*") else value
    return f"{action.option_strings[0]} {value}".strip() if action.nargs != 0 else action.option_strings[0]


def plain(text: str | None) -> str:
    """A help text as argparse prints it."""
    return (text or "").replace("%%", "%")


# settings


def settings_page() -> str:
    """Every section of the settings with its numbers."""
    intro = (
        "A TOML file changes any of them: `beckon run --settings my.toml`. An unknown name is refused with the name "
        "that was probably meant, a value outside its bounds with the bounds. `beckon settings --schema` prints the "
        "JSON Schema with which an editor [completes and checks such a file](../how-to/edit-the-settings.md). "
        "*Watch* is what to look at after a change. All other numbers are thresholds beside their "
        "equations, which no file sets."
    )
    parts: list[str] = []
    for name, kind in section_kinds().items():
        cells = [
            (f"`{row.name}`", f"`{row.default}`" if row.default else "", row.values, row.unit, row.meaning, row.watch)
            for row in rows(kind)
        ]
        about = (inspect.getdoc(kind) or "").splitlines()[0]
        heads = ("setting", "default", "values", "unit", "meaning", "watch")
        parts.append(f"## [{name}]\n\n{about}\n\n{table(heads, cells)}")
    return page("Settings", intro, *parts)


# the robot file

EXAMPLE = """```toml
url = "py:my_robot.py:/dev/ttyUSB0"
name = "Marvin"
wheelbase = 0.23

[lasers.laser]
x = 0.08
height = 0.17

[robot]
baud = 57600
```"""


def robot_file_page() -> str:
    """Every table of robot.toml with its entries."""
    intro = (
        "A file robot.toml describes one robot: `beckon run --robot robot.toml`, `beckon robot check robot.toml`. An "
        "unknown entry, or a value outside its bounds, is refused and named. Places are seen from the middle between "
        "the wheels, on the floor: x forward, y to the left. A sensor's table has the name of the sensor, which "
        "`beckon robot check` prints."
    )
    parts = [
        file_table(title, kind)
        for title, kind in (
            ("At the top", RobotFile),
            ("[lasers.NAME]", LaserTable),
            ("[cameras.NAME]", CameraTable),
            ("[microphones.NAME]", MicrophonesTable),
        )
    ]
    own = (
        "## [robot]\n\nThe driver's own entries, which the driver checks. They go behind the `?` of its URL, "
        "`baud = 57600` as `?baud=57600`; what the URL says itself counts more."
    )
    return page("Robot file", intro, EXAMPLE, *parts, own)


def file_table(title: str, kind: type[msgspec.Struct]) -> str:
    """One table of the robot file."""
    info = cast(msgspec.inspect.StructType, msgspec.inspect.type_info(kind))
    rows = [file_entry(each) for each in info.fields if isinstance(each.type, msgspec.inspect.Metadata)]
    body = table(("entry", "default", "values", "unit", "meaning"), rows)
    return f"## {title}\n\n{inspect.getdoc(kind)}\n\n{body}"


def file_entry(each: msgspec.inspect.Field) -> tuple[str, ...]:
    """One entry: its name, default, bounds, unit and meaning, as they are declared."""
    meaning, unit, inner = "", "", each.type
    while isinstance(inner, (msgspec.inspect.Metadata, msgspec.inspect.UnionType)):
        if isinstance(inner, msgspec.inspect.UnionType):
            inner = next(one for one in inner.types if not isinstance(one, msgspec.inspect.NoneType))
            continue
        meaning = (inner.extra_json_schema or {}).get("description", meaning)
        unit = (inner.extra or {}).get("unit", unit)
        inner = inner.type
    values = "text"
    if isinstance(inner, msgspec.inspect.FloatType):
        low = f"above {inner.gt:g}" if inner.gt is not None else f"{inner.ge:g}"
        values = f"{low} to {inner.le:g}"
    default = f"`{each.default:g}`" if isinstance(each.default, float) else ""
    return f"`{each.name}`", default, values, unit, meaning


# HTTP


def rest_page() -> str:
    """Every endpoint with its role."""
    topics: dict[str, list[tuple[str, ...]]] = {}
    for route in described_app().routes:
        if isinstance(route, APIRoute) and route.include_in_schema:
            need = declared(route)
            topic = str(route.tags[0]) if route.tags else "other"
            method = ", ".join(sorted(route.methods or ()))
            about = (inspect.getdoc(route.endpoint) or "").split("\n\n")[0].replace("\n", " ")
            topics.setdefault(topic, []).append((f"`{method} {route.path}`", need.role if need else "", about))
    intro = (
        "JSON in and out, keys with units in their names. Sign in with `Authorization: Bearer KEY`. Errors are "
        "`application/problem+json` with a sentence in `detail`; the input is never repeated in it. `/docs` on a "
        "running console has every field."
    )
    parts = [f"## {topic}\n\n{table(('call', 'role', 'does'), rows)}" for topic, rows in topics.items()]
    return page("REST", intro, *parts)


ROLES = {
    "public": "Anybody who reaches the console: the page to sign in, and whether the robot is well.",
    "viewer": "Watches, and stops: `stop` and `halt` are everybody's who is signed in.",
    "operator": "Drives while holding control, calibrates, changes what is kept.",
    "admin": "Makes links, ends logins, revokes keys. On *Connect* an administrator alone names other robots, files "
    "and devices; an operator what `--connect` allows ([table](../how-to/open-it-to-the-network.md)).",
}


def roles_page() -> str:
    """Write every route under the role that it needs, from the declarations that the guard enforces."""
    ways: dict[str, list[str]] = {role: [] for role in ROLES}
    for route in described_app().routes:
        need = declared(route)
        if need is None:
            raise LookupError(route)
        methods = sorted(set(getattr(route, "methods", None) or ()) - {"HEAD"})
        ways[need.role].append(f"`{' '.join((*methods, getattr(route, 'path', '')))}`")
    intro = (
        "Every way into the console declares its role; without one the console does not start. A higher role may all "
        "that those above it in this page may. What each call does: [REST](rest.md)."
    )
    parts = [f"## {role}\n\n{about}\n\n{', '.join(sorted(ways[role]))}" for role, about in ROLES.items()]
    return page("Roles", intro, *parts)


def rest_types() -> str:
    """Declare the answers of REST, this console's and the fleet's, for the browser's scripts."""
    routes = [route for route in described_app().routes if isinstance(route, TypedRoute)]
    answers = [get_type_hints(route.endpoint).get("return") for route in routes]
    known: dict[str, Shape] = {}
    collect(messages.Down, known)
    text = declarations([FleetState, *answers, *(kind for route in routes for kind in route.structs)], known=known)
    borrowed = ", ".join(name for name in known if f" {name}" in text)
    return f'{HEADER}\nimport type {{ {borrowed} }} from "./messages.js";\n{text}'


# the socket


def socket_page() -> str:
    """Every message of `/ws`."""
    intro = (
        "`/ws` carries JSON both ways, distinguished by `kind`, and the camera as binary: a header of 16 bytes "
        "(kind 1, sequence number, stamp in seconds) and a JPEG, the newest only. `/ws/audio` carries 16 kHz mono "
        "16-bit PCM up and transcripts down. The same as JSON Schema: [socket.schema.json](socket.schema.json), "
        "and `/api/socket.json` on a running console.\n\n"
        "Sign in as for REST: send `Authorization: Bearer KEY` with the handshake, or, from a page of the console "
        "itself, the cookie of `POST /api/login`. A key in the address is not taken. `hello` comes first, then "
        "`state` again and again.\n\n"
        "Numbers keep old messages from moving the robot. `seq` of `drive` rises with every frame, from "
        "`clock_ms` of `hello` on: a frame that comes after a newer one is dropped. `nonce` is that of `gate` in "
        "the newest `state`; after a stop it is another one, and frames from before are refused. `epoch` is that "
        "of `lease`, which rises when control changes hands. `press` is another number for every press of a key: "
        "one that was held through a stop stays dead. `seen` of `command` is `seq` of the newest `state`, by "
        "which words that were held up are refused. `ref` comes back in the `answer`. Who drives sends something "
        "at least every five seconds, such as `echo`."
    )
    unions = ((inbound.Up, "From the browser"), (messages.Down, "To the browser"))
    parts = [f"## {title}\n\n" + "\n\n".join(map(shape, get_args(union))) for union, title in unions]
    used: dict[str, Shape] = {}
    for union, _ in unions:
        collect(union, used)
    kinds = {kind.__name__ for union, _ in unions for kind in get_args(union)}
    parts_used = [shape(kind) for name, kind in used.items() if name not in kinds]
    return page("Socket messages", intro, *parts, "## Their parts\n\n" + "\n\n".join(parts_used))


def shape(kind: type[msgspec.Struct]) -> str:
    """One message."""
    tag = kind.__struct_config__.tag
    title = (
        f'{kind.__name__} · `"{kind.__struct_config__.tag_field}": "{tag}"`'
        if isinstance(tag, str)
        else kind.__name__
    )
    about = (inspect.getdoc(kind) or "").replace("\n", " ")
    rows = [
        (f"`{each.name}`", f"`{js_type(each.type)}`", "" if each.required else "optional")
        for each in msgspec.structs.fields(kind)
    ]
    return f"### {title}\n\n{about}" + (f"\n\n{table(('key', 'type', ''), rows)}" if rows else "")


# commands


def commands_page() -> str:
    """Table 2."""
    rows = [
        (
            f"`{kind.name}`",
            " · ".join(f"`{words}`" for words in kind.words),
            "; ".join(f"{one.name} {one.low:g} to {one.high:g} {one.unit}" for one in kind.numbers),
            kind.summary,
        )
        for kind in VOCABULARY
    ]
    intro = (
        "Table 2 of the chapter. Only a whole sentence that matches moves the robot; *stop* in any sentence stops it."
    )
    return page("Commands", intro, table(("name", "words", "numbers", "does"), rows))


# the checks of readings


def checks_page() -> str:
    """Every check of a reading, with the sentence that it says."""
    intro = (
        "Beckon uses no reading that cannot be true. Live drivers, recordings and the commands that read files share "
        "these checks. What was found is shown by `beckon robot check`, on *Connect*, among the notices, and as "
        "`warnings` and `faults` of `--json`, with its code."
    )
    stages = (
        ("form", "shape, finite numbers, units"),
        ("time", "age, order, clock"),
        ("limits", "what the robot itself can do"),
        ("agreement", "between senses"),
    )
    parts = [
        f"## {stage[:1].upper()}{stage[1:]}: {meaning}\n\n"
        + table(
            ("code", "compared", "sentence"),
            [(f"`{one.code}`", one.compared, one.sentence) for one in CHECKS.values() if one.stage == stage],
        )
        for stage, meaning in stages
        if any(one.stage == stage for one in CHECKS.values())
    ]
    return page("Checks of readings", intro, *parts)


def faults_page() -> str:
    """The faults that a simulated robot can be given, and what an operator sees then."""
    intro = (
        "Faults to be tried on the simulated robot: how to have each, and what an operator sees then. Several are "
        "joined by commas, `sim:lab?faults=late_scan:1.5,slip:0.2,after:10`; without a number a fault has the one of "
        "the table. A real robot is never given a fault."
    )
    example = "```sh\nbeckon run --robot 'sim:lab?faults=late_scan:1.5,after:20'\n```"
    rows = [
        (
            f"`{one.name}:{one.value:g}`",
            f"{meta.meaning}; {meta.low:g} to {meta.high:g} {meta.unit}".rstrip(),
            one.seen,
        )
        for one in INJECTABLE_FAULTS
        for meta in (one.number,)
    ]
    return page("What happens when …", intro, example, table(("fault", "meaning", "what happens"), rows))
