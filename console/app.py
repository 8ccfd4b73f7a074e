"""The web application: the list of its routers, the guard in front, one place for errors."""

import asyncio
import logging
import mimetypes
import secrets
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager
from types import SimpleNamespace
from typing import Any, cast
from urllib.parse import quote

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import RedirectResponse
from starlette.exceptions import HTTPException
from starlette.routing import Mount

from console import beckon_version
from console.access.guard import Access, AccessGuard, dress
from console.access.roles import check_roles
from console.api.calibration import calibration
from console.api.calibration_files import calibration_files
from console.api.commands import commands
from console.api.connection import connection
from console.api.documentation import STEPS, ApiDescription, DescribedApp, documentation
from console.api.edits import edits
from console.api.experiments import experiments
from console.api.hearing import hearing
from console.api.help import help_pages
from console.api.lease import lease
from console.api.login import login
from console.api.maps import maps
from console.api.metrics import metrics
from console.api.microphones import microphones
from console.api.own_navigation import own_navigation
from console.api.page import page, scene_page_file
from console.api.page_files import PageFiles
from console.api.pending_command import pending_command
from console.api.people import people
from console.api.places import places
from console.api.playback import playback
from console.api.recognizer import looking, recognizer
from console.api.recordings import recordings
from console.api.reports import reports
from console.api.routes import routes
from console.api.sessions import sessions
from console.api.settings import settings
from console.api.simulation import simulation
from console.api.slam import slam
from console.api.speech_quality import speech_quality
from console.api.state import state
from console.api.stop import stop
from console.api.voice import voice
from console.api.zones import zones
from console.control.durable_answers import DurableAnswers
from console.http.problems import Problem, problem_of, wanted_page
from console.runtime import Runtime
from core.errors import BeckonError
from core.sentences import static_folder

log = logging.getLogger(__name__)

ROUTERS = (
    stop,
    commands,
    pending_command,
    state,
    hearing,
    recognizer,
    looking,
    lease,
    login,
    sessions,
    maps,
    places,
    metrics,
    zones,
    edits,
    routes,
    connection,
    slam,
    playback,
    recordings,
    own_navigation,
    calibration,
    calibration_files,
    simulation,
    settings,
    voice,
    speech_quality,
    experiments,
    reports,
    microphones,
    people,
    documentation,
    help_pages,
    page,
)

SENTENCES = {
    404: "There is nothing at this address; the addresses are listed under /docs.",
    405: "This address does not take that method.",
}


def create_app(runtime: Runtime) -> FastAPI:
    """The application around a runtime. Raises RuntimeError when a route declares no role."""

    @asynccontextmanager
    async def life(_: FastAPI) -> AsyncGenerator[None]:
        runtime.keep(asyncio.create_task(prepare(description)))  # while the robot is being opened
        try:
            await runtime.open()
            yield
        finally:
            await runtime.close()

    app = DescribedApp(
        title="Beckon",
        version=beckon_version(),
        description=STEPS,
        lifespan=life,
        docs_url=None,
        redoc_url=None,
        openapi_url=None,
    )
    app.state.runtime = runtime
    app.cookie = runtime.access.cookie
    app.state.description = description = ApiDescription(app)
    for router in ROUTERS:
        app.router.routes.extend(router.routes)
    app.state.page_files = PageFiles(static_folder())
    app.router.routes.append(Mount("/static", app.state.page_files, name="static"))
    check_roles(app.routes)
    app.add_exception_handler(Problem, on_problem)
    app.add_exception_handler(BeckonError, on_error)
    app.add_exception_handler(RequestValidationError, on_invalid)
    app.add_exception_handler(HTTPException, on_http)
    app.add_exception_handler(Exception, on_fault)
    app.add_middleware(DurableAnswers, history=runtime.history)
    app.add_middleware(AccessGuard, routes=app.routes, access=runtime.access)
    return app


def described_app() -> FastAPI:
    """The same without a robot: nothing can be asked of it but what it takes and answers."""
    return create_app(cast(Runtime, SimpleNamespace(history=None, access=Access())))


async def prepare(description: ApiDescription) -> None:
    """Prepare slow parts once, not on the event loop, so that the first request delays nobody."""
    await description.written()
    await asyncio.to_thread(scene_page_file)
    await asyncio.to_thread(mimetypes.init)


def problem_response(problem: Problem) -> Response:
    """A problem as a response."""
    return Response(problem.body(), problem.status, problem.headers, "application/problem+json")


async def on_problem(_: Request, problem: Exception) -> Response:
    """A refusal of ours."""
    assert isinstance(problem, Problem)
    return problem_response(problem)


async def on_error(_: Request, error: Exception) -> Response:
    """A sentence of the core."""
    assert isinstance(error, BeckonError)
    return problem_response(problem_of(error))


async def on_invalid(_: Request, invalid: Exception) -> Response:
    """A body of the wrong form: which fields, and what is wrong with them; never their values."""
    assert isinstance(invalid, RequestValidationError)
    wrong = [{"field": field_of(error), "wrong": error["type"]} for error in invalid.errors()[:10]]
    return problem_response(
        Problem(422, "The request has not the form that is asked for; see /docs.", more={"errors": wrong})
    )


def field_of(error: Any) -> str:
    """The name of the field that is wrong, where it is one of ours."""
    ours = error["type"] != "extra_forbidden" and len(error["loc"]) > 1
    return str(error["loc"][1]) if ours else ""


async def on_http(request: Request, error: Exception) -> Response:
    """An error of the framework itself: 404, 405. A browser that opens no page's address gets one that says so."""
    assert isinstance(error, HTTPException)
    root = wanted_page(request.scope)
    if error.status_code == 404 and root is not None:
        return RedirectResponse(f"{root}#nothing-at={quote(request.url.path, safe='')}", 303)
    detail = SENTENCES.get(error.status_code, "This request cannot be answered.")
    return problem_response(Problem(error.status_code, detail, headers=error.headers))


async def on_fault(_: Request, fault: Exception) -> Response:
    """A fault of ours: an id that the log knows, nothing else."""
    number = secrets.token_hex(4)
    log.error("Fault %s", number, exc_info=fault)
    problem = Problem(500, "Something went wrong inside the console.", more={"id": number})
    response = problem_response(problem)
    for name, value in dress(()):
        response.headers[name.decode()] = value.decode()
    return response
