"""The frame of every application: one place for errors, the guard in front."""

import logging
import secrets
from collections.abc import AsyncGenerator, Sequence
from contextlib import asynccontextmanager
from typing import Any
from urllib.parse import quote

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import RedirectResponse
from starlette.exceptions import HTTPException
from starlette.routing import BaseRoute

from console.access.guard import AccessGuard, dress
from console.access.roles import check_roles
from console.api.page_files import PageFiles
from console.control.durable_answers import DurableAnswers
from console.http.problems import Problem, problem_of, wanted_page
from core.errors import BeckonError

log = logging.getLogger(__name__)

SENTENCES = {
    404: "There is nothing at this address; the addresses are listed under /docs.",
    405: "This address does not take that method.",
}


@asynccontextmanager
async def opened(app: FastAPI) -> AsyncGenerator[None]:
    try:
        await app.state.runtime.open()
        yield
    finally:
        await app.state.runtime.close()


def complete(app: FastAPI, runtime: Any, files: PageFiles, routes: Sequence[BaseRoute]) -> None:
    """Put an application around a runtime. Raises RuntimeError when a route declares no role."""
    app.state.runtime, app.state.page_files = runtime, files
    app.router.routes[:] = routes
    check_roles(app.routes)
    for kind, answer in ANSWERS.items():
        app.add_exception_handler(kind, answer)
    app.add_middleware(DurableAnswers, history=runtime.history)
    app.add_middleware(AccessGuard, routes=app.routes, access=runtime.access)


def problem_response(problem: Problem) -> Response:
    return Response(problem.body(), problem.status, problem.headers, "application/problem+json")


async def on_problem(_: Request, problem: Exception) -> Response:
    assert isinstance(problem, Problem)
    return problem_response(problem)


async def on_error(_: Request, error: Exception) -> Response:
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


ANSWERS = {
    Problem: on_problem,
    BeckonError: on_error,
    RequestValidationError: on_invalid,
    HTTPException: on_http,
    Exception: on_fault,
}
