"""The page itself, the scene's page, and the three kinds of sockets."""

from __future__ import annotations

import gzip
import os
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request, Response, WebSocket
from fastapi.responses import FileResponse
from starlette.datastructures import Headers
from starlette.staticfiles import StaticFiles

from console.access.roles import needs
from console.api.audio_socket import AudioSocket
from console.api.state_socket import StateSocket
from console.scene.viser_host.page import ScenePage
from console.sentences import static_folder

page = APIRouter()

NO_CACHE = {"Cache-Control": "no-cache"}
TEXTS = (".js", ".css", ".svg", ".json")
PAGES = ("calibrate", "hearing", "people", "maps", "experiments", "connect", "help")
"""Pages beside the console itself; static/js/shell/pages.js has their rows. All are one document."""


@needs("public")
class PageFiles(StaticFiles):
    """The page's files; the browser asks for them each time and gets 304 when unchanged. Texts travel packed."""

    def file_response(
        self, full_path: Any, stat_result: os.stat_result, scope: Any, status_code: int = 200
    ) -> Response:
        """A file, never kept without asking."""
        response = super().file_response(full_path, stat_result, scope, status_code)
        response.headers.update(NO_CACHE)
        taken = "gzip" in Headers(scope=scope).get("accept-encoding", "")
        if not taken or response.status_code != 200 or not str(full_path).endswith(TEXTS):
            return response
        headers = {name: response.headers[name] for name in ("etag", "last-modified")}
        headers |= {**NO_CACHE, "content-encoding": "gzip", "vary": "Accept-Encoding"}
        return Response(
            packed(str(full_path), stat_result.st_mtime_ns), media_type=response.media_type, headers=headers
        )


@lru_cache(maxsize=512)
def packed(path: str, _changed: int) -> bytes:
    """A text file as it travels."""
    return gzip.compress(Path(path).read_bytes(), 6, mtime=0)


async def shell() -> FileResponse:
    """The one document of all pages; it holds nothing secret and signs in by itself."""
    return FileResponse(static_folder() / "index.html", headers=NO_CACHE)


for path in ("/", *(f"/{name}{end}" for name in PAGES for end in ("", ".html"))):
    page.get(path, include_in_schema=False)(needs("public")(shell))


@page.get("/scene/", include_in_schema=False)
@needs("viewer")
async def scene_page(request: Request) -> Response:
    """viser's page with its panel hidden."""
    packed = "gzip" in request.headers.get("accept-encoding", "")
    kept = scene_page_file()
    if request.headers.get("if-none-match") == kept.etag:
        return Response(status_code=304, headers=kept.headers)
    headers = {**kept.headers, **({"content-encoding": "gzip"} if packed else {})}
    return Response(kept.packed if packed else kept.plain, media_type="text/html", headers=headers)


@page.websocket("/ws")
@needs("viewer")
async def talk(socket: WebSocket) -> None:
    """State and camera down, hand and words up."""
    await StateSocket(socket.app.state.runtime, socket, socket.scope["person"]).run()


@page.websocket("/ws/audio")
@needs("viewer")
async def listen(socket: WebSocket) -> None:
    """A microphone up, transcripts down."""
    await AudioSocket(socket.app.state.runtime, socket, socket.scope["person"]).run()


@page.websocket("/scene/ws/{tab}")
@needs("viewer")
async def scene_socket(socket: WebSocket, tab: str) -> None:
    """The 3-D scene of one tab."""
    await socket.app.state.runtime.scene.talk(socket, socket.scope["person"], tab)


@page.websocket("/scene")
@page.websocket("/scene/")
@needs("viewer")
async def lone_scene_socket(socket: WebSocket) -> None:
    """The 3-D scene opened by itself."""
    await socket.app.state.runtime.scene.talk(socket, socket.scope["person"], "")


@cache
def scene_page_file() -> ScenePage:
    """Read and packed once."""
    return ScenePage()
