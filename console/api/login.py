"""Signing in and out: a token opens a login, the login lives in a cookie that no script can read."""

from __future__ import annotations

import time
from typing import Any

from fastapi import Request, Response
from pydantic import Field

from console.api import Behind, Who, Wish, router
from console.logins import ANYBODY, LIFE, Person
from console.problems import Problem
from console.roles import KEY, needs

login = router("login")


class Token(Wish):
    """What the console printed when it started."""

    token: str = Field(max_length=200)
    name: str = Field(default="", max_length=40, pattern=r"^[^\x00-\x1f\x7f]*$")


@login.post("/login")
@needs("public", body=KEY)
async def sign_in(shown: Token, behind: Behind, request: Request, response: Response) -> dict[str, Any]:
    """A token → a cookie."""
    access, now = behind.access, time.monotonic()
    if access.no_auth:
        return told(ANYBODY)
    address = request.client.host if request.client else ""
    if access.logins.blocked(address, now):
        raise Problem(429, "Too many wrong tokens from your address; wait a minute.", headers={"Retry-After": "60"})
    own = request.cookies.get(access.cookie, "")
    opened = access.logins.open(shown.token, shown.name.strip(), now, own, behind.sockets.are_open)
    if opened is None:
        access.logins.guessed(address, now)
        raise Problem(401, "That token is not valid. Open the address that the console printed when it started.")
    cookie, person = opened
    response.set_cookie(
        access.cookie,
        cookie,
        max_age=int(LIFE),
        path=request.scope.get("root_path") or "/",
        httponly=True,
        samesite="strict",
        secure=request.url.scheme == "https",
    )
    if cookie != own:
        behind.history.add("login", person)
    return told(person)


@login.post("/logout")
@needs("viewer")
async def sign_out(behind: Behind, who: Who, request: Request, response: Response) -> dict[str, Any]:
    """Ends the login, its sockets and its lease."""
    behind.door.forget(who)
    behind.access.logins.close(who)
    behind.sockets.close_of(who, 1008, "Signed out.")
    behind.history.add("logout", who)
    response.delete_cookie(behind.access.cookie, path=request.scope.get("root_path") or "/", samesite="strict")
    return {"signed_out": True}


@login.get("/me")
@needs("viewer")
async def me(who: Who) -> dict[str, Any]:
    """Who I am here."""
    return told(who)


def told(person: Person) -> dict[str, Any]:
    """A person, without anything secret."""
    return {"id": person.id, "name": person.name, "role": person.role}
