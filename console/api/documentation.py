"""The description of the HTTP interface: OpenAPI, and the same as a page of Help. Nothing comes from other hosts."""

from __future__ import annotations

import asyncio
import json
import re
from dataclasses import dataclass
from typing import Any

from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.responses import RedirectResponse

from console.access.roles import FORGOTTEN, declared, needs
from console.api import PROBLEM, PROBLEMS
from console.api.help import as_page
from console.api.typed_route import REF, OpenApi, TypedRoute, schemas_of
from console.http.problems import wanted_page
from console.messages.json_schema import socket_schema

documentation = APIRouter()

ADDRESS = "http://address.of.this.console"  # stands for the address by which the reader has it
FILES: OpenApi = {
    "BinaryFile": {"type": "string", "format": "binary", "description": "A file, as its media type says."},
    "TextFile": {"type": "string", "description": "A file of text, as its media type says."},
}

INTRO = f"""# HTTP interface

JSON in and out. Errors are `application/problem+json` with a sentence in `detail`. Sign in by cookie
(`POST /api/login`) or send `Authorization: Bearer KEY`. A key stands behind `#t=` in the link that was printed at the
start; `beckon token add NAME --role operator` makes a fixed one for a program. In the examples it is in `$KEY`:

```sh
curl -H "Authorization: Bearer $KEY" {ADDRESS}/api/state
```

The description is in [openapi.json](openapi.json), that of the messages on `/ws` and `/ws/audio` in
[api/socket.json](api/socket.json)."""


STEPS = """Three steps to a robot that moves:

1. **A key**: `beckon token add NAME --role operator` prints one; send it as `Authorization: Bearer KEY`.
2. **A command**: `POST /api/commands` with `{"text": "turn left"}` takes control where nobody has it and answers 202
   with an `id`; `GET /api/commands/{number}` tells how it ends.
3. **The lease**: one person drives at a time. `POST /api/lease` takes, asks for or gives back control;
   `POST /api/stop` stops the robot, no matter who drives.

Errors are `application/problem+json` with a sentence in `detail` to act on. The messages of the sockets `/ws` and
`/ws/audio` are described in `/api/socket.json`."""


class DescribedApp(FastAPI):
    """An application whose description names the form of every answer, and says who may ask."""

    cookie = "beckon_8420"  # that carries a login

    def openapi(self) -> OpenApi:
        """The whole interface. Raises RuntimeError for two structs of one name."""
        description = super().openapi()
        components = description.setdefault("components", {})
        schemas = components.setdefault("schemas", {})
        schemas |= {"Problem": PROBLEM, **FILES}
        for unused in ("HTTPValidationError", "ValidationError"):  # FastAPI's own 422
            schemas.pop(unused, None)
        routes = [route for route in self.routes if isinstance(route, TypedRoute)]
        add_schemas(schemas, schemas_of(kind for route in routes for kind in route.structs))
        for route in routes:
            describe_operations(description["paths"].get(route.path, {}), route)
        components["securitySchemes"] = {
            "key": {"type": "http", "scheme": "bearer", "description": "A key, with every request."},
            "login": {"type": "apiKey", "in": "cookie", "name": self.cookie, "description": "Of POST /api/login."},
        }
        description["servers"] = [{"url": ADDRESS}]
        return description


def add_schemas(schemas: OpenApi, more: OpenApi) -> None:
    """Raises RuntimeError where a name stands for another form already."""
    for name, shape in more.items():
        if schemas.setdefault(name, shape) != shape:
            raise RuntimeError(f"Two structs of the interface are called {name}; rename one.")


def problems_of(route: TypedRoute, operation: OpenApi) -> set[int]:
    """The refusals that follow from the form of a call: its role, its path, its body."""
    need = declared(route) or FORGOTTEN
    found = {403} if need.role == "public" else {401, 403}  # 403 for a foreign origin, too
    if "{" in route.path:
        found.add(404)
    if "requestBody" in operation:
        found |= {400, 408, 413, 415, 422} | ({429} if need.body.patience > 1 else set())
    return found | ({422} if operation.get("parameters") else set())


def describe_problems(method: str, route: TypedRoute, operation: OpenApi) -> None:
    """Keep the refusals that occur: what only reads stands in nobody's way and saves nothing."""
    responses = operation["responses"]
    for status in ("422", "409", "507") if method == "get" else ("422",):
        responses.pop(status, None)
    for status in sorted(problems_of(route, operation)):
        responses[str(status)] = PROBLEMS[status]


def operation_id(method: str, path: str) -> str:
    """A name for a call: `get_maps`, `post_maps_by_name_load`."""
    words = re.sub(r"\{(\w+)\}", r"by_\1", path.removeprefix("/api"))
    return method + re.sub(r"[^0-9a-z]+", "_", words.lower())


