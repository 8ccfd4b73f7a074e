"""Signing in and out: a token opens a login, the login lives in a cookie that no script can read."""

import re
import time
import unicodedata

import msgspec
from fastapi import Request, Response
from pydantic import Field

from console.access.logins import ANYBODY, LOGIN_LIFE_S, Person
from console.access.records import BY_KEY
from console.access.roles import KEY, needs
from console.api import AccessRules, Dispatcher, HistoryInUse, RequestBody, Sockets, Who, problems, router
from console.http.problems import Problem
from console.people.store import MAX_NAME_CHARACTERS, name_of

login = router("login", 507)


class LoginRequest(RequestBody):
    """The token that the console printed when it started."""

    token: str = Field(max_length=200)
    name: str = Field(default="", max_length=4 * MAX_NAME_CHARACTERS)


class PersonRow(msgspec.Struct, frozen=True):
    """Whom the console knows behind a request."""

    id: str
    name: str
    role: str


class SignedOut(msgspec.Struct, frozen=True):
    """The login is over."""

    signed_out: bool = True


OURS = re.compile(r"(operator|viewer|admin|local|console)[\s\d()]*")  # what those are called who say no name


@login.post("/login", responses=problems(401, 429))
@needs("public", body=KEY)
async def sign_in(
    shown: LoginRequest,
    access: AccessRules,
    sockets: Sockets,
    history: HistoryInUse,
    request: Request,
    response: Response,
) -> PersonRow:
    """A token → a cookie."""
    now = time.monotonic()
    if access.no_auth:
        return person_row(ANYBODY)
    address = request.client.host if request.client else ""
    own = request.cookies.get(access.cookie, "")
    opened = access.logins.open(shown.token, called(shown.name), now, own, sockets.are_open)
    if opened is None:
        if access.logins.blocked(address, now):
            headers = {"Retry-After": "60"}
            raise Problem(429, "Too many wrong tokens from your address; wait a minute.", headers=headers)
        access.logins.guessed(address, now)
        raise Problem(401, "That token is not valid. Open the address that the console printed when it started.")
    cookie, person = opened
    response.set_cookie(
        access.cookie,
        cookie,
        max_age=int(LOGIN_LIFE_S),
        path=request.scope.get("root_path") or "/",
        httponly=True,
        samesite="strict",
        secure=request.url.scheme == "https",
    )
    if cookie != own:
        history.add("login", person)
    return person_row(person)


@login.post("/logout", responses=problems(409))
@needs("viewer")
async def sign_out(
    dispatcher: Dispatcher,
    access: AccessRules,
    sockets: Sockets,
    history: HistoryInUse,
    who: Who,
    request: Request,
    response: Response,
) -> SignedOut:
    """Ends the login, its sockets and its lease. A key that is shown with every request has no login to end."""
    if who.id.startswith(BY_KEY):
        raise Problem(409, "You show your key with every request, so there is nothing to sign out; revoke the key.")
    dispatcher.forget(who)
    access.logins.close(who)
    sockets.close_of(who, 1008, "Signed out.")
    history.add("logout", who)
    response.delete_cookie(access.cookie, path=request.scope.get("root_path") or "/", samesite="strict")
    return SignedOut()


@login.get("/me")
@needs("viewer")
async def me(who: Who) -> PersonRow:
    """The person of this login."""
    return person_row(who)


def called(name: str) -> str:
    """Return the name that a person asks for, or "". Raises Problem 422 for a name that the console gives itself."""
    if not name.strip():
        return ""
    tidy = name_of(name)
    if OURS.fullmatch(unicodedata.normalize("NFKC", tidy).casefold()):
        raise Problem(422, "The console calls people so who say no name; take another.")
    return tidy


def person_row(person: Person) -> PersonRow:
    """A person, without anything secret."""
    return PersonRow(person.id, person.name, person.role)
