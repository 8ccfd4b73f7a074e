"""From options to a running fleet."""

import ipaddress
import socket
from contextlib import suppress
from dataclasses import dataclass, replace

from fastapi import FastAPI, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import RedirectResponse
from fastapi.routing import APIRoute
from starlette.routing import Mount, Route

from console import beckon_version
from console.access.roles import needs
from console.api.application import complete, opened
from console.api.help import help_page, help_pages
from console.api.login import login
from console.api.page import PAGE_NAMES, scene_page
from console.api.page_files import NO_CACHE, PageFiles
from console.api.sessions import sessions
from console.data_folder import home_folder
from console.fleet.authority import Authority
from console.fleet.bus import DEFAULT_PORT, FleetAddress
from console.fleet_server.api import fleet
from console.fleet_server.proxy import RobotConsoles
from console.fleet_server.runtime import FleetRuntime
from console.http.server import Server, configured, run_until_left
from console.listening import announce, listening
from console.options import Options, check, is_wildcard
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

    app = FastAPI(
        title="Beckon fleet",
        version=beckon_version(),
        lifespan=opened,
        docs_url=None,
        redoc_url=None,
        openapi_url=None,
    )
    files = PageFiles(static_folder())
    routes = [*fleet.routes, *login.routes, *sessions.routes, *help_pages.routes, *page_routes()]
    mounts = [
        Mount("/static", files, name="static"),
        Mount("/robots/{name}/static", files, name="robot-static"),
        Mount("/robots", RobotConsoles(runtime), name="robots"),
    ]
    complete(app, runtime, files, [*routes, *mounts])
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
    docs = APIRoute("/robots/{name}/static/docs/{path:path}", help_page, methods=["GET"])
    return [Route("/", own, methods=["GET"]), *consoles, scene, docs]


def serve_fleet(options: FleetOptions) -> None:
    """Run the fleet until a signal ends it. Raises BadInput and Unavailable with a sentence."""
    web, listen = options.web, FleetAddress.parse(options.listen)
    check(web)
    home = home_folder(web.data) / FOLDER
    web = replace(web, data=home)
    home.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    authority = Authority(home)
    with listening(web, home) as found:
        authority.prepare(router_hosts(listen.host, web))
        runtime = FleetRuntime(home, found.access, authority, listen)
        config = configured(create_fleet_app(runtime), web.tls_cert, web.tls_key, found.most)
        server = Server(config, runtime, lambda: announce(web, found.port, found.access))
        run_until_left(server, found.listener, runtime)


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