def describe_operations(operations: OpenApi, route: TypedRoute) -> None:
    """Describe who may ask for each operation, what it is called, its refusals, and the form of files."""
    role = (declared(route) or FORGOTTEN).role
    for method, operation in operations.items():
        if method.upper() not in (route.methods or ()):
            continue
        operation["security"] = [] if role == "public" else [{"key": []}, {"login": []}]
        operation["x-role"] = role
        operation["operationId"] = operation_id(method, route.path)
        describe_problems(method, route, operation)
        for answer in operation["responses"].values():
            for kind, content in answer.get("content", {}).items():
                if not content.get("schema"):
                    file = "TextFile" if kind.startswith("text/") or kind.endswith("+xml") else "BinaryFile"
                    content["schema"] = {"$ref": REF.format(name=file)}


class ApiDescription:
    """The description in both forms, written once and not on the event loop: it takes a third of a second."""

    def __init__(self, app: FastAPI) -> None:
        self._app = app
        self._written: asyncio.Task[StaticDescription] | None = None

    async def written(self) -> StaticDescription:
        """Wait until it is written."""
        if self._written is None:
            self._written = asyncio.create_task(asyncio.to_thread(write, self._app))
        return await asyncio.shield(self._written)


@dataclass(frozen=True)
class StaticDescription:
    """The description, to send as it is."""

    openapi: bytes
    page: bytes

    def to(self, request: Request) -> StaticDescription:
        """The same with the address by which this reader has the console; the guard has checked its host."""
        own = str(request.base_url).rstrip("/").encode()
        return StaticDescription(*(part.replace(ADDRESS.encode(), own) for part in (self.openapi, self.page)))


def write(app: FastAPI) -> StaticDescription:
    """The description of this application, as OpenAPI and as a page."""
    description = app.openapi()
    return StaticDescription(json.dumps(description).encode(), as_page(markdown(description), "./").encode())


def markdown(description: OpenApi) -> str:
    """OpenAPI → Markdown: a chapter for each topic, a section for each operation."""
    schemas = description["components"]["schemas"]
    topics: dict[str, list[str]] = {}
    for path, operations in description["paths"].items():
        for method, operation in operations.items():
            topic = operation["tags"][0].replace("_", " ")
            topics.setdefault(topic, []).append(section(method.upper(), path, operation, schemas))
    chapters = (f"## {topic.capitalize()}\n\n" + "\n\n".join(sections) for topic, sections in topics.items())
    return "\n\n".join((INTRO, *chapters))


@documentation.get("/openapi.json", include_in_schema=False)
@needs("viewer")
async def openapi(request: Request) -> Response:
    """The interface as OpenAPI."""
    return Response((await description_of(request).written()).to(request).openapi, media_type="application/json")


@documentation.get("/api/socket.json", include_in_schema=False)
@needs("viewer")
async def sockets() -> Response:
    """The messages of the sockets as JSON Schema."""
    return Response(json.dumps(await asyncio.to_thread(socket_schema)), media_type="application/schema+json")


@documentation.get("/docs", include_in_schema=False)
@needs("viewer")
async def page(request: Request) -> Response:
    """The same to read; a browser that opens it gets it in the page Help."""
    if wanted_page(request.scope):
        return RedirectResponse("help#docs", 303)
    return Response((await description_of(request).written()).to(request).page, media_type="text/html")


def description_of(request: Request) -> ApiDescription:
    """Return the description that the application was given at its start."""
    return request.app.state.description


def section(method: str, path: str, operation: OpenApi, schemas: OpenApi) -> str:
    """One operation: its purpose, what it takes, and an example."""
    rows = [
        row(each["name"], each["schema"], each["in"], each.get("required", False))
        for each in operation.get("parameters", ())
    ]
    content = operation.get("requestBody", {}).get("content", {})
    for kind, body in content.items():
        shape = schemas.get(body["schema"].get("$ref", "").rpartition("/")[2], {})
        fields = [
            row(name, what, "body", name in shape.get("required", ()))
            for name, what in shape.get("properties", {}).items()
        ]
        rows += fields or [f"| `{kind}` | body | file | yes |"]
    table = ["| takes | in | type | needed |", "| --- | --- | --- | --- |", *rows] if rows else []
    about = operation.get("description") or operation.get("summary") or ""
    who = "Anybody." if operation["x-role"] == "public" else f"Role: {operation['x-role']}."
    example = f"```sh\n{curl(method, path, operation, schemas)}\n```"
    return "\n\n".join(filter(None, (f"### `{method} {path}`", about, who, "\n".join(table), example)))


def curl(method: str, path: str, operation: OpenApi, schemas: OpenApi) -> str:
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


def example_of(shape: OpenApi, schemas: OpenApi) -> Any:
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


def row(name: str, shape: OpenApi, place: str, required: bool) -> str:
    """One parameter, or one key of a body."""
    kinds = [part.get("type") or part.get("$ref", "").rpartition("/")[2] for part in shape.get("anyOf", [shape])]
    words = ", ".join(f"`{value}`" for value in shape.get("enum", ())) or " or ".join(filter(None, kinds))
    return f"| `{name}` | {place} | {words} | {'required' if required else 'optional'} |"
