"""The page itself, the scene's page, and the three kinds of sockets."""

from functools import cache

from fastapi import APIRouter, Request, Response, WebSocket
from fastapi.concurrency import run_in_threadpool

from console.access.roles import needs
from console.api.audio_socket import AudioSocket
from console.api.page_files import NO_CACHE
from console.api.state_socket import StateSocket
from console.scene.viser_host.page import ScenePage

page = APIRouter()

PAGE_NAMES = ("calibrate", "hearing", "people", "maps", "recordings", "experiments", "connect", "help")
"""Pages beside the console itself; static/js/shell/pages.js has their rows. All are one document."""


async def shell(request: Request) -> Response:
    """The one document of all pages; it holds nothing secret and signs in by itself."""
    text = await run_in_threadpool(request.app.state.page_files.document)
    return Response(text, media_type="text/html", headers=NO_CACHE)


for path in ("/", *(f"/{name}{end}" for name in PAGE_NAMES for end in ("", ".html"))):
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
