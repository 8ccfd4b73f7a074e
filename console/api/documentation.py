"""The description of this interface, without anything from other hosts."""

from __future__ import annotations

import html
from typing import Any

from fastapi import APIRouter, Request, Response

from console.roles import needs

documentation = APIRouter()

PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Beckon: HTTP interface</title>
<link rel="stylesheet" href="static/css/docs.css">
</head>
<body>
<main>
<h1>HTTP interface</h1>
<p>JSON in and out. Errors are <code>application/problem+json</code> with a sentence in <code>detail</code>.
Sign in by cookie (<code>POST api/login</code>) or send <code>Authorization: Bearer TOKEN</code>.
The whole description: <a href="openapi.json">openapi.json</a>.</p>
{sections}
</main>
</body>
</html>
"""


@documentation.get("/openapi.json", include_in_schema=False)
@needs("viewer")
async def openapi(request: Request) -> dict[str, Any]:
    """The interface as OpenAPI."""
    return request.app.openapi()


@documentation.get("/docs", include_in_schema=False)
@needs("viewer")
async def page(request: Request) -> Response:
    """The same to read."""
    sections = [
        section(path, method, operation)
        for path, operations in request.app.openapi()["paths"].items()
        for method, operation in operations.items()
    ]
    return Response(PAGE.format(sections="\n".join(sections)), media_type="text/html")


def section(path: str, method: str, operation: dict[str, Any]) -> str:
    """One operation."""
    told = html.escape(operation.get("description") or operation.get("summary") or "")
    answers = ", ".join(html.escape(status) for status in operation["responses"])
    body = operation.get("requestBody", {}).get("content", {}).get("application/json", {}).get("schema", {})
    name = html.escape(body.get("$ref", "").rpartition("/")[2])
    takes = f"<p>Takes <code>{name}</code>.</p>" if name else ""
    return (
        f"<section><h2><code>{method.upper()} {html.escape(path)}</code></h2>"
        f"<p>{told}</p>{takes}<p>Answers {answers}.</p></section>"
    )
