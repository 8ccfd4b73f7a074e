"""The description of the HTTP interface: OpenAPI, and the same as a page of Help. Nothing comes from other hosts."""

from __future__ import annotations

import asyncio
import json
from dataclasses import dataclass

from fastapi import APIRouter, FastAPI, Request, Response

from console.access.roles import needs
from console.api.help import as_page
from console.api.typed_route import OpenApi, TypedRoute

documentation = APIRouter()

INTRO = """# HTTP interface

JSON in and out. Errors are `application/problem+json` with a sentence in `detail`. Sign in by cookie
(`POST /api/login`) or send `Authorization: Bearer TOKEN`. The description is in [openapi.json](openapi.json)."""


class DescribedApp(FastAPI):
    """An application whose description holds the structs of its answers."""

    def openapi(self) -> OpenApi:
        """The whole interface."""
        description = super().openapi()
        schemas = description.setdefault("components", {}).setdefault("schemas", {})
        for route in self.routes:
            if isinstance(route, TypedRoute):
                schemas |= route.components
        return description


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
            topics.setdefault(topic, []).append(section(f"{method.upper()} {path}", operation, schemas))
    chapters = (f"## {topic.capitalize()}\n\n" + "\n\n".join(sections) for topic, sections in topics.items())
    return "\n\n".join((INTRO, *chapters))


@documentation.get("/openapi.json", include_in_schema=False)
@needs("viewer")
async def openapi(request: Request) -> Response:
    """The interface as OpenAPI."""
    return Response((await description_of(request).written()).openapi, media_type="application/json")


@documentation.get("/docs", include_in_schema=False)
@needs("viewer")
async def page(request: Request) -> Response:
    """The same to read."""
    return Response((await description_of(request).written()).page, media_type="text/html")


def description_of(request: Request) -> ApiDescription:
    """Return the description that the application was given at its start."""
    return request.app.state.description


def section(call: str, operation: OpenApi, schemas: OpenApi) -> str:
    """One operation: its purpose, and what it takes."""
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
        rows += fields or [f"| `{kind}` | body | | |"]
    table = ["| takes | in | type | |", "| --- | --- | --- | --- |", *rows] if rows else []
    about = operation.get("description") or operation.get("summary") or ""
    return "\n\n".join(filter(None, (f"### `{call}`", about, "\n".join(table))))


def row(name: str, shape: OpenApi, place: str, required: bool) -> str:
    """One parameter, or one key of a body."""
    kinds = [part.get("type") or part.get("$ref", "").rpartition("/")[2] for part in shape.get("anyOf", [shape])]
    words = ", ".join(f"`{value}`" for value in shape.get("enum", ())) or " or ".join(filter(None, kinds))
    return f"| `{name}` | {place} | {words} | {'' if required else 'optional'} |"
