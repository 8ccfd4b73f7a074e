"""The description of this interface, without anything from other hosts."""

from __future__ import annotations

import asyncio
import html
import json
from dataclasses import dataclass

from fastapi import APIRouter, FastAPI, Request, Response

from console.access.roles import needs
from console.api.typed_route import OpenApi, TypedRoute

documentation = APIRouter()

PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Beckon: HTTP interface</title>
<link rel="stylesheet" href="static/css/tokens.css">
<link rel="stylesheet" href="static/css/docs.css">
</head>
<body>
<main>
<header>
<h1>HTTP interface</h1>
<p>JSON in and out. Errors are <code>application/problem+json</code> with a sentence in <code>detail</code>.
Sign in by cookie (<code>POST api/login</code>) or send <code>Authorization: Bearer TOKEN</code>.
The whole description is in <a href="openapi.json">openapi.json</a>; back to <a href="./">the console</a>.</p>
</header>
{sections}
</main>
</body>
</html>
"""


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
    topics: dict[str, list[str]] = {}
    for path, operations in description["paths"].items():
        for method, operation in operations.items():
            topics.setdefault(operation["tags"][0], []).append(
                entry(path, method, operation, description["components"])
            )
    sections = [f"<section><h2>{html.escape(topic)}</h2>{''.join(rows)}</section>" for topic, rows in topics.items()]
    return StaticDescription(json.dumps(description).encode(), PAGE.format(sections="\n".join(sections)).encode())


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


def entry(path: str, method: str, operation: OpenApi, components: OpenApi) -> str:
    """One operation: its name, its purpose, its fields."""
    text = html.escape(operation.get("description") or operation.get("summary") or "")
    body = operation.get("requestBody", {}).get("content", {}).get("application/json", {}).get("schema", {})
    shape = components["schemas"].get(body.get("$ref", "").rpartition("/")[2], {})
    rows = "".join(
        field(name, what, name in shape.get("required", ())) for name, what in shape.get("properties", {}).items()
    )
    takes = f"<dl>{rows}</dl>" if rows else ""
    return (
        f'<article><h3><span class="{method}">{method.upper()}</span> <code>{html.escape(path)}</code></h3>'
        f"<p>{text}</p>{takes}</article>"
    )


def field(name: str, shape: OpenApi, required: bool) -> str:
    """One key of a body."""
    kinds = [part.get("type", "") for part in shape.get("anyOf", [shape])]
    words = ", ".join(f"“{value}”" for value in shape.get("enum", ())) or " or ".join(filter(None, kinds))
    optional = "" if required else ", may be left out"
    return f"<dt><code>{html.escape(name)}</code></dt><dd>{html.escape(words)}{optional}</dd>"
