"""Logins, and the keys by which one may sign in: links for others, and the end of a login or of a key."""

import re
import time
from typing import Literal

import msgspec
from fastapi import Request
from pydantic import Field

from console.access.guard import ON_THIS_MACHINE, Access
from console.access.login_keeper import ENDED
from console.access.logins import LINK_LIFE_S, Person, new_token
from console.access.records import KeyKind
from console.access.roles import needs
from console.api import AccessRules, Behind, HistoryInUse, RequestBody, Sockets, Who, router
from console.api.login import called
from console.http import qr
from console.http.problems import Problem
from console.people.store import MAX_NAME_CHARACTERS

sessions = router("sessions", 507)

HERE = ("127.0.0.1", "localhost", "[::1]")
ALONE = (
    "This console listens on this machine alone, so the link opens only here. For a phone, start it with "
    "--host and this machine's address in the network."
)


class SignedIn(msgspec.Struct, frozen=True):
    """A browser that is signed in."""

    id: str
    name: str
    role: str
    since_s: float  # Unix time
    end_s: float  # Unix time
    present: bool  # a page of theirs is open
    yours: bool


class KeyRow(msgspec.Struct, frozen=True):
    """A key: what it opens, and until when; never the key itself."""

    id: str
    name: str
    role: str
    kind: KeyKind  # start: printed at a start; link: made for someone; file: --token-file; program: fixed
    since_s: float  # Unix time
    end_s: float | None  # Unix time; null: until it is revoked


class SignInList(msgspec.Struct, frozen=True):
    """All logins and keys, eldest first."""

    sessions: list[SignedIn]
    keys: list[KeyRow]


class NewLink(msgspec.Struct, frozen=True):
    """A link that signs in who opens it. It is shown this once; only its fingerprint is kept."""

    id: str
    address: str
    end_s: float  # Unix time
    qr: list[str]  # rows of modules, "1" dark, without a margin
    note: str | None  # why no other machine can open it


class LinkRequest(RequestBody):
    """Whom the link is for."""

    role: Literal["viewer", "operator"] = "viewer"
    name: str = Field(default="", max_length=4 * MAX_NAME_CHARACTERS, examples=["tablet"])


@sessions.get("/sessions")
@needs("admin")
async def listed(access: AccessRules, sockets: Sockets, who: Who) -> SignInList:
    """List who is signed in, and by which keys one may sign in."""
    rows = [
        SignedIn(one.id, one.name, one.role, one.made_s, one.end_s, sockets.are_open(one.person), one.id == who.id)
        for one in access.logins.all_logins()
    ]
    keys = [KeyRow(key.id, key.name, key.role, key.kind, key.made_s, key.end_s) for key in access.logins.all_keys()]
    return SignInList(rows, keys)


@sessions.delete("/sessions/{id}", status_code=204)
@needs("admin")
async def end_session(id: str, behind: Behind, access: AccessRules, history: HistoryInUse, who: Who) -> None:
    """End a login: its pages are signed out at once, and what it drives stops."""
    found = next((one for one in access.logins.all_logins() if one.id == id), None)
    if found is None:
        raise Problem(404, "There is no such login any more.")
    history.add("logout", who, remark=f"{found.name} was signed out.")
    await end_all(behind, access.logins.revoke_login(id))


@sessions.delete("/keys/{id}", status_code=204)
@needs("admin")
async def revoke_key(id: str, behind: Behind, access: AccessRules, history: HistoryInUse, who: Who) -> None:
    """Revoke a link or a program's key, and end the logins that it opened."""
    found = next((key for key in access.logins.all_keys() if key.id == id), None)
    if found is None:
        raise Problem(404, "There is no such key any more.")
    history.add("logout", who, remark=f"The key {found.name} was revoked.")
    await end_all(behind, access.logins.revoke_key(id))


@sessions.post("/links", status_code=201)
@needs("admin")
async def make_link(
    asked: LinkRequest, behind: Behind, access: AccessRules, history: HistoryInUse, request: Request, who: Who
) -> NewLink:
    """A link for someone else, good for thirty days and over restarts; to drive, or to watch only."""
    if access.no_auth:
        raise Problem(409, "Nobody has to sign in here: give the address alone.")
    token, now = new_token(), time.monotonic()
    key = access.logins.admit(token, called(asked.name) or asked.role, asked.role, "link", now, end=now + LINK_LIFE_S)
    await behind.login_keeper.settle()
    history.add("link", who, remark=f"A link for {key.name}, to {'drive' if key.role == 'operator' else 'watch'}.")
    base = address_for_others(request, access)
    address = f"{base}#t={token}"
    return NewLink(key.id, address, key.end_s or 0.0, qr.rows(address), ALONE if is_here(base) else None)


async def end_all(behind: Behind, gone: list[Person]) -> None:
    """Sign people out, and wait until that is on disk. Raises Unavailable, Unwritable."""
    for person in gone:
        behind.sign_out(person, ENDED)
    await behind.login_keeper.settle()


def address_for_others(request: Request, access: Access) -> str:
    """The address of this console as the reader has it; where that names this machine alone, as others have it."""
    base = f"{request.base_url}{path_of_proxy(request)}"
    return access.address if access.address and is_here(base) else base


def path_of_proxy(request: Request) -> str:
    """Below which path a program on this machine that speaks TLS for us shows the console: "" or "beckon/"."""
    path = request.headers.get("x-forwarded-prefix", "")
    believed = request.client is not None and request.client.host in ON_THIS_MACHINE
    return f"{path[1:]}/" if believed and re.fullmatch(r"(/[A-Za-z0-9._-]+)+", path) else ""


def is_here(address: str) -> bool:
    """Return whether an address leads to the very machine on which it is opened."""
    return address.partition("://")[2].startswith(HERE)
