"""The web application: the list of its topics."""

import asyncio
import mimetypes
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from importlib import import_module
from types import SimpleNamespace
from typing import cast

from fastapi import APIRouter, FastAPI
from starlette.routing import Mount

from console import beckon_version
from console.access.guard import Access
from console.api.application import complete, opened
from console.api.documentation import STEPS, ApiDescription, DescribedApp
from console.api.help import help_pages
from console.api.page import scene_page_file
from console.api.page_files import PageFiles
from console.runtime import Runtime
from core.sentences import static_folder

ROUTER_MODULES = (
    "stop",
    "commands",
    "state",
    "camera",
    "hearing",
    "recognizer",
    "lease",
    "login",
    "sessions",
    "maps",
    "places",
    "zones",
    "edits",
    "routes",
    "connection",
    "slam",
    "playback",
    "recordings",
    "own_navigation",
    "calibration",
    "calibration_files",
    "simulation",
    "settings",
    "voice",
    "speech_quality",
    "experiments",
    "reports",
    "microphones",
    "people",
    "documentation",
    "help",
    "page",
)
"""Modules of `console.api` with routers, in the order of the description."""
ROUTERS = tuple(
    router
    for name in ROUTER_MODULES
    for router in vars(import_module(f"console.api.{name}")).values()
    if isinstance(router, APIRouter)
)


def create_app(runtime: Runtime) -> FastAPI:
    """The application around a runtime. Raises RuntimeError when a route declares no role."""

    @asynccontextmanager
    async def life(app: FastAPI) -> AsyncGenerator[None]:
        runtime.keep(prepare(app.state.description))  # while the robot is being opened
        async with opened(app):
            yield

    app = DescribedApp(
        title="Beckon",
        version=beckon_version(),
        description=STEPS,
        lifespan=life,
        docs_url=None,
        redoc_url=None,
        openapi_url=None,
    )
    app.cookie = runtime.access.cookie
    app.state.description = ApiDescription(app)
    files = PageFiles(static_folder())
    routes = [route for router in ROUTERS for route in router.routes if route not in help_pages.routes]
    static = *help_pages.routes, Mount("/static", files, name="static")  # first, for most requests are for files
    complete(app, runtime, files, [*static, *routes])
    return app


def described_app() -> FastAPI:
    """The same without a robot: nothing can be asked of it but what it takes and answers."""
    return create_app(cast(Runtime, SimpleNamespace(history=None, access=Access())))


async def prepare(description: ApiDescription) -> None:
    """Prepare slow parts once, not on the event loop, so that the first request delays nobody."""
    await description.written()
    await asyncio.to_thread(scene_page_file)
    await asyncio.to_thread(mimetypes.init)
