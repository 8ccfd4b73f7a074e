"""From options to a running fleet."""

import ipaddress
import os
import socket
import time
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, replace

from fastapi import FastAPI, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.exceptions import RequestValidationError
from fastapi.responses import RedirectResponse
from starlette.exceptions import HTTPException
from starlette.routing import Mount, Route

from console import beckon_version
from console.access.guard import Access, AccessGuard
from console.access.logins import Logins
from console.access.records import AccessFile
from console.access.roles import check_roles, needs
from console.api.help import help_pages
from console.api.login import login
from console.api.page import PAGE_NAMES, scene_page
from console.api.page_files import NO_CACHE, PageFiles
from console.api.sessions import sessions
from console.app import on_error, on_fault, on_http, on_invalid, on_problem
from console.control.durable_answers import DurableAnswers
from console.data_folder import home_folder, locked
from console.fleet.authority import Authority
from console.fleet.bus import DEFAULT_PORT, FleetAddress
from console.fleet_server.api import fleet
from console.fleet_server.proxy import RobotConsoles
from console.fleet_server.runtime import FleetRuntime
from console.http.connection_limits import raise_file_limit
from console.http.problems import Problem
from console.http.server import Server, configured, run_until_left
from console.logging_setup import start_logging
from console.options import LOOPBACK, Options, address_of, bound, check, hosts_of, in_address, is_wildcard
from console.serve import announce
from core.errors import BeckonError
from core.sentences import static_folder

FOLDER = "fleet"  # in the data folder
PAGE = "fleet.html"


@dataclass(frozen=True)
class FleetOptions:
    """The options of `beckon fleet`; `web` as of a console."""

    web: Options
    listen: str = f"tls/0.0.0.0:{DEFAULT_PORT}"


def create_fleet_app(runtime: FleetRuntime) -> FastAPI:
    """The application around a fleet. Raises RuntimeError when a route declares no role."""

    @asynccontextmanager
    async def life(_: FastAPI) -> AsyncGenerator[None]:
        try:
            await runtime.open()
            yield
        finally:
            await runtime.close()

    app = FastAPI(title="Beckon fleet", version=beckon_version(), lifespan=life, docs_url=None, redoc_url=None)
    app.openapi_url = None
    app.state.runtime = runtime
    app.state.page_files = PageFiles(static_folder())
    app.router.routes[:] = [*fleet.routes, *login.routes, *sessions.routes, *help_pages.routes, *page_routes()]
    app.router.routes.append(Mount("/static", app.state.page_files, name="static"))
    app.router.routes.append(Mount("/robots/{name}/static", app.state.page_files, name="robot-static"))
    app.router.routes.append(Mount("/robots", RobotConsoles(runtime), name="robots"))
    check_roles(app.routes)
    for kind, answer in (
        (Problem, on_problem),
        (BeckonError, on_error),
        (RequestValidationError, on_invalid),
        (HTTPException, on_http),
        (Exception, on_fault),
    ):
        app.add_exception_handler(kind, answer)
    app.add_middleware(DurableAnswers, history=runtime.history)
    app.add_middleware(AccessGuard, routes=app.routes, access=runtime.access)
    return app


def page_routes() -> list[Route]:
    """The fleet's own page, and the pages of every robot's console, from the same files."""

    @needs("public")
    async def own(request: Request) -> Response:
        text = await run_in_threadpool(request.app.state.page_files.document, PAGE)
        return Response(text, media_type="text/html", headers=NO_CACHE)

    @needs("public")
    async def console_page(request: Request) -> Response:
        if request.scope["person"] is None:
            return RedirectResponse("/")
        text = await run_in_threadpool(request.app.state.page_files.document)
        return Response(text, media_type="text/html", headers=NO_CACHE)

    paths = ("", *(f"{name}{end}" for name in PAGE_NAMES for end in ("", ".html")))
    consoles = [Route(f"/robots/{{name}}/{path}", console_page, methods=["GET"]) for path in paths]
    scene = Route("/robots/{name}/scene/", scene_page, methods=["GET"])
    return [Route("/", own, methods=["GET"]), *consoles, scene]


def serve_fleet(options: FleetOptions) -> None:
    """Run the fleet until a signal ends it. Raises BadInput and Unavailable with a sentence."""
    web, listen = options.web, FleetAddress.parse(options.listen)
    check(web)
    home = home_folder(web.data) / FOLDER
    web = replace(web, data=home)
    os.umask(0o077)
    most = raise_file_limit()
    home.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    with locked(home) as lock, bound(web.host, web.port) as listener:
        start_logging(web.log or home / "console.log")
        port = int(listener.getsockname()[1])
        authority = Authority(home)
        authority.prepare(router_hosts(listen.host, web))
        lock.announce(port, address_of(web, port))
        logins = Logins(AccessFile(home), time.time() - time.monotonic())
        logins.open_file()
        elsewhere = "" if in_address(web.host) in LOOPBACK else address_of(web, port)
        access = Access(logins, hosts_of(web.host, *web.allow_hosts), f"beckon_{port}", elsewhere)
        runtime = FleetRuntime(home, access, authority, listen)
        config = configured(create_fleet_app(runtime), web.tls_cert, web.tls_key, most)
        server = Server(config, runtime, lambda: announce(web, port, access))
        run_until_left(server, listener, runtime)


def router_hosts(listen: str, web: Options) -> tuple[str, ...]:
    """The names and addresses by which robots may reach the router: they stand in its certificate."""
    named = [host for host in (listen, web.host, *web.allow_hosts) if not is_wildcard(host)]
    if not is_wildcard(listen):
        return tuple(named)
    own = [socket.gethostname()]
    with suppress(OSError):
        own += [str(row[4][0]) for row in socket.getaddrinfo(own[0], None, socket.AF_INET)]
    with suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asked:
        asked.connect(("192.0.2.1", 9))  # sends nothing: only which of our addresses leads out
        own.append(asked.getsockname()[0])
    return tuple(dict.fromkeys([*named, *(host for host in own if _is_usable(host))]))


def _is_usable(host: str) -> bool:
    with suppress(ValueError):
        return not ipaddress.ip_address(host).is_unspecified
    return all(part.isalnum() or part == "-" for part in host.replace(".", "").replace("-", ""))
