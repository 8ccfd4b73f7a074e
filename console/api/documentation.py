"""The descriptions of the HTTP interface and of the sockets' messages, and the reference page of Help."""

import asyncio
import inspect
import json
import re
from typing import Any, get_args

import msgspec
from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.responses import RedirectResponse

from console.access.roles import FORGOTTEN, declared, needs
from console.api import PROBLEM, PROBLEMS
from console.api.help import rendered
from console.api.typed_route import REF, OpenApi, TypedRoute, schemas_of
from console.http.problems import wanted_page
from console.messages import audio, inbound, state
from core.sentences import static_folder

documentation = APIRouter()

ADDRESS = "http://127.0.0.1:8420"  # stands for the address by which the reader has it
FILES: OpenApi = {
    "BinaryFile": {"type": "string", "format": "binary", "description": "A file, as its media type says."},
    "TextFile": {"type": "string", "description": "A file of text, as its media type says."},
}

STEPS = """Three steps to a robot that moves:

1. **A key**: `beckon token add NAME --role operator` prints one; send it as `Authorization: Bearer KEY`.
2. **A command**: `POST /api/commands` with `{"text": "turn left"}` takes control where nobody has it and answers 202
   with an `id`; `GET /api/commands/{number}` tells how it ends.
3. **The lease**: one person drives at a time. `POST /api/lease` takes, asks for or gives back control;
   `POST /api/stop` stops the robot, no matter who drives.

Errors are `application/problem+json` with a sentence in `detail` to act on. The messages of the sockets `/ws` and
`/ws/audio` are described in `/api/socket.json`."""
DIALECT = "https://json-schema.org/draft/2020-12/schema"
UNIONS = {
    "Up": (inbound.Up, "From the browser on /ws"),
    "Down": (state.Down, "To the browser on /ws; the camera comes as binary beside it"),
    "AudioUp": (audio.AudioUp, "From the browser on /ws/audio; the sound goes as binary beside it"),
    "AudioDown": (audio.AudioDown, "To the browser on /ws/audio"),
}


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
    need = declared(route) or FORGOTTEN
    for method, operation in operations.items():
        if method.upper() not in (route.methods or ()):
            continue
        operation["security"] = [] if need.role == "public" else [{"key": []}, {"login": []}]
        operation["x-role"] = need.role
        operation["operationId"] = operation_id(method, route.path)
        if not need.body.is_json:
            file = {"schema": {"type": "string", "format": "binary"}}
            operation["requestBody"] = {"required": True, "content": dict.fromkeys(need.body.types, file)}
        describe_problems(method, route, operation)
        for answer in operation["responses"].values():
            for kind, content in answer.get("content", {}).items():
                if not content.get("schema"):
                    file = "TextFile" if kind.startswith("text/") or kind.endswith("+xml") else "BinaryFile"
                    content["schema"] = {"$ref": REF.format(name=file)}


class ApiDescription:
    """The description as OpenAPI, written once and not on the event loop: it takes a third of a second."""

    def __init__(self, app: FastAPI) -> None:
        self._app = app
        self._written: asyncio.Task[str] | None = None

    async def written(self) -> str:
        if self._written is None:
            self._written = asyncio.create_task(asyncio.to_thread(lambda: json.dumps(self._app.openapi())))
        return await asyncio.shield(self._written)


def at_address(text: str, request: Request) -> str:
    """The text with the address by which this reader has the console; the guard has checked its host."""
    return text.replace(ADDRESS, str(request.base_url).rstrip("/"))


@documentation.get("/openapi.json", include_in_schema=False)
@needs("viewer")
async def openapi(request: Request) -> Response:
    """The interface as OpenAPI."""
    description: ApiDescription = request.app.state.description
    return Response(at_address(await description.written(), request), media_type="application/json")


@documentation.get("/api/socket.json", include_in_schema=False)
@needs("viewer")
async def sockets() -> Response:
    """The messages of the sockets as JSON Schema."""
    return Response(json.dumps(await asyncio.to_thread(socket_schema)), media_type="application/schema+json")


@documentation.get("/docs", include_in_schema=False)
@needs("viewer")
async def page(request: Request) -> Response:
    """The interface to read; a browser that opens it gets it in the page Help."""
    if wanted_page(request.scope):
        return RedirectResponse("help#docs", 303)
    file = static_folder() / "docs" / "reference" / "rest.md"
    text = await asyncio.to_thread(rendered, file, file.stat().st_mtime_ns, "./")
    return Response(at_address(text, request), media_type="text/html")


def socket_schema() -> dict[str, Any]:
    """One schema document: every message and part under `$defs`, and a union for each direction of each socket."""
    kinds = [kind for union, _ in UNIONS.values() for kind in get_args(union)]
    shapes, parts = msgspec.json.schema_components(kinds, ref_template="#/$defs/{name}")
    for part in parts.values():
        if "description" in part:
            part["description"] = inspect.cleandoc(part["description"])  # as msgspec itself does from 0.23 on
    by_kind = dict(zip(kinds, shapes, strict=True))
    unions = {
        name: {"description": about, "oneOf": [by_kind[kind] for kind in get_args(union)]}
        for name, (union, about) in UNIONS.items()
    }
    return {
        "$schema": DIALECT,
        "title": "Messages of Beckon's sockets",
        "anyOf": [{"$ref": f"#/$defs/{name}"} for name in unions],
        "$defs": parts | unions,
    }
