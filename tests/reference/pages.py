"""The reference pages, written from the code."""

import argparse
import inspect
import json
from collections.abc import Iterator
from typing import Any, cast, get_args, get_type_hints

import msgspec

from console.access.roles import declared
from console.api.documentation import ADDRESS, socket_schema
from console.api.typed_route import TypedRoute
from console.app import described_app
from console.cli import build_parser
from console.cli.settings import rows
from console.fleet_server.api import FleetState
from console.messages import inbound
from console.messages import state as messages
from core.commands import VOCABULARY
from core.robots.injected_faults import INJECTABLE_FAULTS
from core.robots.robot_file import CameraTable, LaserTable, MicrophonesTable, RobotFile
from core.sensors.checks import CHECKS
from core.settings import section_kinds
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
    """OpenAPI → Markdown: a chapter for each topic, a section for each operation."""
    description = described_app().openapi()
    schemas = description["components"]["schemas"]
    topics: dict[str, list[str]] = {}
    for path, operations in description["paths"].items():
        for method, operation in operations.items():
            topic = operation["tags"][0].replace("_", " ")
            topics.setdefault(topic, []).append(operation_section(method.upper(), path, operation, schemas))
    chapters = (f"## {topic.capitalize()}\n\n" + "\n\n".join(sections) for topic, sections in topics.items())
    return page("REST", REST_INTRO, *chapters)


REST_INTRO = f"""JSON in and out, keys with units in their names. Errors are `application/problem+json` with a
sentence in `detail`; the input is never repeated in it. Sign in by cookie (`POST /api/login`) or send
`Authorization: Bearer KEY`. A key stands behind `#t=` in the link that was printed at the start;
`beckon token add NAME --role operator` makes a fixed one for a program. In the examples it is in `$KEY`:

```sh
curl -H "Authorization: Bearer $KEY" {ADDRESS}/api/state
```

The description is in [openapi.json]({ADDRESS}/openapi.json), that of the messages on `/ws` and `/ws/audio` in
[api/socket.json]({ADDRESS}/api/socket.json)."""


def operation_section(method: str, path: str, operation: dict[str, Any], schemas: dict[str, Any]) -> str:
    """One operation: its purpose, what it takes, and an example."""
    rows = [
        parameter_row(each["name"], each["schema"], each["in"], each.get("required", False))
        for each in operation.get("parameters", ())
    ]
    content = operation.get("requestBody", {}).get("content", {})
    for kind, body in content.items():
        shape = schemas.get(body["schema"].get("$ref", "").rpartition("/")[2], {})
        fields = [
            parameter_row(name, what, "body", name in shape.get("required", ()))
            for name, what in shape.get("properties", {}).items()
        ]
        rows += fields or [f"| `{kind}` | body | file | yes |"]
    table = ["| takes | in | type | needed |", "| --- | --- | --- | --- |", *rows] if rows else []
    about = operation.get("description") or operation.get("summary") or ""
    who = "Anybody." if operation["x-role"] == "public" else f"Role: {operation['x-role']}."
    example = f"```sh\n{curl(method, path, operation, schemas)}\n```"
    return "\n\n".join(filter(None, (f"### `{method} {path}`", about, who, "\n".join(table), example)))


def curl(method: str, path: str, operation: dict[str, Any], schemas: dict[str, Any]) -> str:
    """The call as it may be copied into a shell; what stands in braces is to be filled in."""
    words = ["curl"]
    if operation["security"]:
        words.append('-H "Authorization: Bearer $KEY"')
    content = operation.get("requestBody", {}).get("content", {})
    sends = next(iter(content), "")
    if sends == "application/json":
        body = json.dumps(example_of(content[sends]["schema"], schemas), ensure_ascii=False)
        words += [f"-H 'Content-Type: {sends}'", f"-d '{body}'"]
    elif sends:
        words += [f"-H 'Content-Type: {sends}'", "--data-binary @FILE"]
    if method != ("POST" if sends else "GET"):
        words.append(f"-X {method}")
    answers = operation["responses"].get("200", {}).get("content", {})
    if not any(kind.endswith("json") for kind in answers if answers[kind]) and method == "GET":
        words.append("-O")
    address = f"{ADDRESS}{path}"
    return " ".join([*words, f"'{address}'" if "{" in address else address])


def example_of(shape: dict[str, Any], schemas: dict[str, Any]) -> Any:
    """A value of this form: an example that is declared, else the plainest."""
    if "$ref" in shape:
        return example_of(schemas[shape["$ref"].rpartition("/")[2]], schemas)
    for key in ("examples", "enum", "anyOf", "oneOf"):
        if key in shape:
            first = shape[key][0]
            return first if key in ("examples", "enum") else example_of(first, schemas)
    for key in ("const", "default", "minimum"):
        if key in shape:
            return shape[key]
    if shape.get("type") == "object":
        named = shape.get("properties", {})
        return {name: example_of(named[name], schemas) for name in shape.get("required", ())}
    if shape.get("type") == "array":
        return [example_of(shape["items"], schemas)] * shape.get("minItems", 0)
    return {"string": "…", "integer": 1, "number": 1.0, "boolean": True}.get(shape.get("type", ""))


def parameter_row(name: str, shape: dict[str, Any], place: str, required: bool) -> str:
    """One parameter, or one key of a body."""
    kinds = [part.get("type") or part.get("$ref", "").rpartition("/")[2] for part in shape.get("anyOf", [shape])]
    words = ", ".join(f"`{value}`" for value in shape.get("enum", ())) or " or ".join(filter(None, kinds))
    return f"| `{name}` | {place} | {words} | {'required' if required else 'optional'} |"


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
